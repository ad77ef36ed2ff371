"""Monte Carlo: a refined pose's covariance must match the errors that are really made."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pose_scene import CAMERAS, exact_samples, pose, shifted
from rvdnav.pose import difference, perturb, refine_pose

PER_EDGE = 40


def mean_nees(
    white: float, offset: float, tilt: float, runs: int, wrong: float = 0.0, **scene: Any
) -> tuple[float, float]:
    """Mean of eᵀ C⁻¹ e / 6 over the runs, with the covariance given and with sigma0² times the inverse information."""
    rng = np.random.default_rng(11)
    T = pose()
    samples = exact_samples(T, per_edge=PER_EDGE, **scene)
    along = np.tile(np.linspace(-1.0, 1.0, PER_EDGE), len(samples) // PER_EDGE)
    given, naive = [], []
    for _ in range(runs):
        offsets, tilts = rng.normal(size=(2, 2, 8))[:, samples.camera, samples.edge]
        distance = white * rng.normal(size=len(samples)) + offset * offsets + tilt * tilts * along
        distance += np.where(rng.random(len(samples)) < wrong, rng.uniform(1.0, 8.0, size=len(samples)), 0.0)
        refined = refine_pose(perturb(T, 0.003 * rng.normal(size=6)), shifted(samples, distance), CAMERAS)
        error = difference(refined.T_world_target, T)
        given.append(error @ np.linalg.solve(refined.covariance, error) / 6)
        naive.append(error @ refined.information @ error / refined.sigma0**2 / 6)
    return float(np.mean(given)), float(np.mean(naive))


@pytest.mark.parametrize(
    ("white", "offset", "tilt"), [(0.1, 0.0, 0.0), (0.3, 0.0, 0.0), (0.1, 0.1, 0.0), (0.1, 0.05, 0.1), (0.05, 0.3, 0.0)]
)
def test_covariance_is_honest(white: float, offset: float, tilt: float) -> None:
    given, naive = mean_nees(white, offset, tilt, runs=120)
    low, high = (0.6, 1.6) if offset + tilt > 0.0 else (0.75, 1.2)
    assert low < given < high
    # What the edges' common errors do to a covariance that counts every sample as independent.
    assert (naive > 5.0) == (offset + tilt > 0.0)


def test_covariance_is_honest_with_one_camera() -> None:
    given, _ = mean_nees(0.1, 0.1, 0.0, runs=120, cameras=(0,))
    assert 0.6 < given < 1.6


def test_covariance_is_honest_with_gross_errors_among_the_samples() -> None:
    given, _ = mean_nees(0.1, 0.1, 0.0, runs=120, wrong=0.15)
    assert 0.6 < given < 1.6


def test_stated_sigma_scales_nothing_but_the_weights() -> None:
    T = pose()
    covariances = []
    for sigma in (0.1, 0.2):
        rng = np.random.default_rng(12)
        samples = exact_samples(T, sigma=sigma)
        samples = shifted(samples, rng.normal(scale=0.15, size=len(samples)))
        covariances.append(refine_pose(T, samples, CAMERAS).covariance)
    assert np.allclose(covariances[0], covariances[1], rtol=1e-3, atol=1e-12)


@pytest.mark.parametrize("per_edge", [1, 2, 3, 20])
@pytest.mark.parametrize("noise", [0.0, 1e-6, 0.5])
def test_covariance_is_symmetric_and_positive_definite_with_any_number_of_samples(per_edge: int, noise: float) -> None:
    rng = np.random.default_rng(13)
    samples = exact_samples(pose(), per_edge=per_edge)
    covariance = refine_pose(pose(), shifted(samples, noise * rng.normal(size=len(samples))), CAMERAS).covariance
    assert np.array_equal(covariance, covariance.T)
    units = 1.0 / np.sqrt(np.diagonal(covariance))
    assert np.linalg.eigvalsh(covariance * np.outer(units, units))[0] > 1e-6
