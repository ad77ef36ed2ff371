"""What a calibration is worth to the mission: how far the pose of a bracket errs by the calibration alone."""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.bracket import Bracket
from rvdnav.navigator.calibration import CalibrationEffect
from rvdnav.navigator.geometry import line_covariance, line_of, project_edges, rectified_cameras
from rvdnav.pose import LineMeasurements, PoseError, refine_pose_lines
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import make_T
from rvdnav.rig import Rig

RANGES_M = (0.3, 0.5, 1.0, 1.5)
# The paper's bracket: bases of 180 and 90 mm, 140 mm high, bars of 14 mm.
_OUTER = [[0, -0.09, 0], [0, 0.09, 0], [0, 0.045, 0.14], [0, -0.045, 0.14]]
_INNER = [[0, -0.0708, 0.014], [0, 0.0708, 0.014], [0, 0.0348, 0.126], [0, -0.0348, 0.126]]
BRACKET = Bracket(_OUTER, _INNER, thickness=0.006)


@attrs.frozen(eq=False)
class PoseSensitivity:
    """Derivative (6, 22) of the pose, order (position, rotation) in W, at a range, m, by the calibration."""

    range_m: float
    derivative: FloatArray

    def sigmas(self, covariance: FloatArray) -> tuple[float, float]:
        """Standard deviations of the position, m, and of the attitude, rad, under a covariance (22, 22): the root mean
        square of the error's length and angle."""
        variances = np.einsum("ip,pq,iq->i", self.derivative, covariance, self.derivative)
        return float(np.sqrt(variances[:3].sum())), float(np.sqrt(variances[3:].sum()))

    def range_sigma(self, covariance: FloatArray) -> float:
        """Standard deviation of the distance along x_W, m."""
        return float(np.sqrt(self.derivative[0] @ covariance @ self.derivative[0]))


def pose_sensitivities(rig: Rig) -> tuple[PoseSensitivity, ...]:
    """For the paper's bracket squarely before the rig at each of `RANGES_M` where the views determine its pose."""
    effect = CalibrationEffect.of(rig)
    found = []
    for range_m in RANGES_M:
        T = make_T(np.eye(3), np.array([range_m, 0.0, 0.5 * rig.baseline - 0.07]))
        try:
            lines = _lines(rig, T)
            pose = refine_pose_lines(T, lines, rectified_cameras(rig), near=True)
            found.append(PoseSensitivity(range_m, effect.pose_derivative(pose, lines)))
        except PoseError:
            continue
    return tuple(found)


def _lines(rig: Rig, T_world_target: FloatArray) -> LineMeasurements:
    """The bracket's edges whose middle is on the image, as exact lines of equal weight for their length."""
    edge_points = BRACKET.edge_points
    camera, edge, ends = [], [], []
    for i in range(len(rig.cameras)):
        xy, _ = project_edges(rectified_cameras(rig), i, T_world_target, edge_points)
        uv = rig.rect_to_raw(i, xy.mean(axis=1))
        for k in np.flatnonzero(rig.on_image(uv)):
            camera.append(i)
            edge.append(k)
            ends.append(xy[k])
    if not camera:
        raise PoseError("no edge of the bracket is in view")
    rho, theta, t = line_of(np.array(ends))
    length, middle = t[:, 1] - t[:, 0], t.mean(axis=1)
    offset = 1e-4 * 10.0 / length
    cov = line_covariance(offset, 12.0 * offset / length**2, middle)
    number = np.array(edge)
    return LineMeasurements(np.array(camera), number, edge_points[number], rho, theta, cov)
