"""The bundle adjustment and its covariance, on corners that are known exactly."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from board_scene import BOARD, RIG, T_cam0_boards, exact_corners
from rvdnav.calibration.adjustment import StereoModel, adjust, view_information
from rvdnav.calibration.projection import project_with_derivatives
from rvdnav.camera import CameraModel
from rvdnav.pose import exp, inverse_T, log, make_T
from rvdnav.pose.arrays import FloatArray

BOARDS = T_cam0_boards(12, seed=4)
CORNERS = exact_corners(BOARDS)
T_CAM1_CAM0 = inverse_T(RIG.T_world_cam[1]) @ RIG.T_world_cam[0]
TRUE = StereoModel(RIG.cameras, T_CAM1_CAM0, BOARDS)


def error(model: StereoModel) -> FloatArray:
    """Of the 22 parameters, in the order of the covariance."""
    own = [(c.fx, c.fy, c.cx, c.cy, *c.distortion) for c in (*model.cameras, *TRUE.cameras)]
    turn = log(model.T_cam1_cam0[:3, :3] @ T_CAM1_CAM0[:3, :3].T)
    shift = model.T_cam1_cam0[:3, 3] - T_CAM1_CAM0[:3, 3]
    return np.concatenate([np.subtract(own[0], own[2]), np.subtract(own[1], own[3]), turn, shift])


def test_derivatives_of_the_projection() -> None:
    camera = RIG.cameras[0]
    points = np.random.default_rng(0).uniform((-0.2, -0.15, 0.4), (0.2, 0.15, 0.9), (40, 3))
    pixels, by_point, by_intrinsics = project_with_derivatives(camera, points)
    assert np.allclose(pixels, camera.project(points), atol=1e-9)
    for axis in range(3):
        step = np.eye(3)[axis] * 1e-6
        slope = (camera.project(points + step) - camera.project(points - step)) / 2e-6
        assert np.allclose(by_point[..., axis], slope, rtol=1e-5, atol=1e-4)
    values = np.array([camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion])
    for index in range(8):
        step = np.eye(8)[index] * 1e-5
        above, below = (CameraModel(camera.width, camera.height, *v[:4], v[4:]) for v in (values + step, values - step))
        slope = (above.project(points) - below.project(points)) / 2e-5
        assert np.allclose(by_intrinsics[..., index], slope, rtol=1e-5, atol=1e-4)


def test_exact_corners_give_the_exact_rig() -> None:
    left, right = RIG.cameras
    start = StereoModel(
        cameras=(attrs.evolve(left, fx=left.fx + 5.0, cy=left.cy - 3.0), attrs.evolve(right, distortion=np.zeros(4))),
        T_cam1_cam0=make_T(exp(np.array([0.0, 0.02, 0.01])) @ T_CAM1_CAM0[:3, :3], T_CAM1_CAM0[:3, 3] + 0.01),
        T_cam0_board=np.stack([T @ make_T(exp(np.full(3, 0.01)), np.full(3, 0.005)) for T in BOARDS]),
    )
    found = adjust(start, BOARD.points, CORNERS)
    assert found.rms_px < 1e-9
    assert np.abs(error(found.model)[:4]).max() < 1e-6
    assert np.abs(error(found.model)[-6:]).max() < 1e-9


@pytest.mark.parametrize("shared_px", [0.0, 0.1])
def test_the_covariance_is_true(shared_px: float) -> None:
    """Over many trials, also where the corners of a view err together, by quadratic polynomials over the board."""
    rng = np.random.default_rng(7)
    x, y = (BOARD.points[:, :2] / BOARD.points[:, :2].max(axis=0) * 2.0 - 1.0).T
    shapes = np.stack([x * x, x * y, y * y])
    nees, factors = [], []
    for _ in range(40):
        together = np.einsum("kn,vcki->vcni", shapes, rng.normal(0.0, 1.0, (len(CORNERS), 2, 3, 2)))
        found = adjust(TRUE, BOARD.points, CORNERS + rng.normal(0.0, 0.1, CORNERS.shape) + shared_px * together)
        e = error(found.model)
        nees.append(e @ np.linalg.solve(found.covariance, e) / len(e))
        factors.append(found.correlation)
    assert 0.75 < np.mean(nees) < 1.45
    assert np.median(factors) < 1.2 if shared_px == 0.0 else np.median(factors) > 2.0


def test_corners_not_seen_are_left_out() -> None:
    uv = CORNERS.copy()
    uv[3, 0, :9] = np.nan
    uv[3, 1, 5] = np.nan
    found = adjust(TRUE, BOARD.points, uv)
    assert found.rms_px < 1e-9
    assert np.isnan(found.residuals[3, 1, 5]).all()
    assert np.isfinite(found.residuals[3, 1, 6]).all()


def test_the_information_of_views_adds_up() -> None:
    found = adjust(TRUE, BOARD.points, CORNERS)
    assert np.allclose(view_information(TRUE, BOARD.points, CORNERS).sum(axis=0), found.normal, rtol=1e-6)
