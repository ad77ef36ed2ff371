"""A bracket before a stereo pair, projected by OpenCV: the independent truth of the pose tests."""

from __future__ import annotations

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray
from rvdnav.pose import LineMeasurements, RectifiedCameras, make_T

Array = NDArray[np.float64]

FOCAL = 670.0
# Rectified axes x = -z_W, y = y_W, z = x_W; the left camera is 0.12 m along z_W.
R_RECT_WORLD = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
CENTERS = np.array([[0.0, 0.0, 0.12], [0.0, 0.0, 0.0]])
CAMERAS = RectifiedCameras(FOCAL, CENTERS, R_RECT_WORLD)

OUTER = np.array([[0.0, -0.09, 0.0], [0.0, 0.09, 0.0], [0.0, 0.045, 0.14], [0.0, -0.045, 0.14]])
INNER = np.array([[0.0, -0.0708, 0.014], [0.0, 0.0708, 0.014], [0.0, 0.0348, 0.126], [0.0, -0.0348, 0.126]])
# The bracket's 8 front edges (8, 2, 3): l1, l2, the two legs; outer and inner.
EDGES = np.array([[ring[a], ring[b]] for a, b in ((0, 1), (2, 3), (1, 2), (3, 0)) for ring in (OUTER, INNER)])


def rotation(rotation_vector: list[float]) -> Array:
    return np.asarray(cv2.Rodrigues(np.array(rotation_vector))[0], dtype=np.float64)


def pose(range_m: float = 0.9) -> Array:
    return make_T(rotation([0.15, -0.2, 0.1]), np.array([range_m, 0.03, 0.02]))


def project(camera: int, T: Array, p_C: Array) -> Array:
    """Rectified image points (n, 2) by cv2.projectPoints."""
    R = R_RECT_WORLD @ T[:3, :3]
    t = R_RECT_WORLD @ (T[:3, 3] - CENTERS[camera])
    K = np.diag([FOCAL, FOCAL, 1.0])
    points, _ = cv2.projectPoints(p_C, cv2.Rodrigues(R)[0], t, K, None)
    return np.asarray(points, dtype=np.float64).reshape(-1, 2)


@attrs.frozen(eq=False)
class Samples:
    """Places where edges were found, as `fit_edge_lines` takes them."""

    camera: NDArray[np.int64]
    edge: NDArray[np.int64]
    q: Array
    n: Array
    sigma: Array

    def moved(self, distance: Array) -> Samples:
        """The samples moved along their normals by distance (k,) px."""
        return attrs.evolve(self, q=self.q + distance[:, None] * self.n)


def exact_samples(T: Array, per_edge: int = 60, sigma: float = 0.1, cameras: tuple[int, ...] = (0, 1)) -> Samples:
    """Samples on the true edges, each displaced along its edge by up to 2 px, which must not matter."""
    camera, edge, q, n = [], [], [], []
    place = np.linspace(0.05, 0.95, per_edge)[:, None]
    for i in cameras:
        for e, (a, b) in enumerate(EDGES):
            ends = project(i, T, EDGES[e])
            tangent = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
            normal = np.array([-tangent[1], tangent[0]])
            camera.append(np.full(per_edge, i))
            edge.append(np.full(per_edge, e))
            q.append(project(i, T, a + place * (b - a)) + np.linspace(-2.0, 2.0, per_edge)[:, None] * tangent)
            n.append(np.tile(normal, (per_edge, 1)))
    joined = [np.concatenate(x) for x in (camera, edge, q, n)]
    return Samples(*joined, np.full(len(joined[0]), sigma))


def exact_lines(T: Array, cov: Array, edges: tuple[int, ...] = tuple(range(8))) -> LineMeasurements:
    """The true images of the edges in both cameras as (rho, theta), theta in [-45°, 135°)."""
    keys = [(i, e) for i in (0, 1) for e in edges]
    rho, theta = [], []
    for i, e in keys:
        (x0, y0), (x1, y1) = project(i, T, EDGES[e])
        angle = np.arctan2(x1 - x0, y0 - y1)
        angle = (angle + np.pi / 4) % np.pi - np.pi / 4
        theta.append(angle)
        rho.append(x0 * np.cos(angle) + y0 * np.sin(angle))
    camera, edge = np.array(keys).T
    return LineMeasurements(camera, edge, EDGES[edge], np.array(rho), np.array(theta), np.tile(cov, (len(keys), 1, 1)))
