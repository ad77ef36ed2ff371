"""Array types and shape checks shared by the pose mathematics."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.int64]


def float_array(values: ArrayLike, *shape: int | None) -> FloatArray:
    """`values` as float64 of `shape` (None: any length).

    Raises ValueError if the shape is another or a number is not finite.
    """
    array = np.asarray(values, dtype=np.float64)
    if array.ndim != len(shape) or any(want not in (None, got) for want, got in zip(shape, array.shape, strict=True)):
        wanted = tuple("n" if length is None else length for length in shape)
        raise ValueError(f"array of shape {array.shape} where {wanted} is needed")
    if not np.isfinite(array).all():
        raise ValueError("array holds a number that is not finite")
    return array
