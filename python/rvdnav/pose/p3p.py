"""Pose from three points seen in one view: distances along their rays, then the paper's equations (6)-(8).

The distances s of the points from the camera's centre obey the law of cosines in the triangle of each pair,
    s_i² + s_j² - 2 s_i s_j cos(angle of the rays) = |P_i - P_j|².
From a prediction Newton's method solves the three equations; without one they reduce to a quartic, which has up to four
solutions (J. A. Grunert, "Das Pothenotische Problem in erweiterter Gestalt", 1841; in the form of R. M. Haralick and
others, "Review and analysis of solutions of the three point perspective pose estimation problem", 1994).
"""

from __future__ import annotations

import numpy as np

from rvdnav.pose.arrays import FloatArray, float_array
from rvdnav.pose.errors import PoseError
from rvdnav.pose.threepoint import three_point_pose

_MAX_ITERATIONS = 20
_CONVERGED = 1e-12
_SAME = 1e-6
# Imaginary part, relative to the root, up to which a double root of the quartic that rounding split counts as real.
_NEARLY_REAL = 1e-3
_PAIRS = ((0, 1), (1, 2), (2, 0))


def iterative_three_point_pose(rays: FloatArray, points_C: FloatArray, prior: FloatArray) -> FloatArray:
    """T_camera_target (4, 4) from rays (3, 3), one a row, to points_C (3, 3), m, near a predicted pose (4, 4).

    The rays are in the camera's axes, of any length.  Raises PoseError where the iteration does not converge.
    """
    units, points_C = _units(rays), float_array(points_C, 3, 3)
    start = np.linalg.norm(points_C @ prior[:3, :3].T + prior[:3, 3], axis=1)
    return _pose(units, _newton(units, points_C, start), points_C)


def p3p(rays: FloatArray, points_C: FloatArray) -> list[FloatArray]:
    """All T_camera_target (4, 4) that put points_C (3, 3), m, on rays (3, 3), one a row, before the camera.

    Up to four, in the order of the first point's distance.  Raises PoseError for points that are collinear or coincide.
    """
    units, points_C = _units(rays), float_array(points_C, 3, 3)
    solutions: list[FloatArray] = []
    for start in _quartic_distances(units, points_C):
        try:
            distances = _newton(units, points_C, start)
        except PoseError:
            continue
        if not any(np.abs(distances - other).max() < _SAME * distances.max() for other in solutions):
            solutions.append(distances)
    return [_pose(units, distances, points_C) for distances in sorted(solutions, key=lambda s: float(s[0]))]


def _units(rays: FloatArray) -> FloatArray:
    rays = float_array(rays, 3, 3)
    units: FloatArray = rays / np.linalg.norm(rays, axis=1, keepdims=True)
    return units


def _pose(units: FloatArray, distances: FloatArray, points_C: FloatArray) -> FloatArray:
    return three_point_pose(units * distances[:, None], points_C)


def _newton(units: FloatArray, points_C: FloatArray, start: FloatArray) -> FloatArray:
    s: FloatArray = start.copy()
    scale = float(start.max())
    cosines = np.array([units[i] @ units[j] for i, j in _PAIRS])
    squares = np.array([float(np.sum((points_C[i] - points_C[j]) ** 2)) for i, j in _PAIRS])
    for _ in range(_MAX_ITERATIONS):
        residual = np.zeros(3)
        jacobian = np.zeros((3, 3))
        for k, (i, j) in enumerate(_PAIRS):
            residual[k] = s[i] ** 2 + s[j] ** 2 - 2.0 * s[i] * s[j] * cosines[k] - squares[k]
            jacobian[k, i] = 2.0 * (s[i] - s[j] * cosines[k])
            jacobian[k, j] = 2.0 * (s[j] - s[i] * cosines[k])
        # At a double solution the matrix is singular; the shortest step still leads there.
        step = np.linalg.lstsq(jacobian, residual, rcond=1e-12)[0]
        s = s - step
        if np.abs(step).max() < _CONVERGED * scale:
            break
    if not (np.isfinite(s).all() and (s > 0.0).all() and np.abs(residual).max() < _SAME * squares.max()):
        raise PoseError("the three points' distances do not converge")
    return s


def _quartic_distances(units: FloatArray, points_C: FloatArray) -> list[FloatArray]:
    """Distances (3,) of the points, to the rounding of the quartic's roots; v = s_3 / s_1, u = s_2 / s_1."""
    a2 = float(np.sum((points_C[1] - points_C[2]) ** 2))
    b2 = float(np.sum((points_C[0] - points_C[2]) ** 2))
    c2 = float(np.sum((points_C[0] - points_C[1]) ** 2))
    if min(a2, b2, c2) <= 0.0:
        raise PoseError("two of the points coincide: they determine no attitude")
    cos_a, cos_b, cos_c = units[1] @ units[2], units[0] @ units[2], units[0] @ units[1]
    p, q, r = (a2 - c2) / b2, (a2 + c2) / b2, c2 / b2
    k = a2 / b2
    coefficients = [
        (p - 1.0) ** 2 - 4.0 * r * cos_a**2,
        4.0 * (p * (1.0 - p) * cos_b - (1.0 - q) * cos_a * cos_c + 2.0 * r * cos_a**2 * cos_b),
        2.0
        * (
            p**2
            - 1.0
            + 2.0 * p**2 * cos_b**2
            + 2.0 * (1.0 - r) * cos_a**2
            - 4.0 * q * cos_a * cos_b * cos_c
            + 2.0 * (1.0 - k) * cos_c**2
        ),
        4.0 * (-p * (1.0 + p) * cos_b + 2.0 * k * cos_c**2 * cos_b - (1.0 - q) * cos_a * cos_c),
        (1.0 + p) ** 2 - 4.0 * k * cos_c**2,
    ]
    found = []
    for root in np.roots(coefficients):
        if abs(root.imag) > _NEARLY_REAL * abs(root) or root.real <= 0.0:
            continue
        v = float(root.real)
        denominator = 2.0 * (cos_c - v * cos_a)
        if abs(denominator) < 1e-12:
            continue
        u = ((p - 1.0) * v**2 - 2.0 * p * cos_b * v + 1.0 + p) / denominator
        square = b2 / (1.0 + v**2 - 2.0 * v * cos_b)
        if u > 0.0 and square > 0.0:
            s = float(np.sqrt(square))
            found.append(np.array([s, u * s, v * s]))
    return found
