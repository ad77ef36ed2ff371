"""A rolling shutter: the rows of an image show the target at different times, the stamp is of the first row.

Between the stamp and a row's exposure the target goes on as the filter has it, and its edges with it; where they are
measured is referred to the stamp, and what is not known of the motion is estimated with the pose.
"""

from __future__ import annotations

import attrs
import numpy as np
from rvdnav.navigator.geometry import project_edges
from rvdnav.navigator.shutter import RollingShutter
from rvdnav.pose import LineMeasurements, line_residuals
from rvdnav.pose.arrays import FloatArray

from readable_navigator.sampling import SampledEdges


class MeasuredShutter(RollingShutter):
    """A rig's shutter, and what it does to measured edges."""

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
