"""numpy arrays as C arguments.  A returned pointer lives as long as the array it was made from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rvdnav.core.library import ffi, lib
from rvdnav.core.status import check

Records: TypeAlias = NDArray[np.void] | Sequence[Any]
"""Records of a dtype: an array of it, or a sequence of its records or of tuples."""

_ALIGNMENT = 64


def pointer(array: NDArray[Any], kind: str) -> Any:
    """The array's data as a pointer of the C type given; null for an empty array."""
    return ffi.cast(kind, array.ctypes.data) if array.size else ffi.NULL


def aligned_block(size: int) -> tuple[Any, NDArray[np.uint8]]:
    """A void pointer to size bytes of memory, aligned as the core wants it, and the array to keep alive."""
    memory = np.empty(size + _ALIGNMENT, np.uint8)
    offset = -memory.ctypes.data % _ALIGNMENT
    return ffi.cast("void *", memory.ctypes.data + offset), memory


def image_argument(pixels: NDArray[np.uint8]) -> tuple[Any, NDArray[np.uint8]]:
    """An rvdnav_image that borrows the pixels (h, w) where their rows are contiguous, and the array to keep alive.

    Raises ValueError for anything but 8-bit grey.
    """
    if pixels.ndim != 2 or pixels.dtype != np.uint8:
        raise ValueError(f"an image must be 8-bit grey of shape (height, width), not {pixels.dtype} {pixels.shape}")
    if pixels.strides[1] != 1 or pixels.strides[0] < pixels.shape[1]:
        pixels = np.ascontiguousarray(pixels)
    image = ffi.new("rvdnav_image *")
    image.data = ffi.cast("uint8_t *", pixels.ctypes.data)
    image.height, image.width = pixels.shape
    image.stride = pixels.strides[0]
    return image, pixels


def records(values: Records, dtype: np.dtype[np.void]) -> NDArray[np.void]:
    """A contiguous structured array (n,) of the dtype, from records of it."""
    if not isinstance(values, np.ndarray):
        values = list(values)  # numpy would read a tuple as one record
    return np.ascontiguousarray(values, dtype=dtype).reshape(-1)


def points(values: ArrayLike, columns: int) -> NDArray[np.float64]:
    """A contiguous float array (n, columns).  Raises ValueError for another shape."""
    array = np.ascontiguousarray(values, np.float64)
    if array.ndim != 2 or array.shape[1] != columns:
        raise ValueError(f"expected an array of shape (n, {columns}), not {array.shape}")
    return array


def collect(
    call: Callable[[Any, int, Any], int], kind: str, dtype: np.dtype[np.void], capacity: int
) -> NDArray[np.void]:
    """Output of call(pointer, capacity, count): again with more room where the first guess was too small."""
    count = ffi.new("uint32_t *")
    out = np.empty(max(capacity, 1), dtype)
    status = call(pointer(out, kind), len(out), count)
    if status == lib.RVDNAV_ERROR_CAPACITY and count[0] > len(out):
        out = np.empty(count[0], dtype)
        status = call(pointer(out, kind), len(out), count)
    check(status)
    written: NDArray[np.void] = out[: count[0]].copy()
    return written
