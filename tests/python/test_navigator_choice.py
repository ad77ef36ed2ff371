"""Which of several attempts at the same images is believed: poses moved by hand from a measurement of a drawn box."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from drawn_scene import example_rig
from drawn_solid import box_target, draw_solid, surfaces
from rvdnav.core import Core
from rvdnav.navigator.attempt import Attempt
from rvdnav.navigator.choice import best_attempt
from rvdnav.navigator.edge_model import edge_model
from rvdnav.navigator.gates import most_shown
from rvdnav.navigator.knowledge import Knowledge, Learned
from rvdnav.navigator.measurement import Measurement, measure
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.pose import difference, perturb
from rvdnav.solution import Reason
from scipy.spatial.transform import Rotation

RIG, TARGET = example_rig(), box_target()
SETTINGS = NavigatorSettings()
TRUE = np.eye(4)
TRUE[:3, :3] = Rotation.from_euler("yz", (20.0, 30.0), degrees=True).as_matrix()
TRUE[:3, 3] = 0.75, 0.0, 0.05
DRAWN = draw_solid(RIG, surfaces(TARGET), TRUE, timestamp_ns=0, seed=0)
IMAGES = (DRAWN.left.pixels, DRAWN.right.pixels)
FRAME = Core(RIG).process(*IMAGES)


@pytest.fixture(scope="module")
def good() -> Measurement:
    model = edge_model(TARGET)
    knowledge = Knowledge(RIG, model)
    nothing = np.zeros((2, len(model)), np.int64)
    return measure(Core(RIG), RIG, model, knowledge, Learned.nothing(knowledge.lasting), IMAGES, TRUE, nothing)


def at(measurement: Measurement, offset: np.ndarray) -> Measurement:
    """As if measured off the pose by (6,) m and rad."""
    T = perturb(measurement.pose.T_world_target, offset)
    return attrs.evolve(measurement, pose=attrs.evolve(measurement.pose, T_world_target=T))


def showing(measurement: Measurement, edges: np.ndarray) -> Measurement:
    """As if the other edges had been found in no view."""
    shown = np.isin(np.arange(measurement.agreed.shape[1]), edges)
    return attrs.evolve(measurement, agreed=np.where(shown, measurement.agreed, 0))


def attempt(measurement: Measurement, *reasons: Reason) -> Attempt:
    return Attempt(frozenset(reasons), FRAME, IMAGES, measurement)


def offset(y_mm: float) -> np.ndarray:
    return np.array([0.0, 1e-3 * y_mm, 0.0, 0.0, 0.0, 0.0])


def visible(measurement: Measurement) -> np.ndarray:
    return np.flatnonzero(measurement.attempted.sum(axis=0) > 0)


@pytest.mark.parametrize("places_mm", [(0.0, 4.0), (0.0, 4.0, -2.0), (1.0, 5.0, 5.0)])
def test_poses_shown_as_well_are_published_as_a_mixture(good: Measurement, places_mm: tuple[float, ...]) -> None:
    """Mean and scatter of equally likely poses, with the covariance that each has by itself."""
    chosen = best_attempt([attempt(at(good, offset(y))) for y in places_mm], SETTINGS)
    assert chosen.passed
    assert chosen.measurement is not None
    pose = chosen.measurement.pose
    off = difference(pose.T_world_target, good.pose.T_world_target)
    np.testing.assert_allclose(off, offset(np.mean(places_mm)), atol=1e-9)
    scatter = pose.covariance - good.pose.covariance
    assert scatter[1, 1] == pytest.approx(1e-6 * np.var(places_mm), rel=1e-6)
    assert np.abs(scatter).sum() == pytest.approx(scatter[1, 1], rel=1e-6)


def test_poses_too_far_apart_leave_the_frame_ambiguous(good: Measurement) -> None:
    chosen = best_attempt([attempt(good), attempt(at(good, offset(20.0)))], SETTINGS)
    assert chosen.reasons == {Reason.AMBIGUOUS}


def test_poses_within_their_covariance_are_one(good: Measurement) -> None:
    one_sigma = np.linalg.cholesky(good.pose.covariance)[:, 0]
    chosen = best_attempt([attempt(good), attempt(at(good, 3.0 * one_sigma))], SETTINGS)
    assert chosen.passed
    assert chosen.measurement is not None
    np.testing.assert_allclose(chosen.measurement.pose.T_world_target, good.pose.T_world_target, atol=1e-15)
    np.testing.assert_allclose(chosen.measurement.pose.covariance, good.pose.covariance)


def test_what_poses_close_to_each_other_show_together_is_published(good: Measurement) -> None:
    """As of a box whose lid bulges: each pose fits the edges of one side, and all are shown by the two together."""
    edges = visible(good)
    two_thirds = 2 * len(edges) // 3
    first = attempt(at(good, offset(-1.5)), Reason.TOO_FEW_LINES)
    first = attrs.evolve(first, measurement=showing(first.measurement, edges[:two_thirds]))
    other = attempt(at(good, offset(1.5)), Reason.TOO_FEW_LINES)
    other = attrs.evolve(other, measurement=showing(other.measurement, edges[-two_thirds:]))
    chosen = best_attempt([first, other], SETTINGS)
    assert chosen.passed
    assert chosen.measurement is not None
    off = difference(chosen.measurement.pose.T_world_target, good.pose.T_world_target)
    np.testing.assert_allclose(off, 0.0, atol=1e-9)
    assert chosen.measurement.pose.covariance[1, 1] > 1e-6 * 1.5**2


@pytest.mark.parametrize(
    ("apart_mm", "last_edges", "reason"),
    [
        (3.0, slice(0, 6), Reason.TOO_FEW_LINES),  # the same few edges once more
        (20.0, slice(-6, None), Reason.TOO_FEW_LINES),  # another place
        (3.0, slice(-6, None), Reason.CROSS_VIEW),  # refuted by more than what it doesn't show
    ],
)
def test_partial_poses_that_stay_refused(good: Measurement, apart_mm: float, last_edges: slice, reason: Reason) -> None:
    edges = visible(good)
    first = attempt(showing(good, edges[:6]), Reason.TOO_FEW_LINES)
    other = attempt(showing(at(good, offset(apart_mm)), edges[last_edges]), reason)
    assert best_attempt([first, other], SETTINGS) is first


@pytest.mark.parametrize(
    ("left_hidden", "right_hidden", "enough"),
    [
        (0, 0, True),
        (3, 0, True),  # the other view vouches for what one doesn't show of a rigid target
        (5, 0, False),  # less than half of its own
        (3, 2, True),
        (3, 3, False),
    ],
)
def test_most_of_the_edges_must_be_shown(left_hidden: int, right_hidden: int, enough: bool) -> None:
    coverage = np.ones((2, 9))
    coverage[0, :left_hidden] = 0.0
    coverage[1, :right_hidden] = 0.0
    attempted = np.full((2, 9), 20)
    assert most_shown(coverage, attempted, SETTINGS) is enough


def test_an_edge_hardly_on_the_image_is_not_asked_for() -> None:
    coverage, attempted = np.ones((2, 9)), np.full((2, 9), 20)
    coverage[:, :6] = 0.0
    attempted[:, :6] = 4
    assert most_shown(coverage, attempted, SETTINGS)


def test_three_edges_in_one_view_contradict_nothing() -> None:
    assert not most_shown(np.ones((1, 3)), np.full((1, 3), 20), SETTINGS)
