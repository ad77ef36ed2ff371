"""Errors that lines share: estimated with the pose, held against exact geometry and brute force."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from drawn_scene import bracket_target, pose, wide_rig
from readable_navigator.systematics import frame_systematics, taught
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import line_of, project_edges, rectified_cameras
from rvdnav.navigator.knowledge import Knowledge, Learned
from rvdnav.pose import LineMeasurements, RefinedPose, difference, perturb, refine_pose_edges
from rvdnav.pose.systematics import Group, JointInformation, Systematics

RIG, BRACKET = wide_rig(), bracket_target().bracket
CAMERAS = rectified_cameras(RIG)
T = pose(0.6, 0.03, 0.05, 12.0, -9.0, 6.0)
NOISE_PX = 0.02
BLUR = np.full((2, 8), 0.7)


def model_with(sigma_m: float) -> EdgeModel:
    return EdgeModel.of_bracket(BRACKET, np.full(8, sigma_m))


def lines_of(points: np.ndarray, rng: np.random.Generator, model: EdgeModel, roll: float = 0.0) -> LineMeasurements:
    """Lines through the projections of a bracket's true points (8, 3), moved by noise; with the model's ends.  roll:
    by which the left view is turned about its principal point, rad."""
    turn = np.array([[np.cos(roll), -np.sin(roll)], [np.sin(roll), np.cos(roll)]])
    rho, theta = [], []
    for camera in (0, 1):
        xy, _ = project_edges(CAMERAS, camera, T, points[model.ends])
        xy = xy @ turn if camera == 0 else xy
        found = line_of(xy)
        rho.append(found[0] + NOISE_PX * rng.standard_normal(8))
        theta.append(found[1])
    return LineMeasurements(
        np.repeat([0, 1], 8),
        np.tile(np.arange(8), 2),
        np.tile(model.edge_points, (2, 1, 1)),
        np.concatenate(rho),
        np.concatenate(theta),
        np.tile(np.diag([NOISE_PX**2, 1e-8]), (16, 1, 1)),
    )


def refined(stated_m: float, true_m: float, seed: int) -> RefinedPose:
    """Of a bracket whose points err by true_m where stated_m is stated."""
    rng = np.random.default_rng(seed)
    model = model_with(stated_m)
    lines = lines_of(model.points + true_m * rng.standard_normal((8, 3)), rng, model)
    knowledge = Knowledge(RIG, model)
    systematics = frame_systematics(
        knowledge, model, T, lines, np.zeros(16, np.int64), BLUR, Learned.nothing(knowledge.lasting)
    )
    return refine_pose_edges(perturb(T, 1e-3 * rng.standard_normal(6)), lines, CAMERAS, systematics)


def systematics_of(lines: LineMeasurements, model: EdgeModel, knowledge: Knowledge, learned: Learned) -> Systematics:
    unknown = np.zeros(len(lines), np.int64)
    return frame_systematics(knowledge, model, T, lines, unknown, BLUR, learned)


def nees(found: RefinedPose) -> float:
    error = difference(found.T_world_target, T)
    return float(error @ np.linalg.solve(found.covariance, error)) / 6.0


@pytest.mark.parametrize(("stated_mm", "low", "high"), [(0.3, 0.5, 2.0), (0.1, 0.5, 3.5), (0.9, 0.2, 2.0)])
def test_the_covariance_holds_a_tolerance_whatever_was_stated(stated_mm: float, low: float, high: float) -> None:
    """Points off by 0.3 mm each; stated rightly, as a third of it and as three times of it."""
    ratios = [nees(refined(1e-3 * stated_mm, 3e-4, seed)) for seed in range(40)]
    assert low < np.mean(ratios) < high


def test_the_tolerance_is_believed_less_where_the_lines_contradict_it() -> None:
    scales = [refined(1e-4, 5e-4, seed).scales[0] for seed in range(10)]
    assert np.median(scales) > 2.0
    exact = [refined(3e-4, 0.0, seed).scales[0] for seed in range(10)]
    assert np.median(exact) < 0.5


def test_what_the_views_share_is_not_taken_for_what_displaces_each_line() -> None:
    """Points off by three times what was stated are seen alike in both views, whose noise is small."""
    found = [refined(3e-4, 1e-3, seed) for seed in range(20)]
    assert np.median([pose.scales[0] for pose in found]) > 2.5
    assert max(pose.displacement_px for pose in found) < 5.0 * NOISE_PX


def test_a_view_turned_by_ten_times_what_was_stated_is_told_from_lines_that_tilt() -> None:
    model = model_with(3e-4)
    knowledge = Knowledge(attrs.evolve(RIG, calibration_covariance=None), model)
    ratios = []
    for seed in range(10):
        lines = lines_of(model.points, np.random.default_rng(seed), model, roll=np.radians(0.3))
        systematics = frame_systematics(
            knowledge, model, T, lines, np.zeros(16, np.int64), BLUR, Learned.nothing(knowledge.lasting)
        )
        ratios.append(nees(refine_pose_edges(T, lines, CAMERAS, systematics)))
    assert max(ratios) < 2.0


def test_a_tolerance_that_is_zero_changes_nothing() -> None:
    rng = np.random.default_rng(5)
    model = model_with(0.0)
    lines = lines_of(model.points, rng, model)
    plain = refine_pose_edges(T, lines, CAMERAS)
    none = refine_pose_edges(T, lines, CAMERAS, Systematics.none(len(lines)))
    np.testing.assert_array_equal(plain.T_world_target, none.T_world_target)
    assert Knowledge(RIG, model).lasting == 0


def test_what_a_frame_tells_of_the_parameters_is_the_schur_complement() -> None:
    """Against the dense inverse: the information of some variables is the inverse of their block of the covariance."""
    rng = np.random.default_rng(6)
    A = rng.standard_normal((30, 6 + 5))
    z = rng.standard_normal(5)
    told = JointInformation(A.T @ A, np.zeros(11), z)
    wanted = np.array([True, True, True, False, False])
    prior = np.array([0.0, 0.0, 0.0, 2.0, 3.0])
    information, vector = told.of_parameters(wanted, prior)
    whole = A.T @ A + np.diag([0.0] * 6 + prior.tolist())
    expected = np.linalg.inv(np.linalg.inv(whole)[6:9, 6:9])
    np.testing.assert_allclose(information, expected, rtol=1e-8)
    # The minimum over everything, with the others' prior about zero.
    minimum = np.linalg.solve(whole, A.T @ A @ np.concatenate([np.zeros(6), z]))
    np.testing.assert_allclose(np.linalg.solve(information, vector), minimum[6:9], rtol=1e-8)


def test_scales_stay_within_their_bounds() -> None:
    systematics = Systematics.of(np.zeros((3, 2, 2)), Group(1, 1.0, 4.0), Group(1, np.inf))
    told = systematics.rescaled(np.array([1e6, 1e6]), np.diag([1e-6, 1e-6]))
    np.testing.assert_array_equal(told.scales, [4.0, 1.0])


def test_frames_that_repeat_themselves_teach_no_more_than_a_few() -> None:
    """The same lines again and again: what is learnt stays finite, and the calibration's unseen parts stay open."""
    rng = np.random.default_rng(7)
    model = model_with(3e-4)
    lines = lines_of(model.points, rng, model)
    knowledge = Knowledge(attrs.evolve(RIG, calibration_covariance=None), model)
    learned = Learned.nothing(knowledge.lasting)
    traces = []
    for _ in range(12):
        systematics = systematics_of(lines, model, knowledge, learned)
        learned = taught(knowledge, learned, refine_pose_edges(T, lines, CAMERAS, systematics), systematics)
        traces.append(float(np.trace(learned.information)))
    assert learned.frames == 12
    assert traces[-1] < 1.2 * traces[7]
