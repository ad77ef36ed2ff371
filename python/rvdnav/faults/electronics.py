"""Faults of the sensor and of what processes its images, each with a strength.

Every function returns new pixels uint8 of the shape that it is given, (height, width); see `pixels`.
"""

from __future__ import annotations

import cv2
import numpy as np

from rvdnav.faults.optics import gaussian
from rvdnav.faults.pixels import grey
from rvdnav.faults.view import View
from rvdnav.images import PixelArray
from rvdnav.pose.arrays import FloatArray

_MASK_RADIUS_PX = 1.5


def gamma(pixels: PixelArray, view: View, rng: np.random.Generator, exponent: float) -> PixelArray:
    """A response curve: 255 (grey / 255)^exponent."""
    return grey(255.0 * (pixels / 255.0) ** exponent)


def sharpened(pixels: PixelArray, view: View, rng: np.random.Generator, strength: float) -> PixelArray:
    """An unsharp mask: the difference from the image under a Gaussian of 1.5 px is added `strength` times."""
    return grey(unsharp_masked(pixels.astype(np.float64), strength))


def unsharp_masked(values: FloatArray, strength: float) -> FloatArray:
    """Values (h, w) with `strength` times their difference from the same under a Gaussian of 1.5 px."""
    return values + strength * (values - gaussian(values, _MASK_RADIUS_PX))


def jpeg(pixels: PixelArray, view: View, rng: np.random.Generator, quality: float) -> PixelArray:
    """Compressed as JPEG and read again; quality: of libjpeg's scale, 1 to 100."""
    done, encoded = cv2.imencode(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, round(quality)])
    if not done:
        raise OSError(0, "the image cannot be encoded as JPEG")
    decoded = cv2.imdecode(encoded, cv2.IMREAD_GRAYSCALE)
    assert decoded is not None
    return decoded.astype(np.uint8)


def noise(pixels: PixelArray, view: View, rng: np.random.Generator, sigma: float) -> PixelArray:
    """White normal noise of standard deviation sigma, grey levels."""
    return grey(pixels + sigma * rng.standard_normal(pixels.shape))


def row_noise(pixels: PixelArray, view: View, rng: np.random.Generator, sigma: float) -> PixelArray:
    """Every row lighter or darker as a whole, by a normal number of standard deviation sigma, grey levels."""
    return grey(pixels + sigma * rng.standard_normal((len(pixels), 1)))


def hot_pixels(pixels: PixelArray, view: View, rng: np.random.Generator, permille: float) -> PixelArray:
    """So many of a thousand pixels, the same ones in every frame, at a level of their own between half and full."""
    hot = view.sensor.random(pixels.shape) < 1e-3 * permille
    level = view.sensor.integers(128, 256, pixels.shape, np.uint8)
    result: PixelArray = np.where(hot, np.maximum(pixels, level), pixels)
    return result


def grey_steps(pixels: PixelArray, view: View, rng: np.random.Generator, step: float) -> PixelArray:
    """Grey levels in coarse steps: rounded to multiples of `step`."""
    return grey(step * np.rint(pixels / step))
