"""What the headers of image files say, read by ourselves before a decoder sees the file: kind, size, orientation.

PNG (ISO/IEC 15948), JPEG (ITU-T T.81), TIFF 6.0, BMP and PGM.  Orientation is that of EXIF (CIPA DC-008).
"""

from __future__ import annotations

import re
import struct
import zlib
from collections.abc import Iterator

import attrs

_LONGEST_SIDE = 16384
_MOST_BYTES = 150 << 20
"""Of the decoded image: 50 megapixels in colour."""
_MOST_SCANS = 30
"""Of a progressive JPEG, which takes as many passes over the whole image; cameras write one, web tools ten."""
_ORIENTATION = 274
_UPRIGHT = 1
_PLAIN_BYTES = 64
"""What each pixel of a plain PGM takes as a word of its own."""
PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_TIFF_SIGNATURES = {b"II*\0": "<", b"MM\0*": ">"}
_TIFF_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8}
_TIFF_SIDES = (256, 257, 322, 323)
"""Tags of the width and the height of the image and of its tiles."""
_PGM = re.compile(rb"P[25](?:\s|#[^\n]*\n)+(\d{1,9})(?:\s|#[^\n]*\n)+(\d{1,9})(?:\s|#[^\n]*\n)+(\d{1,5})\s")


class ImageError(ValueError):
    """A file that holds no whole image; the message says why, without naming it."""


@attrs.frozen
class Header:
    """Of an image file.

    width, height: px.  orientation: 1 for upright, up to 8, how a viewer would have to turn it.  orientation_at: where
    a TIFF file holds that number.  pixels_at, largest: of a PGM file, where its pixels begin and what white is.
    """

    kind: str
    width: int
    height: int
    orientation: int = _UPRIGHT
    orientation_at: slice | None = None
    pixels_at: int = 0
    largest: int = 255


def parse_header(data: bytes) -> Header:
    """The header at the beginning of a file's bytes, which need not be the whole file for PNG and PGM.

    Raises ImageError for a file that is none of these, and for an image larger than anyone's, before anything of its
    size is allocated.
    """
    for signature, parse in _PARSERS:
        if data.startswith(signature):
            try:
                return parse(data)
            except (struct.error, IndexError) as error:
                raise ImageError("is truncated") from error
    raise ImageError(
        "is not a PNG image" if data[:1] in (b"", b"\x89") else "is not a PNG, JPEG, TIFF, BMP or PGM image"
    )


def _checked(header: Header, bytes_per_pixel: int) -> Header:
    width, height = header.width, header.height
    if not (0 < width <= _LONGEST_SIDE and 0 < height <= _LONGEST_SIDE) or (
        width * height * bytes_per_pixel > _MOST_BYTES
    ):
        raise ImageError(f"is an image of {width}x{height} pixels, which is none of a camera")
    return header


def png_chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Name and contents of every chunk of a PNG file, to the last, IEND.

    Raises ImageError where one is missing or doesn't carry its checksum: a decoder fills what is missing with black.
    """
    view = memoryview(data)
    position = len(PNG_SIGNATURE)
    while position + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, position)
        end = position + 12 + length
        if end > len(data):
            break
        (checksum,) = struct.unpack_from(">I", data, end - 4)
        if zlib.crc32(view[position + 4 : end - 4]) != checksum:
            raise ImageError("is corrupt")
        name = data[position + 4 : position + 8]
        yield name, data[position + 8 : end - 4]
        if name == b"IEND":
            return
        position = end
    raise ImageError("is truncated")


def _png(data: bytes) -> Header:
    if len(data) < 26 or data[12:16] != b"IHDR":
        raise ImageError("is not a PNG image")
    width, height, depth, colour = struct.unpack_from(">IIBB", data, 16)
    channels = {0: 1, 2: 3, 3: 3, 4: 4, 6: 4}.get(colour, 0)
    if channels == 0 or depth not in (1, 2, 4, 8, 16):
        raise ImageError("is corrupt")
    return _checked(Header("PNG", width, height), channels * (2 if depth == 16 else 1))


def png_orientation(exif: bytes) -> int:
    """What the contents of a PNG's chunk eXIf say; upright where they say nothing that is understood."""
    try:
        return _tiff_tags(exif).get(_ORIENTATION, (_UPRIGHT, 0))[0]
    except (ImageError, struct.error):
        return _UPRIGHT


def _jpeg(data: bytes) -> Header:
    """Walk the segments up to the first scan."""
    if data.count(b"\xff\xda") > _MOST_SCANS:
        raise ImageError(f"has more than {_MOST_SCANS} scans")
    position, orientation = 2, _UPRIGHT
    header: Header | None = None
    while True:
        if data[position] != 0xFF:
            raise ImageError("is corrupt")
        marker = data[position + 1]
        if marker == 0xFF:  # filling
            position += 1
            continue
        (length,) = struct.unpack_from(">H", data, position + 2)
        if marker == 0xE1 and data[position + 4 : position + 10] == b"Exif\0\0":
            orientation = png_orientation(data[position + 10 : position + 2 + length])
        elif 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            if header is not None:
                raise ImageError("is corrupt")
            _, height, width, components = struct.unpack_from(">BHHB", data, position + 4)
            header = _checked(Header("JPEG", width, height), components)
        elif marker == 0xDA:
            break
        position += 2 + max(length, 2)
    if header is None:
        raise ImageError("is corrupt")
    if b"\xff\xd9" not in data[position:]:
        raise ImageError("is truncated")
    return attrs.evolve(header, orientation=orientation)


def _tiff_tags(data: bytes) -> dict[int, tuple[int, int]]:
    """The first number of each tag of the first directory, where it is one, and where it stands."""
    order = _TIFF_SIGNATURES.get(data[:4])
    if order is None:
        raise ImageError("is corrupt")
    (directory,) = struct.unpack_from(f"{order}I", data, 4)
    (count,) = struct.unpack_from(f"{order}H", data, directory)
    tags: dict[int, tuple[int, int]] = {}
    for entry in range(directory + 2, directory + 2 + 12 * count, 12):
        tag, kind, number = struct.unpack_from(f"{order}HHI", data, entry)
        if kind not in _TIFF_SIZES or tag in tags:
            raise ImageError("is corrupt")
        inline = _TIFF_SIZES[kind] * number <= 4
        at = entry + 8 if inline else struct.unpack_from(f"{order}I", data, entry + 8)[0]
        if at + _TIFF_SIZES[kind] * number > len(data):
            raise ImageError("is truncated")
        if kind in (1, 3, 4) and number > 0:
            tags[tag] = (struct.unpack_from(order + {1: "B", 3: "H", 4: "I"}[kind], data, at)[0], at)
    return tags


def _tiff(data: bytes) -> Header:
    order = _TIFF_SIGNATURES[data[:4]]
    tags = _tiff_tags(data)
    sides = [tags.get(tag, (1, 0))[0] for tag in _TIFF_SIDES]
    bits, samples = (tags.get(tag, (1, 0))[0] for tag in (258, 277))
    if bits not in (1, 2, 4, 8, 16) or not 1 <= samples <= 4 or tags.get(339, (1, 0))[0] != 1:
        raise ImageError("has pixels that are no whole numbers of 8 or 16 bits")
    _checked(Header("TIFF", sides[2], sides[3]), 4)
    orientation, at = tags.get(_ORIENTATION, (_UPRIGHT, 0))
    place = slice(at, at + 2) if at and order else None
    return _checked(Header("TIFF", sides[0], sides[1], orientation, place), max(samples, 4) * (2 if bits == 16 else 1))


def _bmp(data: bytes) -> Header:
    (size,) = struct.unpack_from("<I", data, 14)
    if size < 40:
        raise ImageError("is a BMP image of a kind that is not read")
    width, height, _, bits = struct.unpack_from("<iiHH", data, 18)
    if bits not in (1, 4, 8, 16, 24, 32):
        raise ImageError("is corrupt")
    return _checked(Header("BMP", width, abs(height)), 4)


def _pgm(data: bytes) -> Header:
    match = _PGM.match(data[:1024])
    if match is None:
        raise ImageError("is corrupt")
    width, height, largest = map(int, match.groups())
    if not 0 < largest <= 65535:
        raise ImageError("is corrupt")
    header = Header("PGM", width, height, pixels_at=match.end(), largest=largest)
    return _checked(header, _PLAIN_BYTES if data[1:2] == b"2" else 2)


_PARSERS = (
    (PNG_SIGNATURE, _png),
    (b"\xff\xd8\xff", _jpeg),
    *((signature, _tiff) for signature in _TIFF_SIGNATURES),
    (b"BM", _bmp),
    (b"P5", _pgm),
    (b"P2", _pgm),
)
