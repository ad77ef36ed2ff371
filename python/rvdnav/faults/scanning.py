"""Faults of the order in which rows are exposed: fields, rolling shutter.

Every function returns new pixels uint8 of the shape that it is given, (height, width); see `pixels`.  The top field
has the rows 0, 2, 4 …, the bottom field the others.
"""

from __future__ import annotations

import cv2
import numpy as np

from rvdnav.faults.view import View
from rvdnav.images import PixelArray

_NS_PER_MS = 1e6


def interlaced(pixels: PixelArray, view: View, rng: np.random.Generator, delay_ms: float) -> PixelArray:
    """The top field at the stamp, the bottom field later by delay_ms, or earlier where that is negative."""
    return _woven(pixels, view.later(pixels, round(delay_ms * _NS_PER_MS)))


def interlaced_bottom(pixels: PixelArray, view: View, rng: np.random.Generator, delay_ms: float) -> PixelArray:
    """The bottom field at the stamp, the top field later by delay_ms, or earlier where that is negative."""
    return _woven(view.later(pixels, round(delay_ms * _NS_PER_MS)), pixels)


def field_doubled(pixels: PixelArray, view: View, rng: np.random.Generator) -> PixelArray:
    """Every row of the top field twice."""
    return _woven(pixels, np.repeat(pixels[::2], 2, axis=0)[: len(pixels)])


def rolling_shutter(pixels: PixelArray, view: View, rng: np.random.Generator, shear: float) -> PixelArray:
    """Everything moves evenly along the rows while they are exposed one after the other, by `shear`, px, from the first
    row to the last; the middle row is exposed at the stamp."""
    height, width = pixels.shape
    slope = shear / max(height - 1, 1)
    matrix = np.array([[1.0, slope, -0.5 * shear], [0.0, 1.0, 0.0]])
    sheared: PixelArray = cv2.warpAffine(
        pixels, matrix, (width, height), flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
    ).astype(np.uint8)
    return sheared


def _woven(top: PixelArray, bottom: PixelArray) -> PixelArray:
    result: PixelArray = top.copy()
    result[1::2] = bottom[1::2]
    return result
