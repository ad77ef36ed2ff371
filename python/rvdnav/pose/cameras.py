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
        points = self.R_rect_world @ (p_W - self.centers[camera]).T
        _require_in_front(points)
        xy: FloatArray = (self.focal * points[:2] / points[2]).T
        return xy


@frozen(eq=False)
class DirectedPoints:
    """Points of the target, each with a camera and a direction in its image along which alone it counts.

    p_C (3, n), m; normal (2, n); center (3, n): of the points' cameras, m, in rectified axes.
    """

    cameras: RectifiedCameras
    p_C: FloatArray
    normal: FloatArray
    center: FloatArray

    @classmethod
    def of(cls, cameras: RectifiedCameras, camera: IntArray, p_C: FloatArray, n: FloatArray) -> DirectedPoints:
        """From camera (n,), p_C (n, 3) m and n (n, 2) unit directions in the image."""
        center = (cameras.centers @ cameras.R_rect_world.T)[camera]
        return cls(cameras, *(np.ascontiguousarray(values.T) for values in (p_C, n, center)))

    def project(self, T_world_target: FloatArray) -> tuple[FloatArray, FloatArray]:
        """n · projection of the points, and its derivative with respect to the pose (4, 4).

        Returns values (n,) px and derivatives (n, 6) with respect to (dp, dtheta) of p = p̂ + dp, R = exp([dtheta]x) R̂,
        px/m and px/rad.  Raises PoseError if a point is not in front of its camera.
        """
        rotation, focal = self.cameras.R_rect_world, self.cameras.focal
        arms = (rotation @ T_world_target[:3, :3]) @ self.p_C
        points = arms + ((rotation @ T_world_target[:3, 3])[:, None] - self.center)
        _require_in_front(points)
        inverse_depth = 1.0 / points[2]
        g01 = self.normal * (focal * inverse_depth)
        along = g01[0] * points[0] + g01[1] * points[1]
        g0, g1, g2 = g01[0], g01[1], -along * inverse_depth
        a0, a1, a2 = arms
        # A turn dtheta moves the point by dtheta x arm, and g · (dtheta x arm) = dtheta · (arm x g).
        gradient = np.array([[g0, a1 * g2 - a2 * g1], [g1, a2 * g0 - a0 * g2], [g2, a0 * g1 - a1 * g0]])
        derivative = (rotation.T @ gradient.reshape(3, -1)).reshape(3, 2, -1)
        return along, derivative.transpose(2, 1, 0).reshape(-1, 6)


def project_along(
    cameras: RectifiedCameras, camera: IntArray, T_world_target: FloatArray, p_C: FloatArray, n: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """As `DirectedPoints.project`, for one pose: camera (n,), p_C (n, 3) m, n (n, 2) unit directions in the image."""
    return DirectedPoints.of(cameras, camera, p_C, n).project(T_world_target)


def _require_in_front(points: FloatArray) -> None:
    if not (points[2] > 0.0).all():
        raise PoseError("a point of the target is not in front of the camera")
