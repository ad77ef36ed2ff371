"""Refinement over edge lines with the displacement that they show: honesty of the covariance, robustness, refusals."""

from __future__ import annotations

from collections.abc import Iterator

import attrs
import numpy as np
import pytest
from pose_scene import CAMERAS, EDGES, Array, Samples, exact_lines, exact_samples, pose
from rvdnav.pose import LineMeasurements, PoseError, difference, fit_edge_lines, perturb, refine_pose_edges

PER_EDGE = 60
START = np.array([0.004, -0.003, 0.005, 0.01, -0.012, 0.008])


def measured(samples: Samples, shift_sigma: Array | None = None) -> LineMeasurements:
    """Lines through the samples; shift_sigma (2, 8) px by camera and edge."""
    fits = fit_edge_lines(samples.camera, samples.edge, samples.q, samples.n, samples.sigma)
    shift = np.zeros((2, 8)) if shift_sigma is None else shift_sigma
    return LineMeasurements(
        fits.camera, fits.edge, EDGES[fits.edge], fits.rho, fits.theta, fits.cov, shift[fits.camera, fits.edge]
    )


@attrs.frozen
class Errors:
    """Standard deviations, px, of the samples' noise, of what displaces whole edges and of what tilts them."""

    white: float = 0.1
    offset: float = 0.0
    tilt: float = 0.0

    def draw(self, rng: np.random.Generator, samples: Samples) -> Array:
        """Distances (k,) of the samples from the true edges; neighbours share half of their noise's variance."""
        noise = rng.normal(size=len(samples.camera) + 1)
        along = np.tile(np.linspace(-1.0, 1.0, PER_EDGE), len(samples.camera) // PER_EDGE)
        offsets, tilts = rng.normal(size=(2, 2, 8))[:, samples.camera, samples.edge]
        correlated: Array = self.white * (noise[1:] + noise[:-1]) / np.sqrt(2.0)
        return correlated + self.offset * offsets + self.tilt * tilts * along


def nees(
    errors: Errors, seed: int, runs: int = 80, range_m: float = 0.9, shift: float = 0.0, wrong: int = 0
) -> Iterator[float]:
    """e' C⁻¹ e / 6 of every run.  shift: standard deviation of a known displacement of six edges; wrong: edges off by
    2 to 6 px."""
    rng = np.random.default_rng(seed)
    T = pose(range_m)
    samples = exact_samples(T, per_edge=PER_EDGE)
    for _ in range(runs):
        shift_sigma, extra = np.zeros(16), np.zeros(16)
        chosen = rng.permutation(16)
        shift_sigma[chosen[:6]] = shift
        extra[:] = shift_sigma * rng.normal(size=16)
        extra[chosen[16 - wrong :]] += rng.choice([-1.0, 1.0], wrong) * rng.uniform(2.0, 6.0, wrong)
        distance = errors.draw(rng, samples) + extra.reshape(2, 8)[samples.camera, samples.edge]
        lines = measured(samples.moved(distance), shift_sigma.reshape(2, 8))
        refined = refine_pose_edges(perturb(T, 0.002 * rng.normal(size=6)), lines, CAMERAS)
        error = difference(refined.T_world_target, T)
        yield float(error @ np.linalg.solve(refined.covariance, error)) / 6.0


@pytest.mark.parametrize(
    "errors",
    [
        Errors(),
        Errors(white=0.3),
        Errors(offset=0.05),
        Errors(offset=0.1),
        Errors(white=0.05, offset=0.3),
        Errors(tilt=0.1),
        Errors(offset=0.05, tilt=0.1),
        Errors(offset=0.1, tilt=0.05),
    ],
    ids=str,
)
def test_covariance_is_honest_whatever_displaces_the_edges(errors: Errors) -> None:
    assert 0.6 < np.mean(list(nees(errors, seed=1))) < 1.6


@pytest.mark.parametrize("range_m", [0.4, 1.5])
def test_covariance_is_honest_near_and_far(range_m: float) -> None:
    assert 0.6 < np.mean(list(nees(Errors(offset=0.1), seed=2, range_m=range_m))) < 1.6


@pytest.mark.parametrize("shift", [0.3, 1.5])
def test_covariance_is_honest_where_some_edges_are_known_to_shift(shift: float) -> None:
    assert 0.6 < np.mean(list(nees(Errors(offset=0.03), seed=3, shift=shift))) < 1.6


def test_two_edges_wholly_wrong_are_rejected() -> None:
    assert 0.6 < np.mean(list(nees(Errors(offset=0.05), seed=4, wrong=2))) < 1.6
    rng = np.random.default_rng(5)
    samples = exact_samples(pose()).moved(rng.normal(scale=0.05, size=960))
    wrong = ((samples.camera == 0) & (samples.edge == 2)) | ((samples.camera == 1) & (samples.edge == 5))
    refined = refine_pose_edges(perturb(pose(), START), measured(samples.moved(np.where(wrong, 4.0, 0.0))), CAMERAS)
    assert refined.weights[2] == refined.weights[8 + 5] == 0.0
    assert np.delete(refined.weights, [2, 13]).min() > 0.3
    assert refined.residuals[2] == pytest.approx([4.0, 4.0], abs=0.4) or refined.residuals[2] == pytest.approx(
        [-4.0, -4.0], abs=0.4
    )


def test_covariance_grows_with_what_displaces_the_edges() -> None:
    """Hundreds of samples do not average away what displaces whole edges."""
    rng = np.random.default_rng(6)
    samples = exact_samples(pose(), per_edge=PER_EDGE)
    unit = Errors(white=0.0, offset=1.0).draw(rng, samples)
    noise = Errors(white=0.05).draw(rng, samples)
    sigmas = [
        np.sqrt(
            np.trace(refine_pose_edges(pose(), measured(samples.moved(noise + f * unit)), CAMERAS).covariance[:3, :3])
        )
        for f in (0.0, 0.1, 0.2)
    ]
    assert sigmas[1] > 3.0 * sigmas[0]
    assert sigmas[2] == pytest.approx(2.0 * sigmas[1], rel=0.2)


def test_edges_known_to_shift_count_less() -> None:
    """Half of the edges displaced by a pixel do no harm where that is known of them."""
    rng = np.random.default_rng(7)
    samples = exact_samples(pose()).moved(rng.normal(scale=0.05, size=960))
    shift_sigma = np.zeros((2, 8))
    shift_sigma[0, ::2] = shift_sigma[1, 1::2] = 1.0
    moved = samples.moved(shift_sigma[samples.camera, samples.edge])
    told = refine_pose_edges(pose(), measured(moved, shift_sigma), CAMERAS)
    clean = refine_pose_edges(pose(), measured(samples), CAMERAS)
    error = difference(told.T_world_target, pose())
    assert np.linalg.norm(error[:3]) < 3.0 * np.sqrt(np.trace(told.covariance[:3, :3]))
    assert np.linalg.norm(error[:3]) < 0.5e-3
    assert np.trace(told.covariance[:3, :3]) > np.trace(clean.covariance[:3, :3])


def test_exact_lines_give_back_the_pose_from_a_coarse_start() -> None:
    lines = exact_lines(pose(), np.diag([0.05**2, 0.001**2]))
    refined = refine_pose_edges(perturb(pose(), 3.0 * START), lines, CAMERAS)
    assert refined.converged
    assert np.allclose(refined.T_world_target, pose(), atol=1e-8)
    assert np.linalg.eigvalsh(refined.covariance)[0] > 0.0
    assert np.allclose(refined.covariance, refined.covariance.T, rtol=1e-9, atol=0.0)


def test_what_does_not_determine_a_pose_is_refused() -> None:
    samples = exact_samples(pose())
    parallel = np.flatnonzero(samples.edge < 4)
    lines = measured(Samples(*(values[parallel] for values in attrs.astuple(samples, recurse=False))))
    with pytest.raises(PoseError, match="do not determine"):
        refine_pose_edges(pose(), lines, CAMERAS)
    two = exact_lines(pose(), np.eye(2) * 1e-4, edges=(0,))
    with pytest.raises(PoseError, match="2 lines"):
        refine_pose_edges(pose(), two, CAMERAS)
    behind = pose()
    behind[0, 3] *= -1.0
    with pytest.raises(PoseError, match="not in front"):
        refine_pose_edges(behind, exact_lines(pose(), np.eye(2) * 1e-4), CAMERAS)
