"""Pose from three points in one view, held against OpenCV's P3P and exact projections."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from rvdnav.pose import PoseError, iterative_three_point_pose, make_T, p3p, perturb
from scipy.spatial.transform import Rotation

TRIANGLE = np.array([[0.0, -0.09, 0.0], [0.0, 0.09, 0.0], [0.0, 0.045, 0.14]])
# Target axes before a camera: x_C forward, y_C down, z_C to the left, as the bracket is seen.
FACING = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
angle = st.floats(-0.9, 0.9)


def a_pose(turn: tuple[float, float, float], position: tuple[float, float, float]) -> np.ndarray:
    return make_T(Rotation.from_rotvec(turn).as_matrix() @ FACING, np.array(position))


def rays_to(points_C: np.ndarray, T: np.ndarray) -> np.ndarray:
    return points_C @ T[:3, :3].T + T[:3, 3]


def distance(A: np.ndarray, B: np.ndarray) -> float:
    return float(np.abs(A - B).max())


@given(angle, angle, angle, st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(0.4, 2.0))
def test_the_true_pose_is_among_the_solutions_and_each_one_is_exact(
    a: float, b: float, c: float, x: float, y: float, z: float
) -> None:
    T = a_pose((a, b, c), (x, y, z))
    points = rays_to(TRIANGLE, T)
    # Where the derivative of the rays with respect to the distances is singular two solutions are one.
    units = points / np.linalg.norm(points, axis=1, keepdims=True)
    s = np.linalg.norm(points, axis=1)
    J = np.array(
        [[s[i] - s[j] * units[i] @ units[j], s[j] - s[i] * units[i] @ units[j]] for i, j in ((0, 1), (1, 2), (2, 0))]
    )
    full = np.array([[J[0, 0], J[0, 1], 0.0], [0.0, J[1, 0], J[1, 1]], [J[2, 1], 0.0, J[2, 0]]])
    assume(np.linalg.cond(full) < 1e3)
    solutions = p3p(7.3 * points, TRIANGLE)
    assert 1 <= len(solutions) <= 4
    assert min(distance(found, T) for found in solutions) < 1e-7
    for found in solutions:
        seen = rays_to(TRIANGLE, found)
        np.testing.assert_allclose(seen / np.linalg.norm(seen, axis=1, keepdims=True), units, atol=1e-9)
        assert (np.einsum("ij,ij->i", seen, units) > 0.0).all()


@pytest.mark.parametrize("seed", range(20))
def test_as_many_solutions_as_opencv(seed: int) -> None:
    rng = np.random.default_rng(seed)
    T = a_pose(tuple(rng.uniform(-0.8, 0.8, 3)), (*rng.uniform(-0.1, 0.1, 2), rng.uniform(0.5, 1.5)))
    points = rays_to(TRIANGLE, T)
    image = points[:, :2] / points[:, 2:]
    count, rotations, translations = cv2.solveP3P(TRIANGLE, image, np.eye(3), None, flags=cv2.SOLVEPNP_P3P)
    others = [make_T(cv2.Rodrigues(r)[0], t.ravel()) for r, t in zip(rotations, translations, strict=True)]
    solutions = p3p(points, TRIANGLE)
    for other in others:
        exact = rays_to(TRIANGLE, other)
        if np.abs(exact[:, :2] / exact[:, 2:] - image).max() < 1e-9:  # OpenCV's are not all polished
            assert min(distance(found, other) for found in solutions) < 1e-5
    assert count >= 1


@given(angle, angle, angle, st.floats(0.4, 2.0))
def test_from_a_prediction_the_near_solution_is_found(a: float, b: float, c: float, z: float) -> None:
    T = a_pose((a, b, c), (0.05, -0.03, z))
    # Its rival lies on the other side of the line of sight; far enough from it the prediction decides.
    tilt = np.arccos(np.clip(T[:3, 0] @ T[:3, 3] / np.linalg.norm(T[:3, 3]), -1.0, 1.0))
    assume(0.35 < tilt < 1.0)
    prior = perturb(T, np.array([0.004, -0.003, 0.01, 0.02, -0.02, 0.02]))
    assert distance(iterative_three_point_pose(rays_to(TRIANGLE, T), TRIANGLE, prior), T) < 1e-6


def test_points_that_determine_nothing() -> None:
    collinear = np.array([[0.0, -0.1, 0.0], [0.0, 0.0, 0.0], [0.0, 0.1, 0.0]])
    T = a_pose((0.1, 0.2, 0.0), (0.0, 0.0, 1.0))
    with pytest.raises(PoseError):
        p3p(rays_to(collinear, T), collinear)
    twice = TRIANGLE[[0, 0, 1]]
    with pytest.raises(PoseError):
        p3p(rays_to(twice, T), twice)
    with pytest.raises(PoseError):  # rays that no such triangle can lie on
        iterative_three_point_pose(np.tile([0.0, 0.0, 1.0], (3, 1)), TRIANGLE, T)
