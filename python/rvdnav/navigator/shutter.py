"""A rolling shutter: the rows of an image show the target at different times, the stamp is of the first row.

Between the stamp and a row's exposure the target goes on as the filter has it, and its edges with it; where they are
measured is referred to the stamp, and what is not known of the motion is estimated with the pose.
"""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import edge_normals, project_edges, rectified_cameras
from rvdnav.pose import FilterState, perturb
from rvdnav.pose.arrays import FloatArray
from rvdnav.rig import Rig

# Of a target whose motion is not known yet: standard deviation of each component, m/s and rad/s.
_UNKNOWN_SIGMA = 0.3
# For how long the target is moved on to tell how fast its edges move.
_STEP_S = 1e-3


@attrs.frozen(eq=False)
class Motion:
    """velocity (6,) of the target in W: of its origin, m/s, and angular, rad/s; covariance (6, 6)."""

    velocity: FloatArray
    covariance: FloatArray

    @classmethod
    def of(cls, state: FilterState | None) -> Motion:
        """As the filter has it; none, but hardly known, before the first pose."""
        if state is None:
            return cls(np.zeros(6), _UNKNOWN_SIGMA**2 * np.eye(6))
        return cls(state.velocity, state.covariance[6:, 6:])


def row_seconds(rig: Rig) -> float:
    """From the exposure of an image's row to that of the next one, s."""
    # A field's rows are the even or the odd ones of the image.
    return 1e-9 * rig.line_delay_ns * (1.0 if rig.scan == "progressive" else 0.5)


class RollingShutter:
    """A rig's shutter while a target moves."""

    def __init__(self, rig: Rig, model: EdgeModel, motion: Motion) -> None:
        self._rig = rig
        self._model = model
        self._motion = motion
        self._cameras = rectified_cameras(rig)
        self._row_seconds = row_seconds(rig)

    def edge_offsets(self, T_world_target: FloatArray) -> FloatArray:
        """How far (cameras, edges, 2), px, the ends of the edges are seen from where they were at the stamp, towards
        the normal (-dy, dx).  Raises PoseError for a target that is not in front of the cameras."""
        offsets = np.zeros((len(self._cameras.centers), len(self._model), 2))
        for camera in range(len(offsets)):
            xy, rate = self._rates(camera, T_world_target)
            offsets[camera] = rate * self._delays(camera, xy)
        return offsets

    def _rates(self, camera: int, T: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The edges' ends (m, 2, 2), px, and their speeds (m, 2) across the edge, px/s."""
        xy, _ = project_edges(self._cameras, camera, T, self._model.edge_points)
        moved = perturb(T, _STEP_S * self._motion.velocity)
        later, _ = project_edges(self._cameras, camera, moved, self._model.edge_points)
        rate: FloatArray = np.einsum("mei,mi->me", later - xy, edge_normals(xy)) / _STEP_S
        return xy, rate

    def _delays(self, camera: int, xy: FloatArray) -> FloatArray:
        """Of rectified points (..., 2), px: the exposure of their rows after the stamp, s."""
        rows = self._rig.rect_to_raw(camera, xy.reshape(-1, 2))[:, 1].reshape(xy.shape[:-1])
        delays: FloatArray = self._row_seconds * np.clip(np.nan_to_num(rows), 0.0, self._rig.height - 1.0)
        return delays
