"""Attitude angles against the elements printed in the paper's equation (9), and their round trip."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rvdnav.pose import (
    EulerAngles,
    elementary_x,
    elementary_y,
    elementary_z,
    euler_from_rotation,
    rotation_angle,
    rotation_from_euler,
)
from scipy.spatial.transform import Rotation

angles = st.floats(-np.pi, np.pi)


@given(angles, angles, angles)
def test_every_element_is_the_printed_one(phi: float, theta: float, psi: float) -> None:
    c, s = np.cos, np.sin
    printed = np.array(
        [
            [
                c(theta) * c(psi) - s(phi) * s(theta) * s(psi),
                c(theta) * s(psi) + s(phi) * s(theta) * c(psi),
                -c(phi) * s(theta),
            ],
            [-c(phi) * s(psi), c(phi) * c(psi), s(phi)],
            [
                s(theta) * c(psi) + s(phi) * c(theta) * s(psi),
                s(theta) * s(psi) - s(phi) * c(theta) * c(psi),
                c(phi) * c(theta),
            ],
        ]
    )
    assert np.allclose(rotation_from_euler(EulerAngles(phi, theta, psi)), printed, atol=1e-15)


@pytest.mark.parametrize(("axis", "elementary"), [("x", elementary_x), ("y", elementary_y), ("z", elementary_z)])
def test_elementary_rotations_are_the_transposes_of_the_active_ones(axis: str, elementary) -> None:
    assert np.allclose(elementary(0.4), Rotation.from_euler(axis, 0.4).as_matrix().T, atol=1e-15)


@given(st.floats(-1.57, 1.57), angles, angles)
def test_angles_are_those_of_equation_10(phi: float, theta: float, psi: float) -> None:
    R = rotation_from_euler(EulerAngles(phi, theta, psi))
    found = euler_from_rotation(R)
    assert found.phi == pytest.approx(np.arcsin(R[1, 2]), abs=1e-7)
    assert np.allclose(np.exp(1j * found.theta), np.exp(1j * theta), atol=1e-11)
    assert np.allclose(np.exp(1j * found.psi), np.exp(1j * psi), atol=1e-11)
    printed_theta = np.arctan2(-R[0, 2], R[2, 2])
    assert np.allclose(np.exp(1j * found.theta), np.exp(1j * printed_theta), atol=1e-11)


@given(st.floats(-1e-3, 1e-3), angles, angles, st.sampled_from([-1.0, 1.0]), st.integers(0, 14))
def test_round_trip_gives_back_the_rotation_at_and_near_gimbal_lock(
    offset: float, theta: float, psi: float, side: float, shrink: int
) -> None:
    R = rotation_from_euler(EulerAngles(side * np.pi / 2 + offset * 10.0**-shrink, theta, psi))
    again = rotation_from_euler(euler_from_rotation(R))
    assert rotation_angle(again @ R.T) < 1e-11


@given(st.tuples(angles, angles, angles))
def test_round_trip_of_any_rotation(vector: tuple[float, float, float]) -> None:
    R = Rotation.from_rotvec(vector).as_matrix()
    assert rotation_angle(rotation_from_euler(euler_from_rotation(R)) @ R.T) < 1e-12


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_psi_is_zero_at_gimbal_lock(side: float) -> None:
    found = euler_from_rotation(rotation_from_euler(EulerAngles(side * np.pi / 2, 0.3, 0.5)))
    assert found.psi == 0.0
    assert found.phi == pytest.approx(side * np.pi / 2)
    # At phi = ±90° only theta ± psi is left of the two angles.
    assert found.theta == pytest.approx(0.3 + side * 0.5)
