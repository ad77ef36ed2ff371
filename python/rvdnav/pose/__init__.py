"""The pose mathematics: closed-form pose, attitude angles, refinement with covariance, and prediction.

Readable numpy throughout; every formula names its source.  The frames and orders are those of docs/conventions.md.
"""

from rvdnav.pose.cameras import RectifiedCameras
from rvdnav.pose.edge_lines import EdgeLines, fit_edge_lines
from rvdnav.pose.errors import PoseError
from rvdnav.pose.euler import (
    EulerAngles,
    elementary_x,
    elementary_y,
    elementary_z,
    euler_from_rotation,
    rotation_from_euler,
)
from rvdnav.pose.filter import ConstantVelocityFilter, FilterState, PredictedPose
from rvdnav.pose.p3p import iterative_three_point_pose, p3p
from rvdnav.pose.refine_lines import LineMeasurements, line_residuals, refine_pose_edges, refine_pose_lines
from rvdnav.pose.refine_shape import RefinedShape, refine_shape, size_derivatives
from rvdnav.pose.refined import RefinedPose
from rvdnav.pose.so3 import (
    difference,
    exp,
    hat,
    inverse_T,
    left_jacobian,
    log,
    make_T,
    perturb,
    project_to_so3,
    quaternion_xyzw,
    rotation_angle,
    rotation_from_quaternion_xyzw,
)
from rvdnav.pose.threepoint import frame_from_points, pose_from_apexes, three_point_pose
from rvdnav.pose.triangulate import triangulate

__all__ = [
    "ConstantVelocityFilter",
    "EdgeLines",
    "EulerAngles",
    "FilterState",
    "LineMeasurements",
    "PoseError",
    "PredictedPose",
    "RectifiedCameras",
    "RefinedPose",
    "RefinedShape",
    "difference",
    "elementary_x",
    "elementary_y",
    "elementary_z",
    "euler_from_rotation",
    "exp",
    "fit_edge_lines",
    "frame_from_points",
    "hat",
    "inverse_T",
    "iterative_three_point_pose",
    "left_jacobian",
    "line_residuals",
    "log",
    "make_T",
    "p3p",
    "perturb",
    "pose_from_apexes",
    "project_to_so3",
    "quaternion_xyzw",
    "refine_pose_edges",
    "refine_pose_lines",
    "refine_shape",
    "rotation_angle",
    "rotation_from_euler",
    "rotation_from_quaternion_xyzw",
    "size_derivatives",
    "three_point_pose",
    "triangulate",
]
