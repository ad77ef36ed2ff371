"""Faults of one image: functions of its pixels, of its circumstances, and of a seeded generator.

Every function returns new pixels uint8 of the shape that it is given, (height, width).
"""

from __future__ import annotations

import cv2
import numpy as np

from rvdnav.faults.view import View
from rvdnav.images import PixelArray
from rvdnav.pose.arrays import FloatArray

_ARM_GREY = 110.0
_ARM_ROUNDNESS = 60.0
# Second difference of second differences; on white noise of deviation s it has the deviation 6 s, on straight edges 0.
_NOISE_KERNEL = np.array([[1.0, -2.0, 1.0], [-2.0, 4.0, -2.0], [1.0, -2.0, 1.0]])
_NOISE_GAIN = 6.0
_MEDIAN_OF_NORMAL = 0.6745


def black(pixels: PixelArray, view: View, rng: np.random.Generator) -> PixelArray:
    """No light at all."""
    return np.zeros_like(pixels)


def saturated(pixels: PixelArray, view: View, rng: np.random.Generator) -> PixelArray:
    """Every pixel at its limit."""
    return np.full_like(pixels, 255)


def glare(pixels: PixelArray, view: View, rng: np.random.Generator) -> PixelArray:
    """A reflex at the target's upper right corner, saturated within a quarter of its size, with a wide skirt."""
    y, x = np.indices(pixels.shape)
    region = view.region
    radius = 0.25 * max(region.width, region.height)
    distance = np.hypot(x - region.x1, y - region.y0) / radius
    return grey(pixels + 255.0 * np.exp(0.5 - 0.5 * distance**2))


def occluder_middle(pixels: PixelArray, view: View, rng: np.random.Generator) -> PixelArray:
    """An arm from the upper border across the image, over the middle third of the target's width."""
    region = view.region
    return _arm(pixels, region.x0 + region.width / 3.0, region.x0 + region.width / 1.5)


def occluder_side(pixels: PixelArray, view: View, rng: np.random.Generator) -> PixelArray:
    """The same arm over the left third of the target's width, which hides a whole bar."""
    region = view.region
    return _arm(pixels, region.x0, region.x0 + region.width / 3.0)


def noise_x4(pixels: PixelArray, view: View, rng: np.random.Generator) -> PixelArray:
    """Normal noise added such that the total is four times what the image has."""
    return grey(pixels + np.sqrt(15.0) * noise_sigma(pixels) * rng.standard_normal(pixels.shape))


def gain_0_3(pixels: PixelArray, view: View, rng: np.random.Generator) -> PixelArray:
    """Exposed at three tenths."""
    return grey(0.3 * pixels.astype(np.float64))


def gain_2(pixels: PixelArray, view: View, rng: np.random.Generator) -> PixelArray:
    """Exposed twice as long."""
    return grey(2.0 * pixels.astype(np.float64))


def corrupted_rows(pixels: PixelArray, view: View, rng: np.random.Generator) -> PixelArray:
    """Random bytes in a band of rows, a fifth of the target's height, through its middle."""
    result: PixelArray = pixels.copy()
    region = view.region
    middle, half = 0.5 * (region.y0 + region.y1), 0.1 * region.height
    y0, y1 = np.clip([round(middle - half), round(middle + half)], 0, len(pixels))
    result[y0:y1] = rng.integers(0, 256, result[y0:y1].shape, np.uint8)
    return result


def noise_sigma(pixels: PixelArray) -> float:
    """Standard deviation of an image's noise, grey levels.

    After J. Immerkær, "Fast noise variance estimation", CVIU 64 (1996), with the median in place of the mean.
    """
    response = np.abs(cv2.filter2D(pixels, cv2.CV_64F, _NOISE_KERNEL)[1:-1, 1:-1])
    # The responses are whole numbers; within the median's own one, the median is taken as of a histogram's class.
    middle = float(np.median(response))
    below, same = float(np.mean(response < middle)), float(np.mean(response == middle))
    median = middle - 0.5 + (0.5 - below) / same if same else middle
    return max(median, 0.0) / (_MEDIAN_OF_NORMAL * _NOISE_GAIN)


def _arm(pixels: PixelArray, x0: float, x1: float) -> PixelArray:
    """A round arm along the columns: [x0, x1), lighter along its middle."""
    x = np.arange(pixels.shape[1], dtype=np.float64)
    across = (x + 0.5 - x0) / (x1 - x0)
    shade = _ARM_GREY + _ARM_ROUNDNESS * (1.0 - (2.0 * across - 1.0) ** 2)
    hidden = (x >= x0) & (x < x1)
    result: PixelArray = np.where(hidden, grey(shade), pixels)
    return result


def grey(values: FloatArray) -> PixelArray:
    """Values as grey levels: rounded and cut to 0..255."""
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
