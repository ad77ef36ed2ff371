"""Refinement over fitted lines: derivatives, exact lines, robustness, covariance."""

from __future__ import annotations

import numpy as np
import pytest
from pose_scene import CAMERAS, Array, exact_lines, pose, project
from rvdnav.pose import LineMeasurements, PoseError, difference, line_residuals, perturb, refine_pose_lines

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


def test_residuals_and_derivatives() -> None:
    lines = exact_lines(pose(), COV)
    T = perturb(pose(), START)
    distances, derivatives = line_residuals(T, lines, CAMERAS)
    assert np.allclose(distances, opencv_distances(T, lines), atol=1e-9)
    h = 1e-6
    numeric = [
        (opencv_distances(perturb(T, d), lines) - opencv_distances(perturb(T, -d), lines)) / (2 * h)
        for d in np.eye(6) * h
    ]
    assert np.allclose(derivatives, np.stack(numeric, axis=2), atol=1e-4)


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
    assert refined.edge_rms[0, 5] == pytest.approx(15.0, abs=0.01)


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
