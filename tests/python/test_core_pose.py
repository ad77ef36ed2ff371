"""The core's pose estimation beside the one that can be read, `rvdnav.pose`: the same results from any geometry.

Both minimise the same function by the same steps, but the core eliminates the parameters in the space of the residuals,
where their number does not matter, and adds in another order.  So results agree but for rounding, which an inverse of
condition 1e8 (the largest that is accepted) takes from 1e-16 to 1e-8; most agree to 1e-12.
"""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pose_scene import CAMERAS, Array, exact_lines, exact_samples, pose
from readable_navigator.measurement import measure
from rvdnav import Navigator, open_sequence
from rvdnav import pose as readable
from rvdnav.core import pose as native
from rvdnav.errors import CoreError
from rvdnav.navigator import coarse, one_view, surveyor
from rvdnav.pose import LineMeasurements, PoseError, RefinedPose, difference, make_T, perturb
from rvdnav.pose.systematics import Group, Systematics
from rvdnav.solution import Solution

SEEDS = range(40)
APPROACH = Path(__file__).resolve().parents[2] / "examples" / "approach"


def random_systematics(rng: np.random.Generator, lines: int, learned: bool) -> Systematics:
    """Of five groups, one of which keeps its scale; dense and sparse derivatives, in px a standard deviation."""
    sizes = (12, 22, 2, 8, 6)
    derivative = 0.1 * rng.standard_normal((lines, 2, sum(sizes)))
    derivative[:, :, 34:44] *= rng.random((lines, 1, 10)) < 0.2
    doubtful = (bool(rng.random() < 0.5), False, False, False, False)
    groups = tuple(map(Group, sizes, (1.0, 4.0, 1.0, 1.0, np.inf), (5.0, 5.0, 20.0, 25.0, 1.0), doubtful))
    root = rng.standard_normal((34, 34)) if learned else np.zeros((34, 34))
    information, vector = np.zeros((50, 50)), np.zeros(50)
    information[:34, :34] = root @ root.T
    vector[:34] = information[:34, :34] @ (0.5 * rng.standard_normal(34))
    scales = rng.uniform(0.3, 2.0, 5) if learned else np.ones(5)
    return Systematics(derivative, groups, scales, information, vector)


@attrs.frozen
class Case:
    """A pose to refine over lines, some of them outliers."""

    start: Array
    lines: LineMeasurements
    systematics: Systematics | None

    @classmethod
    def of(cls, seed: int) -> Case:
        """Mono and stereo, all and few edges, with and without systematics, from 0.3 to 3 m."""
        rng = np.random.default_rng(seed)
        T = perturb(pose(float(rng.uniform(0.3, 3.0))), 0.05 * rng.standard_normal(6))
        lines = exact_lines(T, np.diag(rng.uniform(1e-4, 1e-2, 2) * [1.0, 1e-4]))
        chosen = (lines.camera == seed % 2) | (seed % 3 > 0)
        chosen &= rng.random(16) < rng.choice([0.8, 1.0])
        noise = rng.choice([0.01, 0.1, 0.4]) * rng.standard_normal((2, 16))
        outlier = rng.random(16) < 0.1
        noise[:, outlier] += rng.uniform(2.0, 8.0, int(outlier.sum()))
        moved = LineMeasurements(
            lines.camera[chosen],
            lines.edge[chosen],
            lines.endpoints_C[chosen],
            (lines.rho + noise[0])[chosen],
            (lines.theta + 0.01 * noise[1])[chosen],
            lines.cov[chosen],
            np.where(rng.random(16) < 0.3, 0.2, 0.0)[chosen],
        )
        systematics = random_systematics(rng, len(moved), learned=seed % 4 > 1) if seed % 5 > 0 else None
        return cls(perturb(T, 0.003 * rng.standard_normal(6)), moved, systematics)


def assert_same(found: RefinedPose, expected: RefinedPose) -> None:
    """To parts of the standard deviations, of which even a thousandth would not matter."""
    sigma = np.sqrt(np.diagonal(expected.joint_covariance))
    error = difference(found.T_world_target, expected.T_world_target)
    assert np.abs(np.concatenate([error, found.z - expected.z]) / sigma).max() < 1e-7
    assert np.abs((found.joint_covariance - expected.joint_covariance) / np.outer(sigma, sigma)).max() < 1e-7
    np.testing.assert_array_equal(found.covariance, found.joint_covariance[:6, :6])
    np.testing.assert_allclose(found.residuals, expected.residuals, rtol=0.0, atol=1e-8)
    np.testing.assert_allclose(found.weights, expected.weights, rtol=0.0, atol=1e-8)
    for name in ("sigma0", "displacement_px", "scales"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), rtol=1e-7, err_msg=name)
    gain_scale = np.abs(expected.gain).max(axis=(1, 2), keepdims=True)
    np.testing.assert_allclose(found.gain / gain_scale, expected.gain / gain_scale, rtol=0.0, atol=1e-7)
    units = np.sqrt(np.maximum(np.diagonal(expected.told.information), 1e-300))
    told = (found.told.information - expected.told.information) / np.outer(units, units)
    assert np.abs(told).max() < 1e-7
    # At the minimum it is a difference of large numbers, each residual over its sigma.
    np.testing.assert_allclose(found.told.gradient / units, expected.told.gradient / units, rtol=0.0, atol=1e-6)
    assert (found.iterations, found.converged) == (expected.iterations, expected.converged)


@pytest.mark.parametrize("seed", SEEDS)
def test_edges_with_their_own_displacement(seed: int) -> None:
    case = Case.of(seed)
    arguments = case.start, case.lines, CAMERAS, case.systematics
    try:
        expected = readable.refine_pose_edges(*arguments)
    except PoseError as error:
        with pytest.raises(PoseError, match=str(error)):
            native.refine_pose_edges(*arguments)
    else:
        assert_same(native.refine_pose_edges(*arguments), expected)


@pytest.mark.parametrize("near", [False, True])
@pytest.mark.parametrize(("loss", "k"), [("tukey", None), ("huber", None), ("tukey", 3.0), ("huber", 1e3)])
def test_lines_with_a_stated_displacement(loss: str, k: float | None, near: bool) -> None:
    for seed in SEEDS:
        case = Case.of(seed)
        options = {"loss": loss, "k": k, "near": near, "endpoint_sigma": 0.05, "systematics": case.systematics}
        try:
            expected = readable.refine_pose_lines(case.start, case.lines, CAMERAS, **options)
        except PoseError as error:
            with pytest.raises(PoseError, match=str(error)):
                native.refine_pose_lines(case.start, case.lines, CAMERAS, **options)
        else:
            assert_same(native.refine_pose_lines(case.start, case.lines, CAMERAS, **options), expected)


def test_what_determines_no_pose_is_refused() -> None:
    lines = exact_lines(pose(), np.diag([0.01, 1e-6]))
    few = exact_lines(pose(), np.diag([0.01, 1e-6]), (0,))
    parallel = exact_lines(pose(), np.diag([0.01, 1e-6]), (0, 1, 2, 3))
    behind = make_T(pose()[:3, :3], np.array([-0.9, 0.0, 0.0]))
    apart = attrs.evolve(lines, rho=lines.rho + np.resize([50.0, -50.0], 16))
    for function in (native.refine_pose_edges, native.refine_pose_lines):
        for T, measured, fault in (
            (pose(), few, "do not determine"),
            (pose(), parallel, "do not determine"),
            (behind, lines, "not in front"),
        ):
            with pytest.raises(PoseError, match=fault):
                function(T, measured, CAMERAS)
    with pytest.raises(PoseError, match="no measurement agrees"):
        native.refine_pose_lines(pose(), apart, CAMERAS, k=0.5, near=True)


def test_more_than_there_is_room_for_is_refused() -> None:
    lines = exact_lines(pose(), np.diag([0.01, 1e-6]))
    many = LineMeasurements(*(np.repeat(a, 33, axis=0) for a in attrs.astuple(lines, recurse=False)))
    with pytest.raises(CoreError, match="too small"):
        native.refine_pose_lines(pose(), many, CAMERAS)
    samples = exact_samples(pose(), per_edge=5)
    with pytest.raises(CoreError, match="out of its range"):
        native.fit_edge_lines(samples.camera, samples.edge + 256, samples.q, samples.n, samples.sigma)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    per_edge=st.integers(1, 90),
    noise=st.sampled_from([1e-3, 0.1, 2.0]),
    outliers=st.floats(0.0, 0.6),
    kept=st.floats(0.05, 1.0),
)
def test_lines_through_samples(seed: int, per_edge: int, noise: float, outliers: float, kept: float) -> None:
    """Never without noise: how alike the neighbours' residuals are would then be how alike their rounding is."""
    rng = np.random.default_rng(seed)
    exact = exact_samples(pose(), per_edge)
    count = len(exact.camera)
    distance = noise * rng.standard_normal(count)
    distance += np.where(rng.random(count) < outliers, rng.uniform(-4.0, 4.0, count), 0.0)
    samples = attrs.evolve(exact.moved(distance), sigma=rng.uniform(0.02, 0.5, count))
    order = rng.permutation(count)[: int(kept * count)]
    arguments = [values[order] for values in attrs.astuple(samples, recurse=False)]
    found, expected = native.fit_edge_lines(*arguments), readable.fit_edge_lines(*arguments)
    np.testing.assert_array_equal(found.camera, expected.camera)
    np.testing.assert_array_equal(found.edge, expected.edge)
    # Eight reweighted rounds of a set that agrees on no line magnify rounding; of any other set they shrink it.
    for name, tolerance in {"rho": 1e-9, "theta": 1e-11, "rms": 1e-9, "weights": 1e-7}.items():
        np.testing.assert_allclose(
            getattr(found, name), getattr(expected, name), rtol=0.0, atol=tolerance, err_msg=name
        )
    np.testing.assert_allclose(found.cov, expected.cov, rtol=1e-7, atol=1e-15)


def test_no_samples_give_no_lines() -> None:
    none = np.zeros(0)
    lines = native.fit_edge_lines(none.astype(int), none.astype(int), none.reshape(0, 2), none.reshape(0, 2), none)
    assert len(lines.rho) == len(lines.weights) == 0


def test_the_navigator_gives_the_same_with_either(monkeypatch: pytest.MonkeyPatch) -> None:
    """To a small part of sigma: a pose that is moved by 1e-13 already measures other profiles, where one was on the
    brink of being left out, and ends up to 2 % of sigma elsewhere."""

    def run() -> list[Solution]:
        sequence = open_sequence(APPROACH)
        navigator = Navigator(sequence.rig, sequence.target)
        return [navigator.process(frame) for frame in sequence]

    found = run()
    for module in (coarse, one_view):
        monkeypatch.setattr(module, "refine_pose_lines", readable.refine_pose_lines)
    monkeypatch.setattr(surveyor, "measure", measure)
    expected = run()
    assert [(s.state, s.reasons) for s in found] == [(s.state, s.reasons) for s in expected]
    published = [(a, b) for a, b in zip(found, expected, strict=True) if a.published]
    assert len(published) > 20
    for a, b in published:
        sigma = np.sqrt(np.diagonal(b.covariance))
        assert np.abs(difference(a.T_world_target, b.T_world_target) / sigma).max() < 0.05
