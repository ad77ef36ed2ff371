"""A camera's projection with its derivatives, as the bundle adjustment and its covariance need them."""

from __future__ import annotations

import numpy as np

from rvdnav.camera import CameraModel
from rvdnav.pose.arrays import FloatArray


def project_with_derivatives(camera: CameraModel, p_C: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Pixels (..., 2) of points (..., 3) in the camera frame, m, with their derivatives.

    The second value (..., 2, 3) is by the point, px/m, the third (..., 2, 8) by fx, fy, cx, cy, k1, k2, p1, p2.
    """
    k1, k2, p1, p2 = camera.distortion
    z = p_C[..., 2]
    x, y = p_C[..., 0] / z, p_C[..., 1] / z
    r2 = x * x + y * y
    radial = 1.0 + r2 * (k1 + r2 * k2)
    u = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
    v = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
    slope = 2.0 * k1 + 4.0 * k2 * r2  # d radial / dx = slope x
    u_x = camera.fx * (radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x)
    v_y = camera.fy * (radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x)
    cross = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y
    u_y, v_x = camera.fx * cross, camera.fy * cross
    by_point = np.stack(
        [np.stack([a / z, b / z, -(a * x + b * y) / z], axis=-1) for a, b in ((u_x, u_y), (v_x, v_y))], axis=-2
    )
    one, zero = np.ones_like(x), np.zeros_like(x)
    by_intrinsics = np.stack(
        [
            np.stack([u, zero, one, zero, *(camera.fx * term for term in _terms(x, x, y, r2))], axis=-1),
            np.stack([zero, v, zero, one, *(camera.fy * term for term in _terms(y, x, y, r2))], axis=-1),
        ],
        axis=-2,
    )
    pixels = np.stack([camera.fx * u + camera.cx, camera.fy * v + camera.cy], axis=-1)
    return pixels, by_point, by_intrinsics


def _terms(w: FloatArray, x: FloatArray, y: FloatArray, r2: FloatArray) -> tuple[FloatArray, ...]:
    """What k1, k2, p1 and p2 each add to the coordinate w, which is x or y."""
    doubled = 2.0 * x * y
    bulge = r2 + 2.0 * w * w
    return w * r2, w * r2 * r2, *((doubled, bulge) if w is x else (bulge, doubled))
