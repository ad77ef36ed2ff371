"""The target's edges in the rectified views of a rig."""

from __future__ import annotations

import numpy as np

from rvdnav.pose import RectifiedCameras
from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray
from rvdnav.rig import Rig

FAR_PX = 1e4
"""Beyond every image: the core takes no coordinates, and no lengths, larger than this."""


def rectified_cameras(rig: Rig) -> RectifiedCameras:
    """The rig's rectified cameras for the pose mathematics."""
    centers = np.stack([T[:3, 3] for T in rig.T_world_cam])
    return RectifiedCameras(rig.focal_rect, centers, rig.R_world_rect.T)


def rectified_ends(
    cameras: RectifiedCameras, camera: IntArray, T_world_target: FloatArray, edge_points: FloatArray
) -> FloatArray:
    """Ends (n, 2, 3) of edges (n, 2, 3) of the target in the rectified axes of their cameras (n,), from those' centres,
    m."""
    points_W = edge_points @ T_world_target[:3, :3].T + T_world_target[:3, 3]
    ends: FloatArray = (points_W - cameras.centers[camera][:, None]) @ cameras.R_rect_world.T
    return ends


def project_edges(
    cameras: RectifiedCameras, camera: int, T_world_target: FloatArray, edge_points: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Ends of edges (m, 2, 3) of the target in a rectified view.

    Returns image points (m, 2, 2), px from the principal point, and depths (m, 2), m.  Raises PoseError for an end that
    is not in front of the camera.
    """
    points_C = edge_points.reshape(-1, 3)
    points_W = points_C @ T_world_target[:3, :3].T + T_world_target[:3, 3]
    xy = cameras.project(np.full(len(points_C), camera), points_W)
    depths = (points_W - cameras.centers[camera]) @ cameras.R_rect_world[2]
    return xy.reshape(-1, 2, 2), depths.reshape(-1, 2)


def edge_normals(xy: FloatArray) -> FloatArray:
    """Unit normals (m, 2), (-dy, dx), of edges with ends (m, 2, 2), px; 0 for one that is seen end-on."""
    span = xy[:, 1] - xy[:, 0]
    length = np.maximum(np.linalg.norm(span, axis=1), 1e-9)
    normals: FloatArray = np.column_stack([-span[:, 1], span[:, 0]]) / length[:, None]
    return normals


def moved_ends(xy: FloatArray, part: FloatArray, offsets: FloatArray) -> FloatArray:
    """Ends (m, 2, 2) of parts of edges, px, moved towards their normals (-dy, dx).

    part (m, 2): where on its edge each end lies, 0 to 1.  offsets (m, 2), px: of the whole edge's two ends.
    """
    shift = offsets[:, :1] + part * (offsets[:, 1:] - offsets[:, :1])
    moved: FloatArray = xy + shift[:, :, None] * edge_normals(xy)[:, None]
    return moved


def within_reach(xy: FloatArray) -> BoolArray:
    """Which edges (m,) have both their image points (m, 2, 2) where the core takes them; no other crosses an image."""
    return np.asarray((np.abs(xy) <= FAR_PX).all(axis=(1, 2)), np.bool_)


def line_of(xy: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Normal form of the lines through image points (m, 2, 2).

    Returns rho (m,), theta (m,) in [-45°, 135°) and the ends' positions along the line (m, 2), t = -x sin(theta) + y
    cos(theta), the smaller first.
    """
    d = xy[:, 1] - xy[:, 0]
    theta = np.arctan2(d[:, 0], -d[:, 1])
    theta = np.mod(theta + np.pi / 4.0, np.pi) - np.pi / 4.0
    c, s = np.cos(theta), np.sin(theta)
    rho = c * xy[:, 0, 0] + s * xy[:, 0, 1]
    t = -s[:, None] * xy[:, :, 0] + c[:, None] * xy[:, :, 1]
    return rho, theta, np.sort(t, axis=1)


def line_covariance(offset: FloatArray, angle: FloatArray, middle: FloatArray) -> FloatArray:
    """Covariances (n, 2, 2) of (rho, theta), px², px rad, rad², of lines that turn about their middles.

    offset (n,), px²: variance of a line's place across itself at its middle.  angle (n,), rad²: that of its direction.
    middle (n,), px: where that is along the line, t = -x sin(theta) + y cos(theta).  The two errors are independent.
    """
    mixed = middle * angle
    return np.stack([offset + middle * mixed, mixed, mixed, np.broadcast_to(angle, mixed.shape)], axis=1).reshape(
        -1, 2, 2
    )
