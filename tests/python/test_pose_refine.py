"""Refinement over edge samples: derivatives, minimum, robustness and refusals."""

from __future__ import annotations

import numpy as np
import pytest
from pose_scene import CAMERAS, EDGES, Array, exact_samples, pose, project, shifted
from rvdnav.pose import EdgeSamples, PoseError, RectifiedCameras, difference, edge_residuals, perturb, refine_pose
from scipy.optimize import least_squares

START = np.array([0.01, -0.008, 0.006, 0.02, -0.03, 0.02])


def noisy(T: Array, seed: int, white: float = 0.1, shared: float = 0.05) -> EdgeSamples:
    rng = np.random.default_rng(seed)
    samples = exact_samples(T)
    offsets = rng.normal(scale=shared, size=(2, 8))[samples.camera, samples.edge]
    return shifted(samples, offsets + rng.normal(scale=white, size=len(samples)))


def opencv_residuals(T: Array, samples: EdgeSamples) -> Array:
    residuals = np.empty(len(samples))
    for i in (0, 1):
        seen = samples.camera == i
        misses = samples.q[seen] - project(i, T, samples.p_C[seen])
        residuals[seen] = np.sum(samples.n[seen] * misses, axis=1)
    return residuals


def without(samples: EdgeSamples, kept: Array) -> EdgeSamples:
    fields = (samples.camera, samples.edge, samples.p_C, samples.q, samples.n, samples.sigma)
    return EdgeSamples(*(values[kept] for values in fields))


def numeric_jacobian(T: Array, samples: EdgeSamples) -> Array:
    h = 1e-6
    steps = np.eye(6) * h
    columns = [
        (opencv_residuals(perturb(T, d), samples) - opencv_residuals(perturb(T, -d), samples)) / (2 * h) for d in steps
    ]
    return np.column_stack(columns)


def test_projection_is_that_of_opencv() -> None:
    T = pose()
    points = EDGES.reshape(-1, 3)
    for i in (0, 1):
        found = CAMERAS.project(np.full(len(points), i), points @ T[:3, :3].T + T[:3, 3])
        assert np.allclose(found, project(i, T, points), atol=1e-9)


def test_residuals_and_derivatives_are_those_of_opencv_and_of_differences() -> None:
    samples = noisy(pose(), seed=1)
    T = perturb(pose(), START)
    residuals, derivatives = edge_residuals(T, samples, CAMERAS)
    assert np.allclose(residuals, opencv_residuals(T, samples), atol=1e-9)
    assert np.allclose(derivatives, numeric_jacobian(T, samples), atol=1e-4)


@pytest.mark.parametrize("range_m", [0.35, 0.9, 1.5])
def test_exact_samples_give_back_the_pose(range_m: float) -> None:
    T = pose(range_m)
    refined = refine_pose(perturb(T, START), exact_samples(T), CAMERAS)
    assert refined.converged
    assert np.allclose(refined.T_world_target, T, atol=1e-9)
    assert np.allclose(refined.residuals, 0.0, atol=1e-7)
    assert np.allclose(refined.weights, 1.0)
    assert refined.sigma0 == pytest.approx(0.0, abs=1e-6)
    assert np.linalg.eigvalsh(refined.covariance)[0] > 0.0


def test_one_camera_suffices() -> None:
    T = pose(0.6)
    refined = refine_pose(perturb(T, START), exact_samples(T, cameras=(1,)), CAMERAS)
    assert np.allclose(refined.T_world_target, T, atol=1e-8)


def test_without_robustness_it_is_the_least_squares_solution() -> None:
    samples = noisy(pose(), seed=2)
    samples = EdgeSamples(
        samples.camera, samples.edge, samples.p_C, samples.q, samples.n, np.linspace(0.05, 0.3, len(samples))
    )
    expected = least_squares(
        lambda d: opencv_residuals(perturb(pose(), d), samples) / samples.sigma, np.zeros(6), x_scale="jac", xtol=1e-12
    )
    refined = refine_pose(perturb(pose(), START), samples, CAMERAS, loss="huber", k=1e6)
    assert np.allclose(difference(refined.T_world_target, pose()), expected.x, atol=1e-8)
    assert refined.sigma0 == pytest.approx(np.sqrt(2 * expected.cost / (len(samples) - 6)), rel=1e-6)
    J = numeric_jacobian(refined.T_world_target, samples) / samples.sigma[:, None]
    assert np.allclose(refined.information, J.T @ J, rtol=1e-6)


@pytest.mark.parametrize("loss", ["tukey", "huber"])
def test_the_minimum_is_stationary_under_its_weights(loss: str) -> None:
    samples = noisy(pose(), seed=3)
    refined = refine_pose(perturb(pose(), START), samples, CAMERAS, loss=loss)  # type: ignore[arg-type]
    assert refined.converged
    assert refined.iterations <= 8
    assert refined.weights.min() < 1.0
    J = numeric_jacobian(refined.T_world_target, samples) / 0.1
    score = J.T @ (refined.weights * opencv_residuals(refined.T_world_target, samples) / 0.1)
    # In standard deviations of the pose.
    assert np.sqrt(score @ np.linalg.solve(refined.information, score)) < 1e-3


def test_two_starts_end_in_one_minimum() -> None:
    samples = noisy(pose(), seed=4)
    ends = [refine_pose(perturb(pose(), s * START), samples, CAMERAS).T_world_target for s in (-1.0, 0.5)]
    assert np.allclose(difference(ends[0], ends[1]), 0.0, atol=1e-5)


def test_gross_errors_are_rejected() -> None:
    clean = noisy(pose(), seed=5)
    rng = np.random.default_rng(6)
    wrong = rng.random(len(clean)) < 0.25
    samples = shifted(clean, np.where(wrong, rng.uniform(2.0, 10.0, size=len(clean)), 0.0))
    refined = refine_pose(perturb(pose(), START), samples, CAMERAS)
    reference = refine_pose(pose(), without(clean, ~wrong), CAMERAS)
    assert np.all(refined.weights[wrong] == 0.0)
    assert refined.weights[~wrong].mean() > 0.8
    error = difference(refined.T_world_target, reference.T_world_target)
    assert np.linalg.norm(error[:3]) < 1e-4
    assert np.linalg.norm(error[3:]) < 2e-3


def test_an_edge_that_was_mistaken_is_rejected_and_shows_in_its_rms() -> None:
    clean = noisy(pose(), seed=7)
    mistaken = (clean.camera == 1) & (clean.edge == 2)
    refined = refine_pose(perturb(pose(), START), shifted(clean, 4.0 * mistaken), CAMERAS)
    assert np.all(refined.weights[mistaken] == 0.0)
    assert set(refined.edge_rms) == {(i, e) for i in (0, 1) for e in range(8)}
    assert refined.edge_rms[1, 2] == pytest.approx(4.0, abs=0.5)
    assert max(rms for key, rms in refined.edge_rms.items() if key != (1, 2)) < 0.3
    expected = np.sqrt(np.mean(refined.residuals[(clean.camera == 0) & (clean.edge == 3)] ** 2))
    assert refined.edge_rms[0, 3] == pytest.approx(expected)


def test_the_same_input_gives_the_same_bits() -> None:
    samples = noisy(pose(), seed=8)
    one, two = (refine_pose(perturb(pose(), START), samples, CAMERAS) for _ in range(2))
    assert np.array_equal(one.T_world_target, two.T_world_target)
    assert np.array_equal(one.covariance, two.covariance)


@pytest.mark.parametrize("edges", [(0,), (0, 1, 2, 3)])
def test_parallel_edges_do_not_determine_a_pose(edges: tuple[int, ...]) -> None:
    # l1 and l2, outer and inner, are all parallel: the target may slide along them.
    samples = exact_samples(pose())
    with pytest.raises(PoseError, match="do not determine"):
        refine_pose(pose(), without(samples, np.isin(samples.edge, edges)), CAMERAS)


def test_too_few_samples_do_not_determine_a_pose() -> None:
    samples = exact_samples(pose())
    with pytest.raises(PoseError, match="5 edge samples"):
        refine_pose(pose(), without(samples, np.arange(len(samples)) < 5), CAMERAS)


def test_a_target_behind_the_cameras_is_refused() -> None:
    behind = pose()
    behind[0, 3] *= -1.0
    with pytest.raises(PoseError, match="not in front"):
        refine_pose(behind, exact_samples(pose()), CAMERAS)


def test_malformed_samples_are_refused() -> None:
    s = exact_samples(pose())
    with pytest.raises(ValueError, match="differ in length"):
        EdgeSamples(s.camera[:-1], s.edge, s.p_C, s.q, s.n, s.sigma)
    with pytest.raises(ValueError, match="positive"):
        EdgeSamples(s.camera, s.edge, s.p_C, s.q, s.n, 0.0 * s.sigma)
    with pytest.raises(ValueError, match="finite"):
        EdgeSamples(s.camera, s.edge, s.p_C, np.nan * s.q, s.n, s.sigma)
    with pytest.raises(ValueError, match="shape"):
        RectifiedCameras(670.0, np.zeros(3), np.eye(3))
