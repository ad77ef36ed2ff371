"""The pose that one view's lines give by themselves, from the target's known size."""

from __future__ import annotations

from rvdnav.pose import LineMeasurements, RectifiedCameras, RefinedPose, refine_pose_lines
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.loss import Loss
from rvdnav.pose.systematics import Systematics

# Standard deviation of what displaces an edge's end by itself, px; where it is more, the residuals tell.
_ENDPOINT_SIGMA_PX = 0.08


def one_view_pose(
    T_world_target: FloatArray,
    lines: LineMeasurements,
    cameras: RectifiedCameras,
    systematics: Systematics,
    loss: Loss = "huber",
) -> RefinedPose:
    """Refined over the lines of one camera, from a pose (4, 4) near the minimum that is meant.

    loss: "huber" lets every line count, "tukey" gives up what contradicts the rest, such as a print taken for an edge.
    Raises PoseError if the lines do not determine the pose or the target is not in front of the camera.
    """
    return refine_pose_lines(
        T_world_target,
        lines,
        cameras,
        endpoint_sigma=_ENDPOINT_SIGMA_PX,
        near=True,
        loss=loss,
        systematics=systematics,
    )
