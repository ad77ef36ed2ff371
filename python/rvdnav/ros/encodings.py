"""The pixels of sensor_msgs/Image: encodings that are read, as `sensor_msgs/image_encodings.hpp` names them."""

from __future__ import annotations

from typing import cast

import attrs
import cv2
import numpy as np
from numpy.typing import DTypeLike

from rvdnav.images import ImageError, LevelArray, Raster


@attrs.frozen
class _Encoding:
    stored: DTypeLike
    channels: int = 1
    to_grey: int | None = None


ENCODINGS = {
    "mono8": _Encoding(np.uint8),
    "mono16": _Encoding(np.uint16),
    "8UC1": _Encoding(np.uint8),
    "16UC1": _Encoding(np.uint16),
    "bgr8": _Encoding(np.uint8, 3, cv2.COLOR_BGR2GRAY),
    "rgb8": _Encoding(np.uint8, 3, cv2.COLOR_RGB2GRAY),
    "bgra8": _Encoding(np.uint8, 4, cv2.COLOR_BGRA2GRAY),
    "rgba8": _Encoding(np.uint8, 4, cv2.COLOR_RGBA2GRAY),
}


def decode_pixels(data: bytes, encoding: str, size: tuple[int, int], *, step: int, big_endian: bool) -> Raster:
    """The image that a message's data are, one of `ENCODINGS`.

    size: width and height, px.  step: bytes from a row to the next one.  Raises ImageError when the data are too few.
    """
    width, height = size
    kind = ENCODINGS[encoding]
    stored = np.dtype(kind.stored).newbyteorder(">" if big_endian else "<")
    row = width * kind.channels * stored.itemsize
    if step < row:
        raise ImageError(f"has rows of {step} bytes where {row} are needed")
    if len(data) < step * height:
        raise ImageError("is truncated")
    rows = np.frombuffer(data, np.uint8, step * height).reshape(height, step)[:, :row]
    levels = np.ascontiguousarray(rows).view(stored).astype(kind.stored)
    if kind.to_grey is None:
        return Raster(cast(LevelArray, levels))
    grey = cv2.cvtColor(levels.reshape(height, width, kind.channels), kind.to_grey)
    return Raster(cast(LevelArray, grey), colour=True)
