"""Grey images and the files that they come from: one reader for all, which gives the pixels as the sensor did."""

from __future__ import annotations

from pathlib import Path
from typing import cast

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from rvdnav.files import open_plain
from rvdnav.image_header import PNG_SIGNATURE, Header, ImageError, parse_header, png_chunks, png_orientation

__all__ = ["Image", "ImageError", "PixelArray", "Raster", "decode_image", "image_size", "png_bytes", "read_image"]

PixelArray = NDArray[np.uint8]
LevelArray = NDArray[np.uint8] | NDArray[np.uint16]

_LARGEST_FILE = 256 << 20
# Of 16-bit images: levels; share of the pixels that may be brighter than what white follows from, and how far above
# that it is; white of a sensor of 10 bits.
_LEVELS = 1 << 16
_BEYOND_WHITE = 1e-3
_HEADROOM = 1.25
_LEAST_WHITE = 1023
_PNG_HEADER = 26
_PNG_ESSENTIAL = {b"IHDR", b"PLTE", b"IDAT", b"IEND"}
_STORED = cv2.IMREAD_GRAYSCALE | cv2.IMREAD_ANYDEPTH | cv2.IMREAD_IGNORE_ORIENTATION
cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # a file at fault is told in our words, once


def _pixels(value: PixelArray) -> PixelArray:
    if value.dtype != np.uint8 or value.ndim != 2:
        raise ValueError(f"an image is uint8 (height, width), not {value.dtype} {value.shape}")
    return np.ascontiguousarray(value)


@attrs.frozen
class Image:
    """An 8-bit grey image: pixels uint8 (height, width), C-contiguous, and its own timestamp, ns.

    Raises ValueError for pixels of another type or number of dimensions.
    """

    pixels: PixelArray = attrs.field(converter=_pixels, eq=attrs.cmp_using(eq=np.array_equal), repr=False)
    timestamp_ns: int


@attrs.frozen(eq=False)
class Raster:
    """What an image file holds: grey levels uint8 or uint16 (height, width), the latter up to 65535 for white.

    colour: whether the file's pixels had colours.  orientation: what EXIF says that a viewer should do with them, 1 for
    nothing; the pixels are as they are stored, for that is how the camera was calibrated.
    """

    pixels: LevelArray
    colour: bool = False
    orientation: int = 1

    @property
    def grey8(self) -> PixelArray:
        """The pixels in 8 bits.

        Of 16-bit values the scale follows the image, for sensors of 10 or 12 bits leave most of the range empty, and so
        does a dark scene: white is a quarter above what all but a thousandth of the pixels stay below, 1023 at least.
        """
        if self.pixels.dtype == np.uint8:
            return np.ascontiguousarray(self.pixels, dtype=np.uint8)
        count = np.cumsum(np.bincount(self.pixels.ravel(), minlength=_LEVELS))
        brightest = int(np.searchsorted(count, (1.0 - _BEYOND_WHITE) * self.pixels.size))
        white = min(max(int(_HEADROOM * brightest), _LEAST_WHITE), _LEVELS - 1)
        scale = np.minimum((510 * np.arange(_LEVELS) + white) // (2 * white), 255).astype(np.uint8)
        return np.asarray(scale[self.pixels], np.uint8)

    @property
    def conversion(self) -> str | None:
        """What `grey8` makes of the file's pixels, for the user; None where it has them as they are."""
        kinds = ["colour"] * self.colour + ["16-bit"] * (self.pixels.dtype == np.uint16)
        return f"{' '.join(kinds)} images are converted to 8-bit grey" if kinds else None

    @property
    def ignored_orientation(self) -> str | None:
        """That the file wants to be shown turned, for the user; None where it doesn't."""
        if self.orientation == 1:
            return None
        return f"EXIF orientation {self.orientation} is ignored, the pixels are taken as stored"


def image_size(path: Path) -> tuple[int, int]:
    """Width and height, px, from the header of an image file.  Raises ImageError when it has none."""
    header = parse_header(_bytes(path, header_alone=True))
    return header.width, header.height


def read_image(path: Path) -> Raster:
    """The grey image in a PNG, JPEG, TIFF, BMP or PGM file, told by its contents.

    Raises ImageError when the file is unreadable, truncated, corrupt or larger than any camera's.
    """
    return decode_image(_bytes(path))


def decode_image(data: bytes) -> Raster:
    """The grey image in a file's bytes.  Raises ImageError as `read_image` does."""
    header = parse_header(data)
    if header.kind == "PGM":
        return _read_pgm(header, data)
    if header.kind == "PNG":
        return _read_png(data)
    if header.orientation_at is not None:  # OpenCV turns TIFF images whatever it is told
        data = _upright(data, header.orientation_at)
    return Raster(_decoded(data, _STORED, header), orientation=header.orientation)


def png_bytes(pixels: PixelArray) -> bytes:
    """An image (h, w) as a PNG file.  Raises OSError when it cannot be encoded."""
    done, encoded = cv2.imencode(".png", pixels)
    if not done:
        raise OSError(0, "the image cannot be encoded as PNG")
    return encoded.tobytes()


def _bytes(path: Path, header_alone: bool = False) -> bytes:
    try:
        with open_plain(path) as file:
            data = file.read(_PNG_HEADER)
            if not (header_alone and data.startswith(PNG_SIGNATURE)):
                data += file.read(_LARGEST_FILE + 1)
    except OSError as error:
        raise ImageError(f"cannot be read ({error.strerror})") from error
    if len(data) > _LARGEST_FILE:
        raise ImageError(f"is larger than {_LARGEST_FILE >> 20} MB")
    return data


def _decoded(data: bytes, flags: int, header: Header) -> LevelArray:
    try:
        decoded = cv2.imdecode(np.frombuffer(data, np.uint8), flags)
    except (cv2.error, SystemError) as error:
        raise ImageError("cannot be decoded") from error
    if decoded is None or decoded.dtype not in (np.uint8, np.uint16):
        raise ImageError("cannot be decoded")
    if decoded.shape[:2] != (header.height, header.width):
        raise ImageError("is not of the size that its header says")
    return cast(LevelArray, decoded)


def _read_png(data: bytes) -> Raster:
    """The decoder is given what makes the pixels alone."""
    orientation, essential = 1, [PNG_SIGNATURE]
    position = len(PNG_SIGNATURE)
    for name, contents in png_chunks(data):
        end = position + 12 + len(contents)
        if name in _PNG_ESSENTIAL:
            essential.append(data[position:end])
        elif name == b"eXIf":
            orientation = png_orientation(contents)
        position = end
    pixels = _decoded(b"".join(essential), cv2.IMREAD_UNCHANGED, parse_header(data))
    if pixels.ndim == 2:
        return Raster(pixels, orientation=orientation)
    code = cv2.COLOR_BGRA2GRAY if pixels.shape[2] == 4 else cv2.COLOR_BGR2GRAY
    grey = cast(LevelArray, cv2.cvtColor(pixels, code))
    return Raster(grey, colour=True, orientation=orientation)


def _read_pgm(header: Header, data: bytes) -> Raster:
    """Plain or raw; levels are scaled so that white is the largest of their type, as the format means them."""
    count, largest = header.width * header.height, header.largest
    if data.startswith(b"P2"):
        words = data[header.pixels_at :].split(maxsplit=count)[:count]
        if not all(len(word) <= 5 and word.isdigit() for word in words):
            raise ImageError("is corrupt")
        levels = np.array(words, dtype="S5").astype(np.uint32)
    else:
        stored = np.dtype(np.uint8 if largest < 256 else ">u2")
        levels = np.frombuffer(
            data, stored, min(count, (len(data) - header.pixels_at) // stored.itemsize), header.pixels_at
        )
    if levels.size < count:
        raise ImageError("is truncated")
    kind, white = (np.uint8, 255) if largest < 256 else (np.uint16, 65535)
    if largest != white:
        levels = (np.minimum(levels, largest).astype(np.uint32) * white + largest // 2) // largest
    return Raster(cast(LevelArray, levels.astype(kind).reshape(header.height, header.width)))


def _upright(data: bytes, orientation_at: slice) -> bytes:
    turned = bytearray(data)
    turned[orientation_at] = b"\1\0" if data.startswith(b"II") else b"\0\1"
    return bytes(turned)
