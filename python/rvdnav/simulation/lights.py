"""Where the light comes from, and how much of it reaches the target."""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.pose.arrays import FloatArray
from rvdnav.rig import Rig
from rvdnav.simulation.scenario import Lights

STRIP_SIZE_M = (0.02, 0.20)
_STRIP_BESIDE_M = 0.06
"""From the outer camera's centre to the strip's middle."""
SUN_RADIUS_RAD = 0.00465
_LOWEST_COSINE = 0.2
"""The exposure meter doesn't open the camera further for a sun that grazes."""


@attrs.frozen(eq=False)
class Strip:
    """A flat LED strip: its middle (3,), m, and its axes (3, 3) in W: across, along, and the way it shines."""

    center: FloatArray
    axes: FloatArray


def led_strips(rig: Rig) -> tuple[Strip, Strip]:
    """One strip on either side of the cameras, shining ahead."""
    axes = rig.R_world_rect
    right, left = rig.T_world_cam[-1][:3, 3], rig.T_world_cam[0][:3, 3]
    return Strip(left - _STRIP_BESIDE_M * axes[:, 0], axes), Strip(right + _STRIP_BESIDE_M * axes[:, 0], axes)


def middle(rig: Rig) -> FloatArray:
    """Midway (3,) between the cameras, m in W."""
    center: FloatArray = np.mean([T[:3, 3] for T in rig.T_world_cam], axis=0)
    return center


def led_radiance(rig: Rig, lights: Lights) -> float:
    """Of both strips, for the stated irradiance 1 m ahead."""
    ahead = middle(rig) + rig.R_world_rect[:, 2]
    return lights.led / _strips_per_radiance(rig, ahead)


@attrs.frozen
class Irradiance:
    """What a card held towards the cameras receives from each of the lights."""

    led: float
    sun: float
    ambient: float

    @property
    def total(self) -> float:
        """From all of them."""
        return self.led + self.sun + self.ambient


def irradiance(rig: Rig, lights: Lights, p_W: FloatArray) -> Irradiance:
    """On a card at p_W (3,), m: the exposure meter."""
    normal = middle(rig) - p_W
    normal /= np.linalg.norm(normal)
    return Irradiance(
        led=led_radiance(rig, lights) * _strips_per_radiance(rig, p_W),
        sun=lights.sun * max(float(normal @ lights.towards_sun_W), _LOWEST_COSINE),
        ambient=lights.ambient,
    )


def _strips_per_radiance(rig: Rig, p_W: FloatArray) -> float:
    """Irradiance of a card at p_W (3,), m, held towards the cameras, per radiance of the strips, sr."""
    normal = middle(rig) - p_W
    normal /= np.linalg.norm(normal)
    total = 0.0
    for strip in led_strips(rig):
        along = STRIP_SIZE_M[1] * ((np.arange(16) + 0.5) / 16 - 0.5)
        rays = p_W - (strip.center + along[:, None] * strip.axes[:, 1])
        distance = np.linalg.norm(rays, axis=1)
        emitted = np.maximum(rays @ strip.axes[:, 2] / distance, 0.0)
        received = np.maximum(-(rays @ normal) / distance, 0.0)
        total += float(np.mean(emitted * received / distance**2)) * STRIP_SIZE_M[0] * STRIP_SIZE_M[1]
    return total
