"""From light to 8-bit pixels: blur, stars, vignetting, unequal pixels, noise, response, sharpening."""

from __future__ import annotations

import math

import cv2
import numpy as np

from rvdnav.camera import CameraModel
from rvdnav.faults.electronics import unsharp_masked
from rvdnav.images import PixelArray
from rvdnav.pose.arrays import FloatArray
from rvdnav.simulation.render import LightImage
from rvdnav.simulation.scenario import Sensor

_STAR_RADIUS_PX = 5


def point_images(sensor: Sensor, uv: FloatArray, brightness: FloatArray, shape: tuple[int, int]) -> FloatArray:
    """The images (h, w), DN, of points of light at uv (n, 2), px, each summing to its brightness (n,), DN.

    NaN stands for a point that is not imaged.
    """
    image = np.zeros(shape)
    height, width = shape
    seen = ((uv > -_STAR_RADIUS_PX) & (uv < np.array([width, height]) + _STAR_RADIUS_PX)).all(axis=1)  # NaN is not
    for (u, v), total in zip(uv[seen].tolist(), brightness[seen].tolist(), strict=True):
        columns = np.arange(max(0, round(u) - _STAR_RADIUS_PX), min(width, round(u) + _STAR_RADIUS_PX + 1))
        rows = np.arange(max(0, round(v) - _STAR_RADIUS_PX), min(height, round(v) + _STAR_RADIUS_PX + 1))
        if len(columns) and len(rows):
            spread = np.outer(_gaussian(rows - v, sensor.psf_sigma), _gaussian(columns - u, sensor.psf_sigma))
            image[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1] += total * spread
    return image


def _gaussian(offsets: FloatArray, sigma: float) -> FloatArray:
    """The share of a point's light in pixels at these offsets from it, px."""
    edges = np.concatenate([offsets - 0.5, offsets[-1:] + 0.5])
    steps = np.array([_normal_cdf(edge / max(sigma, 1e-3)) for edge in edges])
    share: FloatArray = np.diff(steps)
    return share


def _normal_cdf(value: float) -> float:
    return 0.5 * (1.0 + math.erf(value / 2.0**0.5))


def expose(
    sensor: Sensor, light: LightImage, stars: FloatArray, gains: FloatArray, rng: np.random.Generator
) -> PixelArray:
    """The image (h, w) that the sensor gives of the light.

    stars (h, w): their light, DN, where nothing covers them.  gains (h, w): of the pixels, see `pixel_gains`.
    """
    signal = sensor.level * light.signal
    if sensor.psf_sigma > 0.0:
        blurred = cv2.GaussianBlur(signal, (0, 0), sensor.psf_sigma, borderType=cv2.BORDER_REPLICATE)
        signal = blurred.astype(np.float64)
    signal = np.maximum(signal + stars * light.sky, 0.0) * gains
    sigma = np.sqrt(sensor.read_noise**2 + sensor.shot_noise * signal)
    noisy = sensor.black_level + signal + sigma * rng.standard_normal(signal.shape)
    if sensor.gamma != 1.0:
        noisy = 255.0 * np.clip(noisy / 255.0, 0.0, 1.0) ** sensor.gamma
    if sensor.sharpening > 0.0:
        noisy = unsharp_masked(np.clip(noisy, 0.0, 255.0), sensor.sharpening)
    return np.clip(np.rint(noisy), 0.0, 255.0).astype(np.uint8)


def pixel_gains(sensor: Sensor, camera: CameraModel, rng: np.random.Generator) -> FloatArray:
    """What every pixel (h, w) makes of the same light: vignetting about the principal point, and PRNU."""
    u, v = np.meshgrid(np.arange(camera.width) - camera.cx, np.arange(camera.height) - camera.cy)
    corner2 = (camera.width / 2.0) ** 2 + (camera.height / 2.0) ** 2
    falloff = np.maximum(1.0 - sensor.vignetting * (u * u + v * v) / corner2, 0.0)
    gains: FloatArray = falloff * (1.0 + sensor.prnu * rng.standard_normal(u.shape))
    return gains
