"""Triangulation against exact geometry, OpenCV and the printed normal equations."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from pose_scene import CENTERS, FOCAL, R_RECT_WORLD, project
from rvdnav.pose import PoseError, triangulate

M_L, M_R = (
    np.diag([FOCAL, FOCAL, 1.0]) @ np.column_stack([R_RECT_WORLD, -R_RECT_WORLD @ center]) for center in CENTERS
)
POINTS = np.random.default_rng(5).uniform([0.3, -0.3, -0.3], [1.6, 0.3, 0.3], size=(40, 3))
UV_L, UV_R = (project(i, np.eye(4), POINTS) for i in (0, 1))


def test_exact_images_give_back_the_points() -> None:
    assert np.allclose(triangulate(M_L, M_R, UV_L, UV_R), POINTS, atol=1e-11)


def test_agrees_with_opencv() -> None:
    homogeneous = cv2.triangulatePoints(M_L, M_R, UV_L.T.copy(), UV_R.T.copy())
    assert np.allclose(triangulate(M_L, M_R, UV_L, UV_R), (homogeneous[:3] / homogeneous[3]).T, atol=1e-8)


def test_disagreeing_images_are_met_as_the_printed_normal_equations_meet_them() -> None:
    rng = np.random.default_rng(6)
    uv_l, uv_r = (uv + rng.normal(scale=1.0, size=uv.shape) for uv in (UV_L, UV_R))
    for found, left, right in zip(triangulate(M_L, M_R, uv_l, uv_r), uv_l, uv_r, strict=True):
        K, U = [], []
        for M, (u, v) in ((M_L, left), (M_R, right)):
            K += [u * M[2, :3] - M[0, :3], v * M[2, :3] - M[1, :3]]
            U += [M[0, 3] - u * M[2, 3], M[1, 3] - v * M[2, 3]]
        assert np.allclose(found, np.linalg.inv(np.transpose(K) @ K) @ np.transpose(K) @ U, atol=1e-9)


def test_no_points_give_no_points() -> None:
    assert triangulate(M_L, M_R, np.empty((0, 2)), np.empty((0, 2))).shape == (0, 3)


def test_parallel_rays_and_unequal_counts_are_refused() -> None:
    with pytest.raises(PoseError, match="parallel"):
        triangulate(M_L, M_R, np.array([[10.0, 5.0]]), np.array([[10.0, 5.0]]))
    with pytest.raises(ValueError, match="shape"):
        triangulate(M_L, M_R, UV_L, UV_R[:-1])
