"""Pose from three points in closed form: the paper's equations (6)-(8)."""

from __future__ import annotations

import numpy as np

from rvdnav.pose.arrays import FloatArray, float_array
from rvdnav.pose.errors import PoseError
from rvdnav.pose.so3 import make_T, project_to_so3

# Points closer than this (m) are one point; directions closer than this (sine of the angle) are one direction.
_COINCIDENT = 1e-9
_COLLINEAR_SINE = 1e-3


def frame_from_points(origin: FloatArray, p_1: FloatArray, p_2: FloatArray) -> FloatArray:
    """Matrix n (3, 3) of equation (7): columns n1 = unit(p_1 - origin), n2 = unit(p_2 - origin), n3 = unit(n1 x n2).

    Points (3,) in m, all in one frame.  Raises PoseError if two of the points coincide or the three are collinear.
    """
    directions = np.stack([p_1 - origin, p_2 - origin])
    lengths = np.linalg.norm(directions, axis=1)
    if lengths.min() < _COINCIDENT:
        raise PoseError("two of the points coincide: they determine no attitude")
    n_1, n_2 = directions / lengths[:, None]
    normal = np.cross(n_1, n_2)
    sine = np.linalg.norm(normal)
    if sine < _COLLINEAR_SINE:
        raise PoseError("the points are collinear: they leave the rotation about their line open")
    return np.column_stack([n_1, n_2, normal / sine])


def three_point_pose(points_W: FloatArray, points_C: FloatArray) -> FloatArray:
    """T_world_target (4, 4) from three points (3, 3), one a row, in W and in C (m); equations (6)-(8).

    R = n_w n_t⁻¹ projected to SO(3), because measured points are no exact image of the target's; T = P_w1 - R P_t1,
    so the first point is met exactly.  Raises PoseError for coincident or collinear points in either frame.
    """
    points_W = float_array(points_W, 3, 3)
    points_C = float_array(points_C, 3, 3)
    n_w = frame_from_points(*points_W)
    n_t = frame_from_points(*points_C)
    R = project_to_so3(n_w @ np.linalg.inv(n_t))
    return make_T(R, points_W[0] - R @ points_C[0])


def pose_from_apexes(apexes_W: FloatArray, apexes_C: FloatArray) -> FloatArray:
    """T_world_target (4, 4) from the bracket's outer apexes P1..P4 (4, 3) in W and in C (m).

    The three points are O_t = (P1 + P2)/2 on l1, P2 (so n1 runs along l1 from P1 to P2) and (P3 + P4)/2 on l2.
    Raises PoseError where these coincide or are collinear.
    """
    return three_point_pose(_three_points(apexes_W), _three_points(apexes_C))


def _three_points(apexes: FloatArray) -> FloatArray:
    p_1, p_2, p_3, p_4 = float_array(apexes, 4, 3)
    return np.stack([(p_1 + p_2) / 2.0, p_2, (p_3 + p_4) / 2.0])
