"""What is behind the target: stars as points, and the map of light that comes from all around."""

from __future__ import annotations

import numpy as np

from rvdnav.pose.arrays import BoolArray, FloatArray
from rvdnav.simulation.mesh import TextureArray
from rvdnav.simulation.textures import Rng, smooth_noise

MAP_SHAPE = (1024, 2048)
_EARTH_RADIUS_M, _ALTITUDE_M, _AIR_M = 6371e3, 500e3, 12e3
_HAZE = 0.35
_STARS = 2500
_FAINTEST, _BRIGHTEST = 40.0, 2500.0
"""Digital numbers that a star gives, summed over its image."""


def stars(rng: Rng) -> tuple[FloatArray, FloatArray]:
    """Directions (n, 3) in W, all around, and brightness (n,), DN summed over the image; many faint, few bright."""
    directions = rng.standard_normal((_STARS, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    brightness = np.minimum(_FAINTEST * (1.0 - rng.random(_STARS)) ** -0.9, _BRIGHTEST)
    return directions, brightness


def map_directions() -> FloatArray:
    """Directions (h, w, 3) of the map's pixels.  A row runs from the pole +y down to -y; the azimuth from -z over +x,
    +z and -x, as Mitsuba's `envmap` has it."""
    rows, columns = MAP_SHAPE
    polar = np.pi * (np.arange(rows) + 0.5) / rows
    azimuth = 2.0 * np.pi * (np.arange(columns) + 0.5) / columns
    sine = np.sin(polar)[:, None]
    return np.stack(
        [sine * np.sin(azimuth), np.broadcast_to(np.cos(polar)[:, None], MAP_SHAPE), -sine * np.cos(azimuth)], axis=2
    )


def earth(directions: FloatArray, nadir: FloatArray, towards_sun: FloatArray, rng: Rng) -> TextureArray:
    """Radiance (h, w) of the Earth 500 km below in units of that of a white surface in full sun: clouds, and air at
    the limb.

    directions (h, w, 3), nadir (3,) and towards_sun (3,) are unit vectors in one frame.
    """
    radius = _EARTH_RADIUS_M + _ALTITUDE_M
    cosine = directions @ nadir
    tangent = radius * np.sqrt(np.maximum(0.0, 1.0 - cosine**2))  # the ray's least distance from the centre
    half_chord = np.sqrt(np.maximum(0.0, _EARTH_RADIUS_M**2 - tangent**2))
    normal = directions * (radius * cosine - half_chord)[..., None] - radius * nadir
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    lit = np.clip(normal @ towards_sun, 0.05, 1.0)
    clouds = sum(smooth_noise(rng, MAP_SHAPE, cells) / cells**0.4 for cells in (16, 40, 100, 240, 500))
    albedo = 0.12 + 0.5 / (1.0 + np.exp(-5.0 * (clouds - 0.15)))
    haze = np.exp(-half_chord / (0.15 * _EARTH_RADIUS_M))
    thin = np.exp(-np.maximum(tangent - _EARTH_RADIUS_M, 0.0) / _AIR_M)
    return np.where(cosine > 0.0, (haze * _HAZE + (1.0 - haze) * albedo) * thin * lit, 0.0).astype(np.float32)


def behind_earth(directions: FloatArray, nadir: FloatArray) -> BoolArray:
    """Which of the directions (n, 3) end on the Earth or in its thick air."""
    hidden: BoolArray = directions @ nadir > np.sqrt(
        1.0 - ((_EARTH_RADIUS_M + _AIR_M) / (_EARTH_RADIUS_M + _ALTITUDE_M)) ** 2
    )
    return hidden
