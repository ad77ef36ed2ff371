"""Where a camera is while an image is exposed, seen from the target."""

from __future__ import annotations

import numpy as np

from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import inverse_T
from rvdnav.simulation.scenario import Scenario

_STEPS = 32


class CameraPath:
    """A camera's path relative to the target, from the first row's exposure to the last one's, in one frame.

    The target stays where it is, with its lights and all that stands around it, and the camera moves; between poses at
    a few times of that path every coordinate is linear.
    """

    def __init__(self, scenario: Scenario, frame: int, camera: int) -> None:
        rig = scenario.rig
        self._exposure_s = 1e-9 * rig.exposure_ns
        self._delays_s = 1e-9 * rig.row_delays_ns
        first, last = (float(end) for end in (self._delays_s.min(), self._delays_s.max()))
        self._moves = last > first or rig.exposure_ns > 0
        times = [0.0]
        if self._moves:
            times = np.linspace(first - 0.5 * self._exposure_s, last + 0.5 * self._exposure_s, _STEPS + 1).tolist()
        self._times = np.array(times)
        self._T_C_cam = np.array(
            [inverse_T(scenario.T_world_target(frame, time)) @ rig.T_world_cam[camera] for time in times]
        )

    def rays_in_target(
        self, rays: FloatArray, first_row: int, rng: np.random.Generator
    ) -> tuple[FloatArray, FloatArray]:
        """Origins (h, w, n, 3), or one (3,), and directions (h, w, n, 3) in C of rays (h, w, n, 3) in the camera frame.

        Row i of them is the image's row first_row + i.  The n rays of a pixel are spread over its exposure.
        """
        if not self._moves:
            T = self._T_C_cam[0]
            return T[:3, 3], rays @ T[:3, :3].T
        height, width, samples = rays.shape[:3]
        when = np.broadcast_to(self._delays_s[first_row : first_row + height, None, None], rays.shape[:3])
        if self._exposure_s > 0.0:
            order = rng.permuted(np.broadcast_to(np.arange(samples), (height, width, samples)), axis=-1)
            spread = (order + rng.random(order.shape)) / samples - 0.5
            when = when + self._exposure_s * spread
        flat = when.ravel()
        T = np.stack(
            [np.interp(flat, self._times, self._T_C_cam[:, i, j]) for i in range(3) for j in range(4)], axis=-1
        ).reshape(*when.shape, 3, 4)
        return T[..., 3], np.einsum("...ij,...j->...i", T[..., :3], rays)
