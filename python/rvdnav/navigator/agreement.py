"""Whether the two views tell of the same pose: each by itself, from the target's known size, and both together."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.navigator.knowledge import Knowledge
from rvdnav.navigator.measurement import Measurement
from rvdnav.navigator.one_view import one_view_pose
from rvdnav.pose import LineMeasurements, PoseError, RefinedPose, difference
from rvdnav.pose.arrays import BoolArray, FloatArray
from rvdnav.pose.loss import Loss
from rvdnav.rig import Rig
from rvdnav.target import Bracket


def view_difference(measurement: Measurement, rig: Rig, loss: Loss = "huber") -> float:
    """Distance between the pose that the left view's lines give alone and the right one's, in standard deviations.

    The refinement over both views gives up lines that contradict the others, and so can follow one view and the
    disparity into a pose that the other view denies.  Here each view stands by itself, with the errors of target and
    calibration that were to be expected before this frame.  loss: as of `one_view_pose`.  0 where a view determines no
    pose by itself.
    """
    cameras = rectified_cameras(rig)
    T, lines = measurement.pose.T_world_target, measurement.lines
    views: list[RefinedPose] = []
    try:
        for camera in range(len(rig.cameras)):
            chosen = lines.camera == camera
            systematics = measurement.systematics.only(chosen)
            shown = measurement.pose.displacement_px
            views.append(one_view_pose(T, _chosen(lines, chosen), cameras, systematics, shown, loss))
    except PoseError:
        return 0.0
    left, right = views
    error = difference(left.T_world_target, right.T_world_target)
    covariance = left.covariance + right.covariance
    return float(np.sqrt(error @ np.linalg.solve(covariance, error)))


def _chosen(lines: LineMeasurements, chosen: BoolArray) -> LineMeasurements:
    return LineMeasurements(*(getattr(lines, field.name)[chosen] for field in attrs.fields(LineMeasurements)))


def disparity_errors(
    matches: NDArray[np.void], pose: RefinedPose, bracket: Bracket, rig: Rig, knowledge: Knowledge
) -> tuple[FloatArray, FloatArray]:
    """Disparities (k,) of the accepted ones of correlated points (MATCH records) on the bars' faces minus what a pose
    predicts for them, px, and the standard deviations (k,) that the calibration leaves to them."""
    matches = matches[matches["accepted"] != 0]
    if len(matches) == 0:
        return np.zeros(0), np.zeros(0)
    T = pose.T_world_target
    R_rect_world = rig.R_world_rect.T
    # The face is the plane x_C = const; its normal and a point on it, seen from the left camera in rectified axes.
    normal = R_rect_world @ T[:3, 0]
    point = R_rect_world @ (T[:3, :3] @ bracket.outer[0] + T[:3, 3] - rig.T_world_cam[0][:3, 3])
    xy = np.column_stack([matches["x"], matches["y"]])
    rays = np.column_stack([xy, np.full(len(matches), rig.focal_rect)]) / rig.focal_rect
    depth = (normal @ point) / (rays @ normal)
    predicted: FloatArray = rig.focal_rect * rig.baseline / depth
    correction, sigma = knowledge.disparity_corrections(xy, predicted, pose)
    return matches["disparity"] - predicted + correction, sigma
