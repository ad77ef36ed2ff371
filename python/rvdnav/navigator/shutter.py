"""A rolling shutter: the rows of an image show the target at different times, the stamp is of the first row.

Between the stamp and a row's exposure the target goes on as the filter has it, and its edges with it; where they are
measured is referred to the stamp, and what is not known of the motion is estimated with the pose.
"""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import edge_normals, project_edges, rectified_cameras
from rvdnav.navigator.sampling import SampledEdges
from rvdnav.pose import FilterState, LineMeasurements, line_residuals, perturb
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


class RollingShutter:
    """A rig's shutter while a target moves."""

    def __init__(self, rig: Rig, model: EdgeModel, motion: Motion) -> None:
        self._rig = rig
        self._model = model
        self._motion = motion
        self._cameras = rectified_cameras(rig)
        # A field's rows are the even or the odd ones of the image.
        self._row_seconds = 1e-9 * rig.line_delay_ns * (1.0 if rig.scan == "progressive" else 0.5)

    def edge_offsets(self, T_world_target: FloatArray) -> FloatArray:
        """How far (cameras, edges, 2), px, the ends of the edges are seen from where they were at the stamp, towards
        the normal (-dy, dx).  Raises PoseError for a target that is not in front of the cameras."""
        offsets = np.zeros((len(self._cameras.centers), len(self._model), 2))
        for camera in range(len(offsets)):
            xy, rate = self._rates(camera, T_world_target)
            offsets[camera] = rate * self._delays(camera, xy)
        return offsets

    def at_stamp(self, sampled: SampledEdges, T_world_target: FloatArray) -> SampledEdges:
        """The samples where their steps were at the stamp, near a pose (4, 4)."""
        q = sampled.q.copy()
        for camera in np.unique(sampled.camera):
            own = sampled.camera == camera
            edge = sampled.edge[own]
            xy, rate = self._rates(int(camera), T_world_target)
            start, span = xy[edge, 0], xy[edge, 1] - xy[edge, 0]
            part = np.einsum("ni,ni->n", q[own] - start, span) / np.einsum("ni,ni->n", span, span)
            speed = rate[edge, 0] + part * (rate[edge, 1] - rate[edge, 0])
            q[own] -= (speed * self._delays(int(camera), q[own]))[:, None] * sampled.n[own]
        return attrs.evolve(sampled, q=q)

    def by_motion(self, T_world_target: FloatArray, lines: LineMeasurements) -> FloatArray:
        """(n, 2, 6), px: of the lines' residuals with respect to the velocity, in its standard deviations."""
        _, by_pose = line_residuals(T_world_target, lines, self._cameras)
        delays = np.zeros((len(lines), 2))
        for camera in np.unique(lines.camera):
            own = lines.camera == camera
            xy, _ = project_edges(self._cameras, int(camera), T_world_target, lines.endpoints_C[own])
            delays[own] = self._delays(int(camera), xy)
        derivative: FloatArray = (by_pose * delays[:, :, None]) @ np.linalg.cholesky(self._motion.covariance)
        return derivative

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
