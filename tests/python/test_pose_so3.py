"""Rotations against scipy and the definition of the derivative."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from rvdnav import pose
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

vectors = arrays(np.float64, 3, elements=st.floats(-10, 10))
ANGLES = [0.0, 1e-12, 1e-9, 9.9e-5, 1.01e-4, 0.3, 2.0, np.pi - 1e-4, np.pi - 1e-9]
AXES = [
    np.array(a) / np.linalg.norm(a) for a in ([1.0, 0, 0], [0, -1.0, 0], [0, 0, 1.0], [1.0, -2, 3], [-3.0, 1, 1e-3])
]


def test_hat_is_the_cross_product() -> None:
    v, u = np.array([1.0, -2.0, 3.0]), np.array([0.5, 4.0, -1.0])
    assert np.array_equal(pose.hat(v) @ u, np.cross(v, u))


@given(vectors)
def test_exp_is_the_matrix_exponential(omega: np.ndarray) -> None:
    assert np.allclose(pose.exp(omega), Rotation.from_rotvec(omega).as_matrix(), atol=1e-13)


@pytest.mark.parametrize("angle", ANGLES)
def test_exp_and_log_keep_precision_at_every_angle(angle: float) -> None:
    for axis in AXES:
        R = pose.exp(angle * axis)
        assert np.allclose(R, expm(pose.hat(angle * axis)), rtol=0.0, atol=3e-15 if angle < 1.0 else 1e-14)
        assert np.allclose(pose.log(R), angle * axis, rtol=1e-9, atol=1e-15)
        assert pose.rotation_angle(R) == pytest.approx(angle, rel=1e-9, abs=1e-15)


def test_log_of_a_half_turn_gives_one_of_its_two_axes() -> None:
    for axis in AXES:
        R = 2.0 * np.outer(axis, axis) - np.eye(3)
        vector = pose.log(R)
        assert np.linalg.norm(vector) == pytest.approx(np.pi)
        assert abs(vector @ axis) == pytest.approx(np.pi)


@given(vectors)
def test_quaternion_agrees_with_scipy_and_returns(omega: np.ndarray) -> None:
    expected = Rotation.from_rotvec(omega)
    q = pose.quaternion_xyzw(expected.as_matrix())
    assert q[3] >= 0.0
    assert np.linalg.norm(q) == pytest.approx(1.0)
    assert abs(q @ expected.as_quat()) == pytest.approx(1.0)
    assert np.allclose(pose.rotation_from_quaternion_xyzw(3.0 * q), expected.as_matrix(), atol=1e-12)


@given(arrays(np.float64, 3, elements=st.floats(-6, 6)))
def test_left_jacobian_is_the_derivative_of_exp(omega: np.ndarray) -> None:
    h = 1e-6
    columns = []
    for d in np.eye(3) * h:
        turn = pose.exp(omega + d) @ pose.exp(omega - d).T
        columns.append(Rotation.from_matrix(turn).as_rotvec() / (2 * h))
    assert np.allclose(pose.left_jacobian(omega), np.column_stack(columns), atol=1e-8)


def test_projection_to_so3_is_the_nearest_rotation() -> None:
    rng = np.random.default_rng(1)
    for _ in range(20):
        M = rng.normal(size=(3, 3))
        R = pose.project_to_so3(M)
        assert np.allclose(R @ R.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(R) == pytest.approx(1.0)
        others = Rotation.from_rotvec(rng.uniform(-2.0, 2.0, size=(200, 3))).as_matrix()
        near = np.array([R @ pose.exp(0.01 * v) for v in rng.normal(size=(50, 3))])
        distances = np.linalg.norm(np.concatenate([others, near]) - M, axis=(1, 2))
        assert np.linalg.norm(R - M) <= distances.min() + 1e-12


def test_transforms_compose_and_invert() -> None:
    T = pose.make_T(pose.exp(np.array([0.3, -1.0, 2.0])), np.array([1.0, 2.0, 3.0]))
    assert np.allclose(pose.inverse_T(T), np.linalg.inv(T), atol=1e-14)


@given(arrays(np.float64, 6, elements=st.floats(-1.5, 1.5)))
def test_perturb_and_difference_are_inverse_and_act_in_the_outer_frame(delta: np.ndarray) -> None:
    T = pose.make_T(pose.exp(np.array([0.3, -1.0, 2.0])), np.array([1.0, 2.0, 3.0]))
    moved = pose.perturb(T, delta)
    assert np.allclose(moved[:3, 3], T[:3, 3] + delta[:3])
    assert np.allclose(moved[:3, :3], Rotation.from_rotvec(delta[3:]).as_matrix() @ T[:3, :3], atol=1e-12)
    assert np.allclose(pose.difference(moved, T), delta, atol=1e-9)
