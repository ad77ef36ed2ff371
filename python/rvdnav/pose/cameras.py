"""The rectified camera pair as the pose estimation sees it: two pinholes with one focal length and common axes."""

from __future__ import annotations

import numpy as np
from attrs import field, frozen

from rvdnav.pose.arrays import FloatArray, IntArray, float_array
from rvdnav.pose.errors import PoseError


def _centers(values: FloatArray) -> FloatArray:
    return float_array(values, None, 3)


def _rotation(values: FloatArray) -> FloatArray:
    return float_array(values, 3, 3)


@frozen(eq=False)
class RectifiedCameras:
    """Rectified pinholes: x = f X/Z, y = f Y/Z, px from the principal point, with (X, Y, Z) = R_rect_world (p_W - c).

    focal: the common focal length, px.  centers: the cameras' centres c in W (n, 3), m, left first.
    R_rect_world: rotation (3, 3) from W to the rectified axes (x along the rows, y down, z forward).
    """

    focal: float
    centers: FloatArray = field(converter=_centers)
    R_rect_world: FloatArray = field(converter=_rotation)

    def project(self, camera: IntArray, p_W: FloatArray) -> FloatArray:
        """Image points (n, 2) of p_W (n, 3) in camera (n,), rectified px from the principal point.

        Raises PoseError if a point is not in front of its camera.
        """
        x, y, z = _rectify(self, camera, p_W.T, np.zeros(3))
        return self.focal * np.column_stack([x / z, y / z])


def project_along(
    cameras: RectifiedCameras, camera: IntArray, T_world_target: FloatArray, p_C: FloatArray, n: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """n · projection of the target's points, and its derivative with respect to the pose.

    camera (n,), p_C (n, 3) m, n (n, 2) directions in the image.  Returns values (n,) px and derivatives (n, 6) with
    respect to (dp, dtheta) of p = p̂ + dp, R = exp([dtheta]x) R̂, px/m and px/rad.
    Raises PoseError if a point is not in front of its camera.
    """
    a = T_world_target[:3, :3] @ p_C.T
    x, y, z = _rectify(cameras, camera, a, T_world_target[:3, 3])
    along = (n[:, 0] * x + n[:, 1] * y) / z
    gradient_rect = np.stack([n[:, 0], n[:, 1], -along]) * (cameras.focal / z)
    g = cameras.R_rect_world.T @ gradient_rect
    derivative = np.empty((6, len(n)))
    derivative[:3] = g
    # A turn dtheta moves the point by dtheta x a, and g · (dtheta x a) = dtheta · (a x g).
    derivative[3] = a[1] * g[2] - a[2] * g[1]
    derivative[4] = a[2] * g[0] - a[0] * g[2]
    derivative[5] = a[0] * g[1] - a[1] * g[0]
    return cameras.focal * along, derivative.T


def _rectify(cameras: RectifiedCameras, camera: IntArray, arms_W: FloatArray, p_W: FloatArray) -> FloatArray:
    """Rectified coordinates (3, n), m, of the points p_W (3,) + arms_W (3, n), each in its own camera (n,)."""
    shifts = cameras.R_rect_world @ (p_W - cameras.centers).T
    points: FloatArray = cameras.R_rect_world @ arms_W + shifts[:, camera]
    if not (points[2] > 0.0).all():
        raise PoseError("a point of the target is not in front of the camera")
    return points
