"""Rotations and rigid transforms: SO(3) exponential and logarithm, quaternions, 4x4 transforms.

`R_A_B` and `T_A_B` map coordinates in B to coordinates in A.  A rotation vector is axis times angle (rad), active and
right-handed.  Quaternions are Hamilton, in the order x, y, z, w.
Formulas: J. Solà, J. Deray, D. Atchuthan, "A micro Lie theory for state estimation in robotics" (2018), appendix B.
"""

from __future__ import annotations

import math

import numpy as np

from rvdnav.pose.arrays import FloatArray

# Below this angle (rad) the series of sin(a)/a and its kin are exact to double precision with two terms.
_SMALL_ANGLE = 1e-4


def hat(v: FloatArray) -> FloatArray:
    """The skew matrix [v]x (3, 3) of v (3,), so that hat(v) @ u = v x u."""
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def _series(angle: float) -> tuple[float, float, float]:
    """sin(a)/a, (1 - cos a)/a² and (a - sin a)/a³, stable at zero."""
    if angle < _SMALL_ANGLE:
        square = angle * angle
        return 1.0 - square / 6.0, 0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0
    sine, half_sine = math.sin(angle), math.sin(angle / 2.0)
    # 2 sin²(a/2) instead of 1 - cos a: the difference of near-equal numbers loses half the digits.
    return sine / angle, 2.0 * (half_sine / angle) ** 2, (angle - sine) / angle**3


def exp(omega: FloatArray) -> FloatArray:
    """Rotation matrix (3, 3) of the rotation vector omega (3,), rad (Rodrigues)."""
    a, b, _ = _series(math.sqrt(omega @ omega))
    skew = hat(omega)
    rotation: FloatArray = np.eye(3) + a * skew + b * (skew @ skew)
    return rotation


def log(R: FloatArray) -> FloatArray:
    """Rotation vector (3,), rad, of R (3, 3), with an angle in [0, pi]; the inverse of `exp`.

    It goes through the quaternion, whose vector part keeps full precision at both ends of the range; at exactly pi,
    where both axes are right, it gives one of them.
    """
    q = quaternion_xyzw(R)
    sine = float(np.linalg.norm(q[:3]))
    if sine < 1e-12:
        return 2.0 * q[:3]
    vector: FloatArray = q[:3] * (2.0 * np.arctan2(sine, q[3]) / sine)
    return vector


def left_jacobian(omega: FloatArray) -> FloatArray:
    """J (3, 3) with exp(omega + d) = exp(J d) exp(omega) to first order in d."""
    _, b, c = _series(math.sqrt(omega @ omega))
    skew = hat(omega)
    jacobian: FloatArray = np.eye(3) + b * skew + c * (skew @ skew)
    return jacobian


def project_to_so3(M: FloatArray) -> FloatArray:
    """The rotation nearest to M (3, 3) in the Frobenius norm, with determinant +1 (SVD)."""
    u, _, vt = np.linalg.svd(M)
    u[:, 2] *= np.sign(np.linalg.det(u @ vt))
    rotation: FloatArray = u @ vt
    return rotation


def rotation_angle(R: FloatArray) -> float:
    """Angle of R (3, 3), rad, in [0, pi]."""
    return float(np.linalg.norm(log(R)))


def quaternion_xyzw(R: FloatArray) -> FloatArray:
    """Unit quaternion (4,) x, y, z, w of R (3, 3), with w >= 0.

    It divides by the largest of the four components (Shepperd's choice), so that it is stable for every rotation.
    """
    trace = R[0, 0] + R[1, 1] + R[2, 2]
    candidates = np.array([R[0, 0], R[1, 1], R[2, 2], trace])
    largest = int(np.argmax(candidates))
    q = np.empty(4)
    if largest == 3:
        q[:] = R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], 1.0 + trace
    else:
        i, j, k = largest, (largest + 1) % 3, (largest + 2) % 3
        q[i] = 1.0 + 2.0 * R[i, i] - trace
        q[j] = R[j, i] + R[i, j]
        q[k] = R[k, i] + R[i, k]
        q[3] = R[k, j] - R[j, k]
    if q[3] < 0.0:
        q = -q
    unit: FloatArray = q / np.linalg.norm(q)
    return unit


def rotation_from_quaternion_xyzw(q: FloatArray) -> FloatArray:
    """Rotation matrix (3, 3) of the quaternion q (4,) x, y, z, w; q need not be of unit length, but not zero."""
    x, y, z, w = q / np.linalg.norm(q)
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )


def make_T(R: FloatArray, p: FloatArray) -> FloatArray:
    """Transform T (4, 4) with rotation R (3, 3) and translation p (3,), m."""
    T = np.eye(4)
    T[:3, :3] = R
    T[:3, 3] = p
    return T


def inverse_T(T: FloatArray) -> FloatArray:
    """T_B_A (4, 4) from T_A_B (4, 4)."""
    R = T[:3, :3].T
    return make_T(R, -R @ T[:3, 3])


def perturb(T: FloatArray, delta: FloatArray) -> FloatArray:
    """T (4, 4) moved by delta (6,) = (dp, dtheta): p + dp and exp([dtheta]x) R, both in the outer frame (m, rad)."""
    return make_T(exp(delta[3:]) @ T[:3, :3], T[:3, 3] + delta[:3])


def difference(T: FloatArray, T_reference: FloatArray) -> FloatArray:
    """delta (6,) with perturb(T_reference, delta) = T; the error that a pose covariance speaks of (m, rad)."""
    return np.concatenate([T[:3, 3] - T_reference[:3, 3], log(T[:3, :3] @ T_reference[:3, :3].T)])
