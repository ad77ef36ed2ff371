"""Refinement over fitted lines: derivatives, exact lines, robustness, covariance."""

from __future__ import annotations

import numpy as np
import pytest
from pose_scene import CAMERAS, EDGES, Array, exact_lines, pose, project
from rvdnav.pose import (
    LineMeasurements,
    PoseError,
    RectifiedCameras,
    difference,
    line_residuals,
    perturb,
    refine_pose_lines,
)
from scipy.optimize import least_squares

COV = np.diag([0.4**2, 0.004**2])
START = np.array([0.03, -0.02, 0.02, 0.05, -0.04, 0.06])


def opencv_distances(T: Array, lines: LineMeasurements) -> Array:
    rows = []
    for i, ends, rho, theta in zip(lines.camera, lines.endpoints_C, lines.rho, lines.theta, strict=True):
        rows.append(project(int(i), T, ends) @ [np.cos(theta), np.sin(theta)] - rho)
    return np.array(rows)


def with_errors(lines: LineMeasurements, d_rho: Array, d_theta: Array) -> LineMeasurements:
    return LineMeasurements(
        lines.camera, lines.edge, lines.endpoints_C, lines.rho + d_rho, lines.theta + d_theta, lines.cov
    )


def noisy_lines(seed: int, scale: float = 1.0) -> LineMeasurements:
    d_rho, d_theta = np.random.default_rng(seed).multivariate_normal(np.zeros(2), scale**2 * COV, size=16).T
    return with_errors(exact_lines(pose(), COV), d_rho, d_theta)


def whitened(lines: LineMeasurements, T_start: Array) -> list[Array]:
    """Inverse Cholesky factors of the lines' distances at the start, with 0.02 px of each endpoint's own."""
    factors = []
    for i, ends, theta, cov in zip(lines.camera, lines.endpoints_C, lines.theta, lines.cov, strict=True):
        xy = project(int(i), T_start, ends)
        G = np.column_stack([[-1.0, -1.0], xy @ [-np.sin(theta), np.cos(theta)]])
        factors.append(np.linalg.inv(np.linalg.cholesky(G @ cov @ G.T + 0.02**2 * np.eye(2))))
    return factors


def numeric_jacobian(T: Array, lines: LineMeasurements) -> Array:
    h = 1e-6
    columns = [
        (opencv_distances(perturb(T, d), lines) - opencv_distances(perturb(T, -d), lines)) / (2 * h)
        for d in np.eye(6) * h
    ]
    return np.stack(columns, axis=2)


def test_projection_is_that_of_opencv() -> None:
    T = pose()
    points = EDGES.reshape(-1, 3)
    for i in (0, 1):
        found = CAMERAS.project(np.full(len(points), i), points @ T[:3, :3].T + T[:3, 3])
        assert np.allclose(found, project(i, T, points), atol=1e-9)


def test_without_robustness_it_is_the_least_squares_solution() -> None:
    lines = noisy_lines(23)
    start = perturb(pose(), 0.1 * START)
    factors = whitened(lines, start)

    def whitened_distances(d: Array) -> Array:
        distances = opencv_distances(perturb(pose(), d), lines)
        return np.concatenate([W @ r for W, r in zip(factors, distances, strict=True)])

    expected = least_squares(whitened_distances, np.zeros(6), x_scale="jac", xtol=1e-12)
    refined = refine_pose_lines(start, lines, CAMERAS, loss="huber", k=1e6)
    assert np.allclose(difference(refined.T_world_target, pose()), expected.x, atol=1e-7)
    assert refined.sigma0 == pytest.approx(np.sqrt(2.0 * expected.cost / 26.0), rel=1e-6)
    omega_squared = max(2.0 * expected.cost / 26.0, 1.0)
    J = numeric_jacobian(refined.T_world_target, lines)
    information = sum((W @ D).T @ (W @ D) for W, D in zip(factors, J, strict=True))
    assert np.allclose(refined.covariance, omega_squared * np.linalg.inv(information), rtol=1e-4)


@pytest.mark.parametrize("loss", ["tukey", "huber"])
def test_the_minimum_is_stationary_under_its_weights(loss: str) -> None:
    lines = noisy_lines(24, scale=3.0)
    start = perturb(pose(), 0.1 * START)
    refined = refine_pose_lines(start, lines, CAMERAS, loss=loss)
    assert refined.converged
    assert refined.weights.min() < 1.0
    factors = whitened(lines, start)
    distances, derivatives = line_residuals(refined.T_world_target, lines, CAMERAS)
    J = np.array([W @ D for W, D in zip(factors, derivatives, strict=True)])
    r = np.array([W @ d for W, d in zip(factors, distances, strict=True)])
    score = np.einsum("n,nki,nk->i", refined.weights, J, r)
    information = np.einsum("n,nki,nkj->ij", refined.weights, J, J)
    # In standard deviations of the pose.
    assert np.sqrt(score @ np.linalg.solve(information, score)) < 2e-3


def test_two_starts_end_in_one_minimum() -> None:
    lines = noisy_lines(25)
    ends = [refine_pose_lines(perturb(pose(), s * 0.02 * START), lines, CAMERAS) for s in (-1.0, 1.0)]
    error = difference(ends[0].T_world_target, ends[1].T_world_target)
    # The lines are whitened where the start puts their ends.
    assert np.sqrt(error @ np.linalg.solve(ends[0].covariance, error)) < 0.02


def test_the_same_input_gives_the_same_bits() -> None:
    one, two = (refine_pose_lines(perturb(pose(), START), noisy_lines(26), CAMERAS) for _ in range(2))
    assert np.array_equal(one.T_world_target, two.T_world_target)
    assert np.array_equal(one.covariance, two.covariance)


def test_one_camera_suffices() -> None:
    lines = exact_lines(pose(0.6), COV)
    kept = lines.camera == 1
    right = LineMeasurements(
        *(v[kept] for v in (lines.camera, lines.edge, lines.endpoints_C, lines.rho, lines.theta, lines.cov))
    )
    refined = refine_pose_lines(perturb(pose(0.6), 0.3 * START), right, CAMERAS)
    assert np.allclose(refined.T_world_target, pose(0.6), atol=1e-8)


def test_a_target_behind_the_cameras_is_refused() -> None:
    behind = pose()
    behind[0, 3] *= -1.0
    with pytest.raises(PoseError, match="not in front"):
        refine_pose_lines(behind, exact_lines(pose(), COV), CAMERAS)


def test_residuals_and_derivatives() -> None:
    lines = exact_lines(pose(), COV)
    T = perturb(pose(), START)
    distances, derivatives = line_residuals(T, lines, CAMERAS)
    assert np.allclose(distances, opencv_distances(T, lines), atol=1e-9)
    assert np.allclose(derivatives, numeric_jacobian(T, lines), atol=1e-4)


@pytest.mark.parametrize("range_m", [0.35, 0.9, 1.5])
@pytest.mark.parametrize("edges", [tuple(range(8)), (0, 4, 6)])
def test_exact_lines_give_back_the_pose_from_a_coarse_start(range_m: float, edges: tuple[int, ...]) -> None:
    T = pose(range_m)
    refined = refine_pose_lines(perturb(T, START), exact_lines(T, COV, edges), CAMERAS)
    assert refined.converged
    assert np.allclose(refined.T_world_target, T, atol=1e-9)
    assert refined.residuals.shape == (2 * len(edges), 2)
    assert np.allclose(refined.residuals, 0.0, atol=1e-7)


def test_a_wrong_line_is_rejected_as_a_whole() -> None:
    lines = exact_lines(pose(), COV)
    d_rho = np.zeros(16)
    d_rho[5] = 15.0
    refined = refine_pose_lines(perturb(pose(), START), with_errors(lines, d_rho, np.zeros(16)), CAMERAS)
    assert refined.weights.shape == (16,)
    assert refined.weights[5] == 0.0
    assert np.allclose(refined.T_world_target, pose(), atol=1e-6)
    assert np.allclose(np.abs(refined.residuals[5]), 15.0, atol=0.01)


def test_covariance_is_honest_for_lines_with_the_stated_covariance() -> None:
    rng = np.random.default_rng(21)
    cov = np.array([[0.4**2, 0.3 * 0.4 * 0.004], [0.3 * 0.4 * 0.004, 0.004**2]])
    lines = exact_lines(pose(), cov)
    nees = []
    for _ in range(200):
        d_rho, d_theta = rng.multivariate_normal(np.zeros(2), cov, size=16).T
        refined = refine_pose_lines(pose(), with_errors(lines, d_rho, d_theta), CAMERAS)
        error = difference(refined.T_world_target, pose())
        nees.append(error @ np.linalg.solve(refined.covariance, error) / 6)
    assert 0.6 < np.mean(nees) < 1.6


def test_covariance_grows_with_lines_worse_than_they_claim() -> None:
    rng = np.random.default_rng(22)
    lines = exact_lines(pose(), COV)
    d_rho, d_theta = rng.multivariate_normal(np.zeros(2), COV, size=16).T
    good, bad = (
        refine_pose_lines(pose(), with_errors(lines, f * d_rho, f * d_theta), CAMERAS).covariance for f in (1.0, 5.0)
    )
    assert np.trace(bad[:3, :3]) > 10.0 * np.trace(good[:3, :3])


def test_an_edge_seen_end_on_does_not_fail() -> None:
    lines = exact_lines(pose(), COV)
    ends = lines.endpoints_C.copy()
    ends[3, 1] = ends[3, 0]
    lines = LineMeasurements(lines.camera, lines.edge, ends, lines.rho, lines.theta, lines.cov)
    assert np.allclose(refine_pose_lines(perturb(pose(), START), lines, CAMERAS).T_world_target, pose(), atol=1e-9)


@pytest.mark.parametrize(("edges", "fault"), [((0,), "2 lines"), ((0, 1, 2, 3), "do not determine")])
def test_parallel_lines_do_not_determine_a_pose(edges: tuple[int, ...], fault: str) -> None:
    with pytest.raises(PoseError, match=fault):
        refine_pose_lines(pose(), exact_lines(pose(), COV, edges), CAMERAS)


def test_malformed_lines_are_refused() -> None:
    lines = exact_lines(pose(), COV)
    with pytest.raises(ValueError, match="differ in length"):
        LineMeasurements(lines.camera, lines.edge, lines.endpoints_C, lines.rho[:-1], lines.theta, lines.cov)
    with pytest.raises(ValueError, match="finite"):
        LineMeasurements(lines.camera, lines.edge, lines.endpoints_C, np.nan * lines.rho, lines.theta, lines.cov)
    with pytest.raises(ValueError, match="shape"):
        RectifiedCameras(670.0, np.zeros(3), np.eye(3))
