"""Lines, side faces and search windows of the navigator against exact geometry."""

from __future__ import annotations

import numpy as np
import pytest
from drawn_scene import bracket_target, example_rig, pose, wide_rig
from hypothesis import given
from hypothesis import strategies as st
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import line_of, project_edges, rectified_cameras
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.navigator.sides import side_separation
from rvdnav.navigator.windows import predicted_windows
from rvdnav.pose import PoseError, PredictedPose, perturb
from scipy.spatial.transform import Rotation

EDGES = 8
UNKNOWN = np.zeros(EDGES, np.int64)
AT_PLACE = np.zeros((EDGES, 2))
coordinate = st.floats(-400.0, 400.0)


@given(coordinate, coordinate, coordinate, coordinate)
def test_the_line_through_two_points_holds_them_both(x0: float, y0: float, x1: float, y1: float) -> None:
    ends = np.array([[[x0, y0], [x1, y1]]])
    if np.hypot(x1 - x0, y1 - y0) < 1.0:
        return
    rho, theta, t = line_of(ends)
    assert -np.pi / 4 <= theta[0] < 3 * np.pi / 4
    # Back from the normal form to points, in either order.
    normal, along = np.array([np.cos(theta[0]), np.sin(theta[0])]), np.array([-np.sin(theta[0]), np.cos(theta[0])])
    back = np.array([rho[0] * normal + position * along for position in t[0]])
    if np.linalg.norm(back[0] - ends[0, 0]) > np.linalg.norm(back[1] - ends[0, 0]):
        back = back[::-1]
    np.testing.assert_allclose(back, ends[0], atol=1e-9)
    assert t[0, 0] <= t[0, 1]


def test_edges_are_projected_as_the_rig_projects_points() -> None:
    rig, bracket = wide_rig(), bracket_target().bracket
    T = pose(0.7, 0.02, 0.08, 5.0, -7.0, 4.0)
    for camera in (0, 1):
        xy, depth = project_edges(rectified_cameras(rig), camera, T, bracket.edge_points)
        points_W = bracket.edge_points @ T[:3, :3].T + T[:3, 3]
        np.testing.assert_allclose(xy, rig.project_rect(camera, points_W), atol=1e-9)
        np.testing.assert_allclose(depth, points_W[..., 0] - rig.T_world_cam[camera][0, 3], atol=1e-12)


@pytest.mark.parametrize("camera", [0, 1])
def test_back_edges_are_seen_where_exact_geometry_puts_them(camera: int) -> None:
    """Against the distance of the back edge's image from the front edge's image line, point by point."""
    rig, bracket = example_rig(), bracket_target().bracket
    cameras = rectified_cameras(rig)
    T = pose(0.6, 0.03, 0.09, 12.0, -9.0, 6.0)
    xy, _ = project_edges(cameras, camera, T, bracket.edge_points)
    _, theta, _ = line_of(xy)
    index = np.full(EDGES, camera)
    separation = side_separation(cameras, T, bracket, index, np.arange(EDGES), theta)

    eye_C = T[:3, :3].T @ (rig.T_world_cam[camera][:3, 3] - T[:3, 3])
    solid_centre = bracket.edge_points.reshape(EDGES // 2, 4, 3).mean(axis=1)[np.arange(EDGES) // 2]
    for edge in range(EDGES):
        a, b = bracket.edge_points[edge]
        face_normal = np.cross(b - a, [1.0, 0.0, 0.0])  # of the side face through the edge
        outwards = np.sign(face_normal @ (a - solid_centre[edge]))
        in_sight = outwards * face_normal @ (eye_C - a) > 0.0
        back_W = T[:3, :3] @ ((a + b) / 2 + [bracket.thickness, 0.0, 0.0]) + T[:3, 3]
        front_W = T[:3, :3] @ ((a + b) / 2) + T[:3, 3]
        shift = rig.project_rect(camera, back_W) - rig.project_rect(camera, front_W)
        across = shift @ [np.cos(theta[edge]), np.sin(theta[edge])]
        assert separation[edge] == pytest.approx(across if in_sight else 0.0, abs=1e-9)
    assert 0 < np.count_nonzero(separation) < EDGES
    assert np.abs(separation).max() > 1.0


def test_side_faces_of_a_flat_bracket_take_no_room() -> None:
    rig, bracket = example_rig(), bracket_target(thickness=0.0).bracket
    separation = side_separation(
        rectified_cameras(rig), pose(0.6, phi=10.0), bracket, np.zeros(EDGES, int), np.arange(EDGES), np.zeros(EDGES)
    )
    np.testing.assert_array_equal(separation, 0.0)


SIGMAS = np.array([4e-3, 2e-3, 2e-3, 0.01, 0.015, 0.012])


def a_prediction() -> PredictedPose:
    mixed = Rotation.from_rotvec([0.4, -0.3, 0.5]).as_matrix()
    correlation = np.block([[mixed, np.zeros((3, 3))], [np.zeros((3, 3)), mixed.T]]) * SIGMAS
    return PredictedPose(pose(0.8, 0.02, 0.06, 4.0, -6.0, 5.0), correlation @ correlation.T)


def test_windows_hold_the_lines_of_poses_drawn_from_the_covariance() -> None:
    """Three sigma on the worse end and the least half-widths on top: each edge lies inside in at least 99.7 %."""
    rig, bracket, settings = wide_rig(), bracket_target().bracket, NavigatorSettings()
    cameras, prediction = rectified_cameras(rig), a_prediction()
    rng = np.random.default_rng(4)
    draws = rng.multivariate_normal(np.zeros(6), prediction.covariance, 1500, method="cholesky")
    for camera in (0, 1):
        windows = predicted_windows(
            prediction, EdgeModel.of_bracket(bracket), cameras, camera, UNKNOWN, AT_PLACE, settings
        )
        assert windows is not None
        np.testing.assert_array_equal(windows["edge"], np.arange(EDGES))
        inside = np.zeros(EDGES)
        for draw in draws:
            true = perturb(prediction.T_world_target, draw)
            rho, theta, _ = line_of(project_edges(cameras, camera, true, bracket.edge_points)[0])
            near = np.abs(rho - windows["rho"]) <= windows["half_rho"]
            inside += near & (np.abs(theta - windows["theta"]) <= windows["half_theta"])
        assert (inside / len(draws)).min() >= 0.997


def test_windows_are_as_narrow_as_their_least_half_widths_when_the_prediction_is_sure() -> None:
    rig, bracket, settings = example_rig(), bracket_target().bracket, NavigatorSettings()
    prediction = PredictedPose(pose(0.8), np.eye(6) * 1e-14)
    windows = predicted_windows(
        prediction, EdgeModel.of_bracket(bracket), rectified_cameras(rig), 0, UNKNOWN, AT_PLACE, settings
    )
    np.testing.assert_allclose(windows["half_rho"], settings.window_min_rho_px, atol=1e-3)
    np.testing.assert_allclose(windows["half_theta"], settings.window_min_theta, atol=1e-5)
    xy, _ = project_edges(rectified_cameras(rig), 0, prediction.T_world_target, bracket.edge_points)
    rho, theta, t = line_of(xy)
    np.testing.assert_allclose(np.column_stack([windows["rho"], windows["theta"]]), np.column_stack([rho, theta]))
    np.testing.assert_allclose(np.column_stack([windows["t_min"], windows["t_max"]]), t)


@pytest.mark.parametrize("camera", [0, 1])
def test_a_light_bar_is_expected_bright_on_the_side_of_its_other_edge(camera: int) -> None:
    rig, bracket = wide_rig(), bracket_target().bracket
    cameras = rectified_cameras(rig)
    T = pose(0.7, 0.02, 0.08, 120.0, -7.0, 5.0)
    light = np.tile([1, -1], EDGES // 2)  # outer edges are bright inwards, inner ones outwards
    prediction = PredictedPose(T, np.eye(6) * 1e-12)
    windows = predicted_windows(
        prediction, EdgeModel.of_bracket(bracket), cameras, camera, light, AT_PLACE, NavigatorSettings()
    )
    middle, _ = project_edges(cameras, camera, T, bracket.edge_points)
    for edge, window in enumerate(windows):
        other = middle[edge ^ 1].mean(axis=0)
        growing = other @ [np.cos(window["theta"]), np.sin(window["theta"])] > window["rho"]
        assert window["polarity"] == (1 if growing else -1)


def test_a_vague_prediction_gives_no_windows() -> None:
    rig, bracket, settings = example_rig(), bracket_target().bracket, NavigatorSettings()
    vague = PredictedPose(pose(0.8), np.diag([0.03, 0.03, 0.03, 0.1, 0.1, 0.1]) ** 2)
    assert (
        predicted_windows(vague, EdgeModel.of_bracket(bracket), rectified_cameras(rig), 0, UNKNOWN, AT_PLACE, settings)
        is None
    )


def test_a_prediction_behind_the_cameras_is_refused() -> None:
    rig, bracket, settings = example_rig(), bracket_target().bracket, NavigatorSettings()
    behind = PredictedPose(pose(-0.5), np.eye(6) * 1e-8)
    with pytest.raises(PoseError):
        predicted_windows(behind, EdgeModel.of_bracket(bracket), rectified_cameras(rig), 0, UNKNOWN, AT_PLACE, settings)


def test_windows_lie_where_the_edges_are_seen_beside_their_projections() -> None:
    """All edges moved by two pixels towards (-dy, dx): so do the windows, by their own normal's sense."""
    rig, bracket, settings = example_rig(), bracket_target().bracket, NavigatorSettings()
    cameras, model = rectified_cameras(rig), EdgeModel.of_bracket(bracket)
    prediction = PredictedPose(pose(0.8, 0.02, 0.05, 10.0, -5.0, 8.0), np.eye(6) * 1e-14)
    at_place = predicted_windows(prediction, model, cameras, 1, UNKNOWN, AT_PLACE, settings)
    moved = predicted_windows(prediction, model, cameras, 1, UNKNOWN, AT_PLACE + 2.0, settings)
    xy, _ = project_edges(cameras, 1, prediction.T_world_target, model.edge_points)
    span = xy[:, 1] - xy[:, 0]
    along_normal = -span[:, 1] * np.cos(at_place["theta"]) + span[:, 0] * np.sin(at_place["theta"])
    np.testing.assert_allclose(moved["rho"] - at_place["rho"], 2.0 * np.sign(along_normal), atol=1e-9)
