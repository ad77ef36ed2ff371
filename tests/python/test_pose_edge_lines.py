"""Lines through edge samples: exact lines, the weighted fit of numpy, outliers, covariance."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from pose_scene import Array, Samples, exact_lines, exact_samples, pose
from rvdnav.pose import EdgeLines, fit_edge_lines

COV = np.zeros((2, 2))


def fit(samples: Samples) -> EdgeLines:
    return fit_edge_lines(samples.camera, samples.edge, samples.q, samples.n, samples.sigma)


def one_edge(seed: int, count: int = 50, angle: float = 0.4, sigma: float = 0.1) -> Samples:
    """Samples on one exact line, x cos(angle) + y sin(angle) = 30, from 5 to 65 along it."""
    rng = np.random.default_rng(seed)
    n, d = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    along = np.sort(rng.uniform(5.0, 65.0, size=count))
    none = np.zeros(count, np.int64)
    return Samples(none, none + 3, 30.0 * n + along[:, None] * d, np.tile(n, (count, 1)), np.full(count, sigma))


def in_range(rho: Array, theta: Array) -> tuple[Array, Array]:
    """The same lines with theta in [-45°, 135°)."""
    turns = np.floor((theta + np.pi / 4) / np.pi)
    return rho * (-1.0) ** turns, theta - turns * np.pi


def test_exact_samples_give_the_true_lines() -> None:
    lines = fit(exact_samples(pose()))
    truth = exact_lines(pose(), COV)
    assert np.array_equal(lines.camera, truth.camera)
    assert np.array_equal(lines.edge, truth.edge)
    rho, theta = in_range(lines.rho, lines.theta)
    assert np.allclose(rho, truth.rho, atol=1e-9)
    assert np.allclose(theta, truth.theta, atol=1e-11)
    assert np.allclose(lines.weights, 1.0)
    assert np.allclose(lines.rms, 0.0, atol=1e-9)


def test_the_order_of_the_samples_does_not_matter() -> None:
    rng = np.random.default_rng(1)
    samples = exact_samples(pose()).moved(rng.normal(scale=0.1, size=960))
    order = rng.permutation(960)
    shuffled = Samples(*(values[order] for values in attrs.astuple(samples, recurse=False)))
    a, b = fit(samples), fit(shuffled)
    assert np.array_equal(a.edge, b.edge)
    # The first sample of an edge tells the normal; here all samples of an edge have the same one.
    assert np.allclose(a.rho, b.rho, atol=1e-9)
    assert np.allclose(a.cov, b.cov, rtol=1e-6)
    assert np.allclose(a.weights[order], b.weights)


def test_it_is_the_weighted_fit_of_numpy_under_its_own_weights() -> None:
    rng = np.random.default_rng(2)
    samples = one_edge(3)
    sigma = rng.uniform(0.02, 0.6, size=50)
    samples = attrs.evolve(samples.moved(sigma * rng.normal(size=50)), sigma=sigma)
    lines = fit(samples)
    n, d = samples.n[0], np.array([-samples.n[0, 1], samples.n[0, 0]])
    across, along = samples.q @ n, samples.q @ d
    slope = np.tan(np.arctan2(n[1], n[0]) - lines.theta[0])
    middle = along.mean()
    offset = (lines.rho[0] / np.cos(lines.theta[0] - np.arctan2(n[1], n[0]))) + slope * middle
    residual = across - offset - slope * (along - middle)
    scale = 1.4826 * np.median(np.abs(residual))
    w = np.maximum(1.0 - (residual / (4.685 * scale)) ** 2, 0.0) ** 2 / (sigma**2 + scale**2)
    expected = np.polynomial.Polynomial.fit(along - middle, across, 1, w=np.sqrt(w), domain=[-1, 1], window=[-1, 1])
    assert np.allclose([offset, slope], expected.coef, atol=2e-4)
    assert np.allclose(lines.weights, w * (sigma**2 + scale**2), atol=0.02)
    assert lines.rms[0] == pytest.approx(np.sqrt(np.average(residual**2, weights=lines.weights)), rel=0.02)


def test_outliers_are_told_and_do_not_count() -> None:
    rng = np.random.default_rng(4)
    clean = one_edge(5, count=80).moved(rng.normal(scale=0.05, size=80))
    wrong = np.zeros(80, np.bool_)
    wrong[20:44] = True  # another edge lies beside nearly a third of this one
    lines = fit(clean.moved(np.where(wrong, 1.5, 0.0)))
    assert np.all(lines.weights[wrong] == 0.0)
    assert lines.weights[~wrong].mean() > 0.75
    assert lines.rho[0] == pytest.approx(30.0, abs=0.06)
    assert lines.theta[0] == pytest.approx(0.4, abs=0.001)
    assert lines.rms[0] < 0.08


@pytest.mark.parametrize("noise", [0.05, 0.2])
def test_covariance_is_honest_for_samples_that_share_what_neighbours_share(noise: float) -> None:
    rng = np.random.default_rng(6)
    exact = one_edge(7, sigma=noise)
    squares = []
    for _ in range(300):
        white = rng.normal(scale=noise, size=51)
        lines = fit(exact.moved((white[1:] + white[:-1]) / np.sqrt(2.0)))
        error = np.array([lines.rho[0] - 30.0, lines.theta[0] - 0.4])
        squares.append(error @ np.linalg.solve(lines.cov[0], error) / 2)
    assert 0.6 < np.mean(squares) < 1.6


@pytest.mark.parametrize("correlation", [0.6, 0.8])
def test_covariance_is_honest_for_samples_before_an_uneven_background(correlation: float) -> None:
    """Residuals that fall off by the same factor from each to the next, as texture as coarse as a few profiles has."""
    rng = np.random.default_rng(12)
    exact = attrs.evolve(one_edge(7), q=one_edge(7).q[0] + np.arange(50)[:, None] * [-np.sin(0.4), np.cos(0.4)])
    squares = []
    for _ in range(300):
        noise = np.zeros(50)
        noise[0] = rng.normal(scale=0.2)
        for i in range(1, 50):
            noise[i] = correlation * noise[i - 1] + np.sqrt(1.0 - correlation**2) * rng.normal(scale=0.2)
        lines = fit(exact.moved(noise))
        error = np.array([lines.rho[0] - exact.q[0] @ exact.n[0], lines.theta[0] - 0.4])
        squares.append(error @ np.linalg.solve(lines.cov[0], error))
    # Of a chi-square of two degrees of freedom; taken for independent, samples as these give 3 and 6 times as much.
    assert 0.7 < np.median(squares) / (2.0 * np.log(2.0)) < 2.4


def test_covariance_follows_the_scatter_and_not_the_stated_sigma() -> None:
    noise = np.random.default_rng(8).normal(size=50)
    one, two = (fit(one_edge(9, sigma=s).moved(f * noise)).cov[0] for s, f in ((0.1, 0.1), (0.2, 0.2)))
    assert np.allclose(two, 4.0 * one, rtol=0.02)
    stated = fit(one_edge(9, sigma=0.3).moved(0.1 * noise)).cov[0]
    assert np.allclose(stated, one, rtol=0.3)


def test_edges_with_too_few_agreeing_samples_are_left_out() -> None:
    samples = exact_samples(pose())
    few = np.flatnonzero((samples.camera == 0) & (samples.edge == 2))[4:]
    kept = np.setdiff1d(np.arange(960), few)
    lines = fit(Samples(*(values[kept] for values in attrs.astuple(samples, recurse=False))))
    keys = list(zip(lines.camera.tolist(), lines.edge.tolist(), strict=True))
    assert (0, 2) not in keys
    assert len(keys) == 15
    left_out = (samples.camera[kept] == 0) & (samples.edge[kept] == 2)
    assert np.all(lines.weights[left_out] == 0.0)
    assert np.allclose(lines.weights[~left_out], 1.0)


def test_samples_in_one_place_make_no_line() -> None:
    samples = one_edge(10)
    lines = fit(attrs.evolve(samples, q=np.tile(samples.q[0], (50, 1))))
    assert len(lines.rho) == 0
    assert np.all(lines.weights == 0.0)


def test_no_samples_make_no_lines() -> None:
    none = np.zeros(0, np.int64)
    lines = fit_edge_lines(none, none, np.zeros((0, 2)), np.zeros((0, 2)), np.zeros(0))
    assert len(lines.camera) == len(lines.rho) == len(lines.cov) == len(lines.weights) == 0
