"""One image's circumstances: where the target is in it, how that moves, and what the camera showed at other times."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import cv2
import numpy as np

from rvdnav.errors import InputError
from rvdnav.faults.region import Region, target_region
from rvdnav.images import PixelArray
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import exp, inverse_T, log, make_T
from rvdnav.rig import Rig
from rvdnav.target import Target
from rvdnav.trajectory import Truth

_STEP_NS = 1_000_000


@attrs.frozen(eq=False)
class View:
    """What a fault may know of the image that it strikes.

    timestamp_ns: when its pixels were recorded.  recorded_at: what the camera recorded within a millisecond of another
    time, ns, with the faults that come before; None where it recorded nothing.  sensor: a generator that is the same
    in every frame, for what belongs to the camera.
    """

    rig: Rig
    target: Target
    truth: Truth | None
    timestamp_ns: int
    camera: int
    recorded_at: Callable[[int], PixelArray | None]
    sensor: np.random.Generator

    @property
    def region(self) -> Region:
        """Where the target is."""
        return target_region(self.rig, self.target, self.truth, self.timestamp_ns, self.camera)

    def motion(self) -> FloatArray:
        """Velocity (2,) of the middle of the target's points in the image, px/s, from the true poses.

        Raises InputError without two true poses; so does `later`.
        """
        T, T_later = self._pose(0), self._pose(_STEP_NS)
        middle = np.mean(list(self.target.points.values()), axis=0)
        before, after = (self.rig.project(self.camera, P[:3, :3] @ middle + P[:3, 3]) for P in (T, T_later))
        velocity: FloatArray = np.nan_to_num((after - before) / (1e-9 * _STEP_NS))
        return velocity

    def later(self, pixels: PixelArray, delay_ns: int) -> PixelArray:
        """The image as it would be later by a delay, which may be negative.

        It is the recorded one of that time where there is one; otherwise these pixels, moved as though all that they
        show lay in the target's front plane (y_C, z_C) and moved with it from its true pose to the later one.
        """
        recorded = self.recorded_at(self.timestamp_ns + delay_ns)
        if recorded is not None:
            return recorded
        camera, T_world_cam = self.rig.cameras[self.camera], self.rig.T_world_cam[self.camera]
        T, T_later = (inverse_T(T_world_cam) @ self._pose(at) for at in (0, delay_ns))
        v, u = np.indices(pixels.shape)
        rays = camera.unproject(np.stack([u, v], axis=-1))
        # Where the later plane is hit, in C; then where that point is now.
        to_plane = rays @ T_later[:3, 0]
        depth = (T_later[:3, 0] @ T_later[:3, 3]) / np.where(np.abs(to_plane) < 1e-6, np.nan, to_plane)
        p_C = (depth[..., None] * rays - T_later[:3, 3]) @ T_later[:3, :3]
        source = camera.project(p_C @ T[:3, :3].T + T[:3, 3])
        source = np.where(np.isfinite(source) & (depth[..., None] > 0.0), source, np.stack([u, v], axis=-1))
        maps = source.astype(np.float32)
        moved: PixelArray = cv2.remap(
            pixels, maps[..., 0], maps[..., 1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE
        ).astype(np.uint8)
        return moved

    def _pose(self, delay_ns: int) -> FloatArray:
        """T_world_target at a delay: between the two nearest true poses, or beyond them, at constant velocity."""
        truth = self.truth
        if truth is None or len(truth) < 2:
            raise InputError("a fault needs the target's true motion, and groundtruth.tum does not hold two poses")
        at = self.timestamp_ns + delay_ns
        after = int(np.clip(np.searchsorted(truth.timestamps_ns, at, side="right"), 1, len(truth) - 1))
        first, second = truth.T_world_target[after - 1], truth.T_world_target[after]
        start, end = (int(truth.timestamps_ns[i]) for i in (after - 1, after))
        done = (at - start) / (end - start)
        turn = exp(done * log(second[:3, :3] @ first[:3, :3].T))
        return make_T(turn @ first[:3, :3], (1.0 - done) * first[:3, 3] + done * second[:3, 3])
