"""Attitude angles (phi, theta, psi) of the paper's equations (9) and (10).

The rotation runs z, then x, then y: R = R_y(theta) R_x(phi) R_z(psi).  The elementary matrices that reproduce
equation (9) as printed are the transposes of the usual active ones.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from rvdnav.pose.arrays import FloatArray

# cos(phi) below this is gimbal lock: rounding alone then decides the direction of (R21, R22).
_GIMBAL_COSINE = 1e-12


class EulerAngles(NamedTuple):
    """Attitude angles in radians, about x (phi), y (theta) and z (psi)."""

    phi: float
    theta: float
    psi: float


def elementary_x(angle: float) -> FloatArray:
    """R_x(angle) (3, 3) in the sense of equation (9); angle in rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]])


def elementary_y(angle: float) -> FloatArray:
    """R_y(angle) (3, 3) in the sense of equation (9); angle in rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])


def elementary_z(angle: float) -> FloatArray:
    """R_z(angle) (3, 3) in the sense of equation (9); angle in rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def rotation_from_euler(angles: EulerAngles) -> FloatArray:
    """R (3, 3) = R_y(theta) R_x(phi) R_z(psi), equation (9)."""
    phi, theta, psi = angles
    rotation: FloatArray = elementary_y(theta) @ elementary_x(phi) @ elementary_z(psi)
    return rotation


def euler_from_rotation(R: FloatArray) -> EulerAngles:
    """Angles of R (3, 3), equation (10) in a form that holds in all quadrants and at phi = ±90°.

    phi = atan2(R23, hypot(R21, R22)) in [-pi/2, pi/2]; psi = atan2(-R21, R22), or 0 at gimbal lock.  theta is read
    from R R_z(psi)ᵀ: its first column is (cos theta, 0, sin theta) whatever phi is.  Away from gimbal lock this is
    atan2(-R13, R33); near it, it stays consistent with psi, so that the angles always give back R.
    """
    cosine = np.hypot(R[1, 0], R[1, 1])
    phi = np.arctan2(R[1, 2], cosine)
    psi = 0.0 if cosine < _GIMBAL_COSINE else np.arctan2(-R[1, 0], R[1, 1])
    c, s = np.cos(psi), np.sin(psi)
    theta = np.arctan2(R[2, 0] * c + R[2, 1] * s, R[0, 0] * c + R[0, 1] * s)
    return EulerAngles(float(phi), float(theta), float(psi))
