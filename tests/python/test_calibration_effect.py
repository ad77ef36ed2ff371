"""The calibration's part of a pose's covariance: against poses solved anew under other calibrations."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from drawn_scene import bracket_target, draw_frame, example_rig, pose, wide_rig
from rvdnav import Navigator, Rig
from rvdnav.camera import CameraModel
from rvdnav.navigator.calibration import CalibrationEffect
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.pose import LineMeasurements, PoseError, RefinedPose, difference, refine_pose_edges
from rvdnav.rig import calibration_parameters

BRACKET = bracket_target().bracket
COV = np.diag([0.05**2, 0.0005**2])
POSES = [pose(0.45, 0.02, 0.08, 8.0, -12.0, 5.0), pose(1.2, -0.1, 0.02, -5.0, 20.0, -8.0)]
# Of a usable calibration: px, none, rad, m.
SIGMA = np.array([0.4, 0.4, 0.5, 0.5, 2e-3, 5e-3, 1e-4, 1e-4] * 2 + [5e-4, 5e-4, 3e-4, 5e-5, 5e-5, 5e-5])


def one_camera() -> Rig:
    rig = wide_rig()
    return Rig(rig.cameras[:1], rig.T_world_cam[:1])


def raw_edges(rig: Rig, T: np.ndarray) -> list[tuple[int, int, np.ndarray]]:
    """Camera, edge and the raw pixels along it that lie on the image."""
    found = []
    w = (np.arange(60)[:, None] + 0.5) / 60
    for camera in range(len(rig.cameras)):
        for edge, (a, b) in enumerate(BRACKET.edge_points):
            uv = rig.project(camera, (a + w * (b - a)) @ T[:3, :3].T + T[:3, 3])
            on_image = ((uv > 0) & (uv < [rig.width - 1, rig.height - 1])).all(axis=1)
            if on_image.sum() > 10:
                found.append((camera, edge, uv[on_image]))
    return found


def solve(rig: Rig, edges: list[tuple[int, int, np.ndarray]], T: np.ndarray) -> tuple[RefinedPose, LineMeasurements]:
    """The pose that raw edges give under a calibration: straight lines through the rectified points, then the fit."""
    rho, theta = [], []
    for camera, _, uv in edges:
        xy = rig.raw_to_rect(camera, uv)
        middle = xy.mean(axis=0)
        normal = np.linalg.svd(xy - middle)[2][1]
        normal *= np.sign(normal[0] + normal[1])
        rho.append(float(normal @ middle))
        theta.append(float(np.arctan2(normal[1], normal[0])))
    camera, edge = np.array([key[:2] for key in edges]).T
    cov = np.tile(COV, (len(edges), 1, 1))
    lines = LineMeasurements(camera, edge, BRACKET.edge_points[edge], rho, theta, cov)
    return refine_pose_edges(T, lines, rectified_cameras(rig)), lines


def whitened_error(found: np.ndarray, expected: np.ndarray) -> float:
    """Difference of two pose changes as a part of the expected one; 0.5 m of arm makes a turn a length."""
    scale = np.repeat([1.0, 0.5], 3)
    return float(np.linalg.norm(scale * (found - expected)) / np.linalg.norm(scale * expected))


@pytest.mark.parametrize("rig", [example_rig(), wide_rig(), one_camera()], ids=["example", "wide", "one camera"])
@pytest.mark.parametrize("T", POSES, ids=["near", "far"])
def test_each_parameter_moves_the_pose_as_a_solution_anew_says(rig: Rig, T: np.ndarray) -> None:
    edges = raw_edges(rig, T)
    refined, lines = solve(rig, edges, T)
    derivative = CalibrationEffect.of(rig).pose_derivative(refined, lines)
    for index in range(derivative.shape[1]):
        delta = np.zeros(derivative.shape[1])
        delta[index] = 0.02 * SIGMA[index]
        above, below = (solve(rig.perturbed(sign * delta), edges, T)[0].T_world_target for sign in (1.0, -1.0))
        expected = difference(above, below) / (2.0 * delta[index])
        assert whitened_error(derivative[:, index], expected) < 0.03, calibration_parameters(len(rig.cameras))[index]


def test_a_bracket_partly_out_of_view() -> None:
    rig, T = wide_rig(), pose(0.3, 0.06, 0.12, 4.0, -6.0, 10.0)
    edges = raw_edges(rig, T)
    full = np.array([len(uv) for _, _, uv in edges])
    assert full.min() < 50
    refined, lines = solve(rig, edges, T)
    delta = 0.02 * SIGMA * np.random.default_rng(5).standard_normal(22)
    above, below = (solve(rig.perturbed(sign * delta), edges, T)[0].T_world_target for sign in (1.0, -1.0))
    found = 2.0 * CalibrationEffect.of(rig).pose_derivative(refined, lines) @ delta
    assert whitened_error(found, difference(above, below)) < 0.03


@pytest.mark.parametrize("view", [0, 1])
def test_a_stereo_rig_with_one_view(view: int) -> None:
    rig, T = wide_rig(), POSES[0]
    edges = [edge for edge in raw_edges(rig, T) if edge[0] == view]
    refined, lines = solve(rig, edges, T)
    delta = 0.02 * SIGMA * np.random.default_rng(6).standard_normal(22)
    above, below = (solve(rig.perturbed(sign * delta), edges, T)[0].T_world_target for sign in (1.0, -1.0))
    found = 2.0 * CalibrationEffect.of(rig).pose_derivative(refined, lines) @ delta
    assert whitened_error(found, difference(above, below)) < 0.03


def test_the_covariance_is_that_of_poses_under_drawn_calibrations() -> None:
    rng = np.random.default_rng(11)
    mixing = np.diag(0.1 * SIGMA) @ (np.eye(22) + 0.15 * rng.standard_normal((22, 22)))
    rig = attrs.evolve(wide_rig(), calibration_covariance=mixing @ mixing.T)
    T = POSES[0]
    edges = raw_edges(rig, T)
    refined, lines = solve(rig, edges, T)
    stated = CalibrationEffect.of(rig).pose_covariance(refined, lines)
    errors = [
        difference(solve(rig.perturbed(mixing @ rng.standard_normal(22)), edges, T)[0].T_world_target, T)
        for _ in range(200)
    ]
    squares = np.einsum("ni,ij,nj->n", errors, np.linalg.inv(stated), errors)
    assert 0.85 < squares.mean() / 6.0 < 1.15
    np.testing.assert_allclose(np.std(errors, axis=0), np.sqrt(np.diag(stated)), rtol=0.15)


def test_the_navigator_states_it_and_keeps_it_from_its_filter() -> None:
    """What a calibration leaves open is the same in all frames, so that a filter that averages errors isn't told."""
    target = bracket_target()
    plain, rig = (attrs.evolve(wide_rig(), calibration_covariance=f * np.diag(SIGMA**2)) for f in (0.0, 1.0))
    frames = [draw_frame(plain, target, pose(0.6 - 0.005 * i), timestamp_ns=10**9 + i * 10**8) for i in range(3)]
    stated, unstated = Navigator(rig, target), Navigator(plain, target)
    for frame in frames:
        one, other = stated.process(frame), unstated.process(frame)
        assert one.covariance is not None
        assert other.covariance is not None
        error = difference(one.T_world_target, other.T_world_target)
        assert float(error @ np.linalg.solve(one.covariance + other.covariance, error)) < 20.0
        # The baseline's 0.05 mm alone are worth this much of the range.
        assert np.sqrt(one.covariance[0, 0]) > 0.5 * 5e-5 / plain.baseline
    following = [np.trace(navigator.memory.filter_state.covariance[:3, :3]) for navigator in (stated, unstated)]
    assert following[0] < 0.25 * np.trace(one.covariance[:3, :3])
    coasting = stated.process(attrs.evolve(frames[-1], timestamp_ns=10**9 + 3 * 10**8, left=None, right=None))
    assert coasting.covariance is not None
    assert np.trace(coasting.covariance[:3, :3]) > np.trace(one.covariance[:3, :3])


def test_a_lens_that_folds_back_in_a_corner() -> None:
    """A public calibration whose polynomial turns round within one corner: the effect is that of the other pixels."""
    camera = CameraModel(
        1280, 720, 863.728, 863.222, 637.524, 385.529, [0.0885275, -0.225994, -0.000152622, 0.000566247]
    )
    assert camera.pixels_without_ray > 0
    rig = Rig((camera,), wide_rig().T_world_cam[:1])
    effect = CalibrationEffect.of(rig)
    assert np.isfinite(effect.shift).all()
    T = POSES[0]
    edges = raw_edges(rig, T)
    solved, lines = solve(rig, edges, T)
    derivative = effect.pose_derivative(solved, lines)
    for parameter in (0, 2, 4):
        delta = np.zeros(8)
        delta[parameter] = SIGMA[parameter]
        above, below = (solve(rig.perturbed(sign * delta), edges, T)[0].T_world_target for sign in (1, -1))
        expected = difference(above, below) / (2.0 * SIGMA[parameter])
        assert np.allclose(derivative[:, parameter], expected, rtol=0.05, atol=0.05 * np.abs(expected).max())


@pytest.mark.parametrize("T", [POSES[0], pose(0.3, 0.06, 0.12, 4.0, -6.0, 10.0)], ids=["in view", "partly out of view"])
def test_line_derivatives_are_those_of_the_shifted_points(T: np.ndarray) -> None:
    """By numpy: projections by finite differences, polynomials evaluated point by point, a line fitted through them."""
    rig = wide_rig()
    _, lines = solve(rig, raw_edges(rig, T), T)
    effect = CalibrationEffect.of(rig)
    last = np.array([rig.width - 1.0, rig.height - 1.0])

    def distances(camera: int, ends_W: np.ndarray, normal: np.ndarray, rho: float) -> np.ndarray:
        return np.asarray(rig.project_rect(camera, ends_W) @ normal - rho)

    expected = np.zeros((len(lines), 2, 22))
    for i, (camera, rho, theta) in enumerate(zip(lines.camera, lines.rho, lines.theta, strict=True)):
        normal, tangent = np.array([np.cos(theta), np.sin(theta)]), np.array([-np.sin(theta), np.cos(theta)])
        ends_W = lines.endpoints_C[i] @ T[:3, :3].T + T[:3, 3]
        t = rig.project_rect(camera, ends_W) @ tangent
        places = t[0] + (np.arange(16) + 0.5) / 16 * (t[1] - t[0])
        scaled = 2.0 * rig.rect_to_raw(camera, rho * normal + places[:, None] * tangent) / last - 1.0
        on_image = (np.abs(scaled) <= 1.0).all(axis=1)
        assert on_image.sum() >= 2
        across = distances(camera, ends_W, normal, rho) + rho
        for k in range(22):
            x, y = (
                np.polynomial.chebyshev.chebval2d(*scaled[on_image].T, effect.shift[camera, :, axis, k].reshape(12, 12))
                for axis in (0, 1)
            )
            fit = np.polyfit(places[on_image], normal[0] * x + normal[1] * y, 1)
            step = 1e-6 * effect.centers[camera, :, k]
            moved = distances(camera, ends_W + step, normal, rho) - distances(camera, ends_W - step, normal, rho)
            by_focal = across / rig.focal_rect * effect.focal[k]
            expected[i, :, k] = by_focal - moved / 2e-6 - np.polyval(fit, t)
    found = effect.residual_derivatives(T, lines)
    assert np.all(np.abs(found - expected) <= 1e-6 * np.abs(expected).max(axis=(0, 1)) + 1e-9)
    mixing = np.random.default_rng(2).standard_normal((22, 5))
    np.testing.assert_allclose(effect.of_combinations(mixing).residual_derivatives(T, lines), found @ mixing, atol=1e-9)


def test_an_edge_behind_the_camera_is_no_geometry() -> None:
    rig = wide_rig()
    _, lines = solve(rig, raw_edges(rig, POSES[0]), POSES[0])
    with pytest.raises(PoseError, match="in front"):
        CalibrationEffect.of(rig).residual_derivatives(pose(-0.45, 0.02, 0.08, 8.0, -12.0, 5.0), lines)
