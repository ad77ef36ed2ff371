"""Faults of the lens and of the light in it, each with a strength.

Every function returns new pixels uint8 of the shape that it is given, (height, width); see `pixels`.
"""

from __future__ import annotations

import math

import cv2
import numpy as np

from rvdnav.faults.pixels import grey
from rvdnav.faults.view import View
from rvdnav.images import PixelArray
from rvdnav.pose.arrays import FloatArray

_GHOSTS = ((0.35, 0.05), (-0.25, 0.08), (-0.55, 0.04))
"""Discs of a flare: place on the line from the image's centre (0) to the source (1), radius over the diagonal."""


def blurred(pixels: PixelArray, view: View, rng: np.random.Generator, sigma: float) -> PixelArray:
    """Out of focus: a Gaussian of standard deviation sigma, px."""
    return grey(gaussian(pixels.astype(np.float64), sigma))


def motion_blurred(
    pixels: PixelArray, view: View, rng: np.random.Generator, length: float, direction: float | None = None
) -> PixelArray:
    """Exposed while everything moves evenly by `length`, px, the stamp being the middle of the exposure.

    direction: in the image, degrees from the rows towards the columns; by default that in which the target moves, and
    along the rows where it doesn't.
    """
    angle = math.atan2(*view.motion()[::-1]) if direction is None else math.radians(direction)
    smeared = cv2.filter2D(pixels, cv2.CV_64F, _segment(length, angle), borderType=cv2.BORDER_REPLICATE)
    return grey(smeared.astype(np.float64))


def flare(pixels: PixelArray, view: View, rng: np.random.Generator, level: float) -> PixelArray:
    """A lamp beyond the upper right corner: light over the whole image, `level` grey levels in that corner and a tenth
    in the opposite one, and three ghosts of half that level on the line through the image's centre."""
    y, x = _from_centre(pixels)
    corner = np.array([x[0, -1], y[0, -1]])
    diagonal = 2.0 * float(np.hypot(*corner))
    distance = np.hypot(x - corner[0], y - corner[1]) / diagonal
    light = level * 0.1**distance
    for place, radius in _GHOSTS:
        edge = radius * diagonal - np.hypot(x - place * corner[0], y - place * corner[1])
        light += 0.5 * level * np.clip(0.5 * edge + 0.5, 0.0, 1.0)
    return grey(pixels + light)


def vignetted(pixels: PixelArray, view: View, rng: np.random.Generator, loss: float) -> PixelArray:
    """Darker towards the corners, by the fraction `loss` in them, with the square of the distance from the centre."""
    y, x = _from_centre(pixels)
    squared = x**2 + y**2
    return grey(pixels * (1.0 - loss * squared / squared.max()))


def gaussian(values: FloatArray, sigma: float) -> FloatArray:
    """Values (h, w) under a Gaussian of standard deviation sigma, px, cut at four of them."""
    size = 2 * math.ceil(4.0 * sigma) + 1
    return cv2.GaussianBlur(values, (size, size), sigma, borderType=cv2.BORDER_REPLICATE).astype(np.float64)


def _from_centre(pixels: PixelArray) -> FloatArray:
    """y and x (2, h, w) from the image's centre, px."""
    return np.indices(pixels.shape) - 0.5 * (np.array(pixels.shape)[:, None, None] - 1.0)


def _segment(length: float, angle: float) -> FloatArray:
    """An even line through the middle of a kernel, px and rad; its points are shared among the four pixels around."""
    half = math.ceil(0.5 * length) + 1
    t = length * ((np.arange(256) + 0.5) / 256 - 0.5)
    x, y = half + t * math.cos(angle), half + t * math.sin(angle)
    kernel = np.zeros((2 * half + 1, 2 * half + 1))
    column, row = np.floor(x).astype(int), np.floor(y).astype(int)
    for dy in (0, 1):
        for dx in (0, 1):
            weight = (1.0 - np.abs(x - column - dx)) * (1.0 - np.abs(y - row - dy))
            np.add.at(kernel, (row + dy, column + dx), weight / len(t))
    return kernel
