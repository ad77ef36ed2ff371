"""A design: the rig, the target and the errors that a budget is drawn up for."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property

import attrs
import numpy as np

from rvdnav.budget.assumptions import Assumptions
from rvdnav.budget.board_calibration import board_calibration_covariance
from rvdnav.camera import CameraModel
from rvdnav.navigator.calibration import CalibrationEffect
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.pose import PoseError, RectifiedCameras, exp, make_T
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import inverse_T
from rvdnav.rig import Rig, calibration_parameters

# The target's axes in rectified ones when its face is seen squarely.
_SQUARE = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])


def _with_covariance(rig: Rig) -> Rig:
    if rig.calibration_covariance is not None:
        return rig
    return attrs.evolve(rig, calibration_covariance=board_calibration_covariance(rig))


def _numbers(values: Iterable[int]) -> tuple[int, ...]:
    return tuple(values)


@attrs.frozen(eq=False, slots=False)
class Design:
    """What a budget is drawn up for.

    rig: with the covariance of its calibration; that of `board_calibration_covariance` where it has none.  model: the
    target's edges.  views: the cameras that are used.  edges: those that are measured where they are seen, and part:
    how much of each, about its middle.
    """

    rig: Rig = attrs.field(converter=_with_covariance)
    model: EdgeModel
    assumptions: Assumptions = attrs.field(factory=Assumptions)
    views: tuple[int, ...] = attrs.field(
        default=attrs.Factory(lambda self: range(len(self.rig.cameras)), takes_self=True), converter=_numbers
    )
    edges: tuple[int, ...] = attrs.field(
        default=attrs.Factory(lambda self: range(len(self.model)), takes_self=True), converter=_numbers
    )
    part: float = 1.0

    @cached_property
    def cameras(self) -> RectifiedCameras:
        """The rig's rectified cameras."""
        return rectified_cameras(self.rig)

    @cached_property
    def calibration(self) -> CalibrationEffect:
        """What errors of the calibration do."""
        return CalibrationEffect.of(self.rig)

    def pose_at(self, distance: float, angle: float, azimuth: float) -> FloatArray:
        """T_world_target (4, 4) at a range, m, the target's middle on the axis midway between the cameras.

        angle, rad: between x_C, the normal of a bracket's face, and that axis.  azimuth, rad: of the axis that it is
        turned about, 0 for down and a quarter turn for right to left.  Raises PoseError for a range too short for that.
        """
        square = self.rig.R_world_rect @ _SQUARE
        R = square @ exp(angle * np.array([0.0, np.cos(azimuth), np.sin(azimuth)]))
        start = self.cameras.centers.mean(axis=0) - R @ self.model.edge_points.reshape(-1, 3).mean(axis=0)
        ahead = float(start @ square[:, 0])
        aside_squared = float(start @ start) - ahead**2
        if not distance**2 > aside_squared:
            raise PoseError("the range is too short for the target's middle to lie on the axis")
        return make_T(R, start + (np.sqrt(distance**2 - aside_squared) - ahead) * square[:, 0])

    def with_baseline(self, factor: float) -> Design:
        """The stereo design with the cameras' distance scaled; its calibration errs as before."""
        T_cam1_cam0 = inverse_T(self.rig.T_world_cam[1]) @ self.rig.T_world_cam[0]
        delta = np.zeros(len(calibration_parameters(2)))
        delta[-3:] = (factor - 1.0) * T_cam1_cam0[:3, 3]
        return attrs.evolve(self, rig=self.rig.perturbed(delta))

    def with_focal_length(self, factor: float) -> Design:
        """The design with other lenses on the same sensors; they bend by the same pixels, and their calibration errs by
        the same pixels and the same distances between the cameras."""
        lens = np.array([factor**2, factor**4, factor, factor])
        scale = np.ones(len(calibration_parameters(len(self.rig.cameras))))
        for index in range(len(self.rig.cameras)):
            scale[8 * index + 4 : 8 * index + 8] = lens
        scale[16:19] = 1.0 / factor  # the turn of one camera against the other; nothing for a single one
        cameras = [
            CameraModel(c.width, c.height, factor * c.fx, factor * c.fy, c.cx, c.cy, lens * c.distortion)
            for c in self.rig.cameras
        ]
        covariance = scale[:, None] * np.asarray(self.rig.calibration_covariance) * scale
        return attrs.evolve(self, rig=attrs.evolve(self.rig, cameras=cameras, calibration_covariance=covariance))
