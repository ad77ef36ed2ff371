"""The pose that one view's lines give by themselves, from the target's known size."""

from __future__ import annotations

import math

import numpy as np

from rvdnav.core.pose import refine_pose_lines
from rvdnav.pose import LineMeasurements, RectifiedCameras, RefinedPose
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.loss import Loss
from rvdnav.pose.systematics import Systematics

# Standard deviation of what displaces an edge's end by itself, px, at least and, where both views together show more,
# at the most: what is beyond that may be the views' contradiction.
_ENDPOINT_SIGMA_PX = (0.08, 0.2)


def one_view_pose(
    T_world_target: FloatArray,
    lines: LineMeasurements,
    cameras: RectifiedCameras,
    systematics: Systematics,
    displacement_px: float,
    loss: Loss = "huber",
) -> RefinedPose:
    """Refined over the lines of one camera, from a pose (4, 4) near the minimum that is meant.

    displacement_px: of each line by itself, as shown by the frame.  loss: "huber" lets every line count, "tukey" gives
    up what contradicts the rest, such as a print taken for an edge. Raises PoseError if the lines do not determine the
    pose or the target is not in front of the camera.
    """
    endpoint_sigma = float(np.clip(math.sqrt(2.0) * displacement_px, *_ENDPOINT_SIGMA_PX))
    return refine_pose_lines(
        T_world_target,
        lines,
        cameras,
        endpoint_sigma=endpoint_sigma,
        near=True,
        loss=loss,
        systematics=systematics,
    )
