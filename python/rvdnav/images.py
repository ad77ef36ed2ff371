"""Grey images and the PNG files that they come from."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

PixelArray = NDArray[np.uint8]

_SIGNATURE = b"\x89PNG\r\n\x1a\n"


class ImageError(ValueError):
    """A file that holds no whole PNG image; the message says why, without naming it."""


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


def png_size(path: Path) -> tuple[int, int]:
    """Width and height, px, from the header of a PNG file.  Raises ImageError when it has none."""
    try:
        with path.open("rb") as file:
            header = file.read(24)
    except OSError as error:
        raise ImageError(f"cannot be read ({error.strerror})") from error
    if len(header) < 24 or not header.startswith(_SIGNATURE) or header[12:16] != b"IHDR":
        raise ImageError("is not a PNG image")
    width, height = struct.unpack(">II", header[16:24])
    return width, height


def read_png(path: Path) -> tuple[PixelArray, str | None]:
    """The 8-bit grey pixels (height, width) of a PNG file, and from what they were converted, if from something else.

    16-bit values are scaled by 255/65535.  Raises ImageError when the file is unreadable, truncated or corrupt.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ImageError(f"cannot be read ({error.strerror})") from error
    _check_whole(data)
    try:
        decoded = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error as error:
        raise ImageError("cannot be decoded") from error
    if decoded is None:
        raise ImageError("cannot be decoded")
    kinds = []
    if decoded.ndim == 3:
        kinds.append("colour")
        code = cv2.COLOR_BGRA2GRAY if decoded.shape[2] == 4 else cv2.COLOR_BGR2GRAY
        decoded = cv2.cvtColor(decoded, code)
    if decoded.dtype == np.uint16:
        kinds.append("16-bit")
        decoded = (decoded.astype(np.uint32) + 128) // 257
    return decoded.astype(np.uint8), " ".join(kinds) or None


def png_bytes(pixels: PixelArray) -> bytes:
    """An image (h, w) as a PNG file.  Raises OSError when it cannot be encoded."""
    done, encoded = cv2.imencode(".png", pixels)
    if not done:
        raise OSError(0, "the image cannot be encoded as PNG")
    return encoded.tobytes()


def _check_whole(data: bytes) -> None:
    """Raise ImageError unless every chunk of a PNG is there and carries its checksum.

    The decoder alone would fill what is missing with black and say nothing.
    """
    if not data.startswith(_SIGNATURE):
        raise ImageError("is not a PNG image")
    view = memoryview(data)
    position = len(_SIGNATURE)
    while position + 12 <= len(data):
        (length,) = struct.unpack_from(">I", data, position)
        end = position + 12 + length
        if end > len(data):
            break
        (checksum,) = struct.unpack_from(">I", data, end - 4)
        if zlib.crc32(view[position + 4 : end - 4]) != checksum:
            raise ImageError("is corrupt")
        if data[position + 4 : position + 8] == b"IEND":
            return
        position = end
    raise ImageError("is truncated")
