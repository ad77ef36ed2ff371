"""A pose given from outside, from which a target is tracked that cannot, or need not, be searched for."""

from __future__ import annotations

import math

import numpy as np

from rvdnav.conventions import rigid_transform
from rvdnav.errors import InputError
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import project_edges
from rvdnav.pose import PoseError, RectifiedCameras, make_T, rotation_from_quaternion_xyzw
from rvdnav.pose.arrays import FloatArray

# How well a given pose is believed, standard deviations: position as a part of the range but no less than, m; attitude.
_RANGE_PART = 0.01
_LEAST_SIGMA = 0.002
_ATTITUDE_SIGMA = math.radians(1.5)
_UNIT = 1e-3


def parse_pose(text: str) -> FloatArray:
    """T_world_target (4, 4) from "tx ty tz qx qy qz qw": m, and a quaternion of unit length within 1e-3.

    Raises InputError for anything else.
    """
    words = text.replace(",", " ").split()
    try:
        values = np.array([float(word) for word in words])
    except ValueError:
        raise InputError(f"initial pose {text!r}: not numbers") from None
    if len(values) != 7:
        raise InputError(f"initial pose {text!r}: {len(values)} numbers, not the seven of tx ty tz qx qy qz qw")
    if not np.isfinite(values).all():
        raise InputError(f"initial pose {text!r}: not finite")
    length = float(np.linalg.norm(values[3:]))
    if abs(length - 1.0) > _UNIT:
        raise InputError(f"initial pose {text!r}: the quaternion has length {length:.4g}, not 1")
    return make_T(rotation_from_quaternion_xyzw(values[3:]), values[:3])


def checked_pose(T_world_target: FloatArray, model: EdgeModel, cameras: RectifiedCameras) -> FloatArray:
    """The pose (4, 4), its rotation freed from rounding, if a target can be there.

    Raises InputError for a matrix that is no pose, and for a target that is not in front of every camera.
    """
    try:
        T = rigid_transform(T_world_target)
    except (TypeError, ValueError) as error:
        raise InputError(f"the initial pose is not a rigid transform: {error}") from error
    try:
        for camera in range(len(cameras.centers)):
            project_edges(cameras, camera, T, model.edge_points)
    except PoseError:
        raise InputError("the initial pose does not put the target in front of the cameras") from None
    return T


def pose_covariance(T_world_target: FloatArray) -> FloatArray:
    """Covariance (6, 6) of a given pose (4, 4), order (position, rotation) in W."""
    position = max(_RANGE_PART * float(np.linalg.norm(T_world_target[:3, 3])), _LEAST_SIGMA)
    return np.diag(np.repeat([position, _ATTITUDE_SIGMA], 3) ** 2)
