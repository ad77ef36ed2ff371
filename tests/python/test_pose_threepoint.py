"""Closed-form pose from points: exact geometry and its failures."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pose_scene import OUTER, pose
from rvdnav.pose import PoseError, frame_from_points, pose_from_apexes, rotation_angle, three_point_pose
from scipy.spatial.transform import Rotation

vectors = arrays(np.float64, 3, elements=st.floats(-3, 3))


def test_frame_has_the_columns_of_equation_7() -> None:
    n = frame_from_points(np.array([1.0, 1.0, 1.0]), np.array([3.0, 1.0, 1.0]), np.array([1.0 + 3.0, 1.0 + 4.0, 1.0]))
    assert np.allclose(n, np.column_stack([[1.0, 0, 0], [0.6, 0.8, 0], [0, 0, 1.0]]))


@given(vectors, vectors, arrays(np.float64, (3, 3), elements=st.floats(-1, 1)))
def test_exact_points_give_back_the_pose(vector: np.ndarray, p: np.ndarray, points: np.ndarray) -> None:
    a, b = points[1] - points[0], points[2] - points[0]
    assume(np.linalg.norm(np.cross(a, b)) > 0.01)
    R = Rotation.from_rotvec(vector).as_matrix()
    T = three_point_pose(points @ R.T + p, points)
    assert np.allclose(T[:3, :3], R, atol=1e-9)
    assert np.allclose(T[:3, 3], p, atol=1e-9)
    assert np.array_equal(T[3], [0, 0, 0, 1])


def test_apexes_give_back_the_pose() -> None:
    T = pose()
    assert np.allclose(pose_from_apexes(OUTER @ T[:3, :3].T + T[:3, 3], OUTER), T, atol=1e-12)


def test_measured_apexes_give_a_rotation_near_the_truth_that_meets_the_midpoint_of_l1() -> None:
    rng = np.random.default_rng(3)
    T = pose()
    for _ in range(50):
        measured = OUTER @ T[:3, :3].T + T[:3, 3] + rng.normal(scale=5e-4, size=(4, 3))
        found = pose_from_apexes(measured, OUTER)
        assert np.allclose(found[:3, :3] @ found[:3, :3].T, np.eye(3), atol=1e-12)
        assert np.linalg.det(found[:3, :3]) == pytest.approx(1.0)
        assert rotation_angle(found[:3, :3] @ T[:3, :3].T) < 0.02
        # O_t is C's origin, so T must place it on the measured midpoint.
        assert np.allclose(found[:3, 3], (measured[0] + measured[1]) / 2, atol=1e-12)


def test_stretching_l1_symmetrically_does_not_turn_the_pose() -> None:
    T = pose()
    stretched = OUTER.copy()
    stretched[:2] *= 1.05
    found = pose_from_apexes(stretched @ T[:3, :3].T + T[:3, 3], OUTER)
    assert np.allclose(found, T, atol=1e-12)


@pytest.mark.parametrize(
    ("points", "fault"),
    [
        ([[0, 0, 0], [1, 2, 3], [2, 4, 6]], "collinear"),
        ([[0, 0, 0], [1, 2, 3], [-1, -2, -3.0001]], "collinear"),
        ([[0, 0, 0], [0, 0, 0], [1, 0, 0]], "coincide"),
        ([[0, 0, 0], [1, 0, 0], [1, 0, 0]], "collinear"),
    ],
)
def test_degenerate_points_are_refused(points: list[list[float]], fault: str) -> None:
    good = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    with pytest.raises(PoseError, match=fault):
        three_point_pose(np.array(points, dtype=float), good)
    with pytest.raises(PoseError, match=fault):
        three_point_pose(good, np.array(points, dtype=float))


def test_points_of_a_wrong_shape_or_not_finite_are_refused() -> None:
    with pytest.raises(ValueError, match="shape"):
        pose_from_apexes(OUTER[:3], OUTER)
    with pytest.raises(ValueError, match="finite"):
        pose_from_apexes(OUTER * np.nan, OUTER)
