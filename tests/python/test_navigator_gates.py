"""Every gate, provoked by itself on a measurement that is otherwise good."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from drawn_scene import bracket_target, draw_frame, example_rig, pose
from rvdnav.core import Core, FrameResult
from rvdnav.navigator.agreement import disparity_errors, view_difference
from rvdnav.navigator.coarse import coarse_pose
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.gates import failed_gates, plausible_motion
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.navigator.knowledge import Knowledge, Learned
from rvdnav.navigator.measurement import Measurement, measure
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.pose import LineMeasurements, PredictedPose, perturb
from rvdnav.solution import Reason

RIG, TARGET = example_rig(), bracket_target()
TRUE = pose(0.9, 0.01, 0.06, 2.0, 3.0, -2.0)
SETTINGS = NavigatorSettings()
NOTHING = np.zeros((6, 6))


MODEL = EdgeModel.of_bracket(TARGET.bracket)
UNKNOWN = np.zeros((2, 8), np.int64)
DRAWN = draw_frame(RIG, TARGET, TRUE)
IMAGES = (DRAWN.left.pixels, DRAWN.right.pixels)
CORE = Core(RIG, TARGET)
KNOWLEDGE = Knowledge(RIG, MODEL)
ACQUIRED = CORE.process(*IMAGES)
TRACKED = attrs.evolve(ACQUIRED, bracket=None)


@pytest.fixture(scope="module")
def good() -> Measurement:
    learned = Learned.nothing(KNOWLEDGE.lasting)
    return measure(CORE, RIG, MODEL, KNOWLEDGE, learned, IMAGES, ACQUIRED.bracket.T_world_target, UNKNOWN)


def reasons(
    measurement: Measurement, settings: NavigatorSettings = SETTINGS, frame: FrameResult = ACQUIRED
) -> frozenset[Reason]:
    return failed_gates(measurement, MODEL, frame, RIG, KNOWLEDGE, settings, CORE.config)


def hide(measurement: Measurement, camera: int, edges: list[int]) -> Measurement:
    """The measurement with some edges' profiles in a view declared outliers."""
    agreed, polarity = measurement.agreed.copy(), measurement.polarity.copy()
    agreed[camera, edges] = 0
    polarity[camera, edges] = 0
    return attrs.evolve(measurement, agreed=agreed, polarity=polarity)


def with_pose(measurement: Measurement, **changes: object) -> Measurement:
    return attrs.evolve(measurement, pose=attrs.evolve(measurement.pose, **changes))


@pytest.mark.parametrize("edges", [[0, 2, 4], [0, 1, 2, 4], [0, 1]])
def test_few_lines_do_not_move_an_acquired_pose(edges: list[int]) -> None:
    """One of them is a bar's width off, as where noise hides most edges; three or four lines don't tell which, and two
    parallel ones determine nothing."""
    left = ACQUIRED.views[0]
    assert left is not None
    assert left.line_found[edges].all()
    lines = left.lines.copy()
    lines["rho"][edges[0]] += 8.0
    few = attrs.evolve(left, lines=lines, line_found=np.isin(np.arange(8), edges), apex_found=np.zeros(8, np.bool_))
    blank = attrs.evolve(few, line_found=np.zeros(8, np.bool_))
    frame = attrs.evolve(ACQUIRED, views=(few, blank), apex_found=np.zeros(8, np.bool_))
    learned = Learned.nothing(KNOWLEDGE.lasting)
    T, _ = coarse_pose(MODEL, frame, rectified_cameras(RIG), TRUE, KNOWLEDGE, learned)
    np.testing.assert_array_equal(T, TRUE)


def test_a_good_measurement_passes(good: Measurement) -> None:
    assert reasons(good) == frozenset()
    assert good.total_coverage > 0.9


def test_one_view_that_shows_too_little(good: Measurement) -> None:
    three_hidden = hide(good, 1, [1, 5, 7])
    assert reasons(three_hidden) == frozenset()
    four_hidden = hide(three_hidden, 1, [3])
    assert reasons(four_hidden) == {Reason.TOO_FEW_LINES}


def test_a_bar_that_is_hardly_shown(good: Measurement) -> None:
    """Without l2 a bracket of another height would fit as well, tilted.  Of an acquired target more is asked, and
    less where all other bars are wholly shown and vouch for it."""
    one_outer_edge = [(0, [2])]
    outer_edges = [(0, [2]), (1, [2])]
    but_one = [(0, [2, 3]), (1, [2])]
    all_of_it = [(0, [2, 3]), (1, [2, 3])]
    but_one_and_another = [(0, [2, 3]), (1, [2, 6])]
    and_another = [(0, [2, 6]), (1, [2, 6])]
    for hidden, acquired_passes, tracked_passes in (
        (one_outer_edge, True, True),
        (outer_edges, True, True),
        (and_another, False, True),
        (but_one, True, True),
        (but_one_and_another, False, False),
        (all_of_it, False, False),
    ):
        spoiled = good
        for camera, edges in hidden:
            spoiled = hide(spoiled, camera, edges)
        for frame, passes in ((ACQUIRED, acquired_passes), (TRACKED, tracked_passes)):
            assert reasons(spoiled, frame=frame) == (set() if passes else {Reason.TOO_FEW_LINES})


def test_a_bars_only_edge_must_have_its_light_side_where_the_others_have_it(good: Measurement) -> None:
    """Else it is the bar's other edge, and the pose lies a bar's width off."""
    outer_hidden = hide(hide(good, 0, [2]), 1, [2])
    polarity = outer_hidden.polarity.copy()
    polarity[1, 3] *= -1
    turned = attrs.evolve(outer_hidden, polarity=polarity)
    assert reasons(outer_hidden) == set()
    assert reasons(turned) == {Reason.TOO_FEW_LINES}


def test_a_bar_beyond_the_images_is_not_asked_for(good: Measurement) -> None:
    attempted = good.attempted.copy()
    attempted[:, [2, 3]] = 0
    without_l2 = hide(hide(good, 0, [2, 3]), 1, [2, 3])
    assert reasons(attrs.evolve(without_l2, attempted=attempted)) == frozenset()


def test_the_drawn_bars_are_seen_to_be_lighter_than_what_is_beside_them(good: Measurement) -> None:
    np.testing.assert_array_equal(good.polarity, np.tile([1, -1], (2, 4)))


@pytest.mark.parametrize("bar", range(4))
def test_a_bar_measured_a_width_beside_itself(good: Measurement, bar: int) -> None:
    """Its outer edge found where the inner one is: dark inwards, and nothing where the inner one is expected."""
    outer, inner = 2 * bar, 2 * bar + 1
    polarity = good.polarity.copy()
    for camera, expected in ((0, set()), (1, {Reason.DISPLACED})):
        polarity[camera, outer] *= -1
        displaced = attrs.evolve(good, polarity=polarity.copy())
        for hidden in range(camera + 1):
            displaced = hide(displaced, hidden, [inner])
        assert reasons(displaced, frame=TRACKED) == expected


def test_too_small_a_part_of_all_edges(good: Measurement) -> None:
    """Each edge shown just enough to count, all of them together too little."""
    few = np.ceil(0.4 * good.attempted).astype(np.int64)
    assert (few < good.agreed).all()
    assert reasons(attrs.evolve(good, agreed=few)) == {Reason.TOO_FEW_LINES}


def test_a_pose_that_still_moves(good: Measurement) -> None:
    assert reasons(attrs.evolve(good, settled=False)) == {Reason.NOT_CONVERGED}


def test_residuals(good: Measurement) -> None:
    worse = np.full_like(good.pose.residuals, 1.01 * SETTINGS.max_rms_px)
    lines = attrs.evolve(good.lines, shift_sigma=np.zeros(len(good.lines)))
    assert reasons(with_pose(attrs.evolve(good, lines=lines), residuals=worse)) == {Reason.RESIDUALS}
    assert reasons(with_pose(attrs.evolve(good, lines=lines), residuals=0.98 * worse)) == frozenset()


def test_covariance(good: Measurement) -> None:
    vague_position, vague_attitude = good.pose.covariance.copy(), good.pose.covariance.copy()
    vague_position[0, 0] = (1.1 * SETTINGS.max_position_sigma) ** 2
    assert reasons(with_pose(good, covariance=vague_position)) == {Reason.COVARIANCE}
    distance = np.linalg.norm(good.pose.T_world_target[:3, 3])
    vague_attitude[4, 4] = (1.1 * SETTINGS.max_attitude_sigma * (1 + distance)) ** 2
    assert reasons(with_pose(good, covariance=vague_attitude)) == {Reason.COVARIANCE}


@pytest.mark.parametrize("gate", [(0.25, 0.85), (0.95, 1.7)])
def test_range_gate(good: Measurement, gate: tuple[float, float]) -> None:
    """Of what was sought; a track goes on beyond it."""
    config = Core(RIG, TARGET, range_min=gate[0], range_max=gate[1]).config
    for frame, expected in ((ACQUIRED, {Reason.RANGE_GATE}), (TRACKED, set())):
        assert failed_gates(good, MODEL, frame, RIG, KNOWLEDGE, SETTINGS, config) == expected


def moved_matches(pixels: float) -> FrameResult:
    matches = ACQUIRED.matches.copy()
    matches["disparity"] += pixels
    return attrs.evolve(ACQUIRED, matches=matches)


def test_views_that_contradict_each_other(good: Measurement) -> None:
    assert (ACQUIRED.matches["accepted"] != 0).sum() >= 3
    assert reasons(good, frame=moved_matches(0.8 * SETTINGS.max_disparity_px)) == frozenset()
    for sign in (1, -1):
        assert reasons(good, frame=moved_matches(sign * 1.3 * SETTINGS.max_disparity_px)) == {Reason.CROSS_VIEW}


def turned_right_view(measurement: Measurement, degrees: float) -> Measurement:
    """The measurement with the right image turned about its principal point."""
    theta = measurement.lines.theta + np.radians(degrees) * (measurement.lines.camera == 1)
    return attrs.evolve(measurement, lines=attrs.evolve(measurement.lines, theta=theta))


def test_views_that_each_tell_of_another_pose(good: Measurement) -> None:
    assert view_difference(good, RIG) < 0.6 * SETTINGS.view_sigmas
    for degrees in (0.05, -0.05):  # a sound calibration's error
        assert reasons(turned_right_view(good, degrees)) == frozenset()
    for degrees in (0.3, -0.3):
        assert reasons(turned_right_view(good, degrees)) == {Reason.CROSS_VIEW}


def test_a_calibration_may_be_trusted_less() -> None:
    """What contradicts an exact calibration may well be what one made by hand leaves open."""
    rig = attrs.evolve(RIG, calibration_covariance=None)
    knowledge = Knowledge(rig, MODEL)
    learned = Learned.nothing(knowledge.lasting)
    start = ACQUIRED.bracket.T_world_target
    by_hand = measure(CORE, rig, MODEL, knowledge, learned, IMAGES, start, UNKNOWN)
    assert view_difference(turned_right_view(by_hand, 0.1), rig) < SETTINGS.view_sigmas


def test_a_view_that_determines_no_pose_by_itself_contradicts_nothing(good: Measurement) -> None:
    kept = (good.lines.camera == 0) | (good.lines.edge < 2)
    few = [getattr(good.lines, field.name)[kept] for field in attrs.fields(LineMeasurements)]
    systematics = good.systematics.only(kept)
    assert view_difference(attrs.evolve(good, lines=LineMeasurements(*few), systematics=systematics), RIG) == 0.0


def test_a_minority_of_points_matched_elsewhere_is_no_contradiction(good: Measurement) -> None:
    accepted = np.flatnonzero(ACQUIRED.matches["accepted"] != 0)
    for astray, expected in ((len(accepted) // 2, set()), (len(accepted) // 2 + 1, {Reason.CROSS_VIEW})):
        moved = moved_matches(0.0)
        moved.matches["disparity"][accepted[:astray]] += 114.0
        assert reasons(good, frame=moved) == expected


def test_disparities_of_correlated_points_are_held_against_the_true_face(good: Measurement) -> None:
    """Each accepted point triangulated by hand lies on the drawn front face."""
    errors, sigmas = disparity_errors(ACQUIRED.matches, good.pose, TARGET.bracket, RIG, KNOWLEDGE)
    assert not sigmas.any()
    matches = ACQUIRED.matches[ACQUIRED.matches["accepted"] != 0]
    assert len(errors) == len(matches)
    depth = RIG.focal_rect * RIG.baseline / matches["disparity"]
    rays = np.column_stack([matches["x"], matches["y"], np.full(len(matches), RIG.focal_rect)]) / RIG.focal_rect
    points_W = (rays * depth[:, None]) @ RIG.R_world_rect.T + RIG.T_world_cam[0][:3, 3]
    off_face = ((points_W - TRUE[:3, 3]) @ TRUE[:3, :3])[:, 0]
    # Nearer to the cameras (negative x_C) means a larger disparity.
    slope = RIG.focal_rect * RIG.baseline / depth**2
    np.testing.assert_allclose(errors, -off_face * slope, atol=0.1 + 0.02 * np.abs(errors).max())
    assert abs(float(np.median(errors))) < 0.5


@pytest.mark.parametrize(
    ("position_m", "turn_deg", "seconds", "expected"),
    [
        (0.005, 0.0, 1e-9, True),  # 5 sigma
        (0.007, 0.0, 1e-9, False),  # 7 sigma, and no time to get there
        (0.10, 0.0, 0.125, True),  # 0.8 m/s
        (0.13, 0.0, 0.125, False),  # 1.04 m/s
        (0.0, 7.0, 0.125, True),  # 56 degrees a second
        (0.0, 8.0, 0.125, False),  # 64
        (0.05, 8.0, 0.125, False),
    ],
)
def test_motion(good: Measurement, position_m: float, turn_deg: float, seconds: float, expected: bool) -> None:
    prediction = PredictedPose(TRUE, np.diag([1e-3, 1e-3, 1e-3, 5e-3, 5e-3, 5e-3]) ** 2)
    change = np.array([position_m, 0.0, 0.0, 0.0, np.radians(turn_deg), 0.0])
    moved = attrs.evolve(with_pose(good, T_world_target=perturb(TRUE, change)), own_covariance=np.eye(6) * 1e-12)
    assert plausible_motion(moved, True, prediction, NOTHING, seconds, SETTINGS) is expected


def test_one_view_overrules_a_prediction_only_if_it_shows_the_whole_target() -> None:
    prediction = PredictedPose(TRUE, np.diag([1e-3, 1e-3, 1e-3, 5e-3, 5e-3, 5e-3]) ** 2)
    learned = Learned.nothing(KNOWLEDGE.lasting)
    left = measure(CORE, RIG, MODEL, KNOWLEDGE, learned, (IMAGES[0], None), TRUE, UNKNOWN)
    moved = with_pose(left, T_world_target=perturb(TRUE, np.array([0.02, 0.0, 0.0, 0.0, 0.0, 0.0])))
    assert plausible_motion(moved, True, prediction, NOTHING, 0.125, SETTINGS)
    assert not plausible_motion(hide(moved, 0, [2, 3, 4]), True, prediction, NOTHING, 0.125, SETTINGS)
    # What errs alike in all frames may differ between one view and two.
    lasting = np.diag([0.01, 0.01, 0.01, 0.0, 0.0, 0.0]) ** 2
    assert plausible_motion(hide(moved, 0, [2, 3, 4]), True, prediction, lasting, 0.125, SETTINGS)


@pytest.mark.parametrize(("position_m", "expected"), [(0.005, True), (0.10, False)])
def test_motion_found_in_the_windows_of_the_prediction(good: Measurement, position_m: float, expected: bool) -> None:
    """Far from the prediction only a search of the whole images is believed, however slow the motion."""
    prediction = PredictedPose(TRUE, np.diag([1e-3, 1e-3, 1e-3, 5e-3, 5e-3, 5e-3]) ** 2)
    change = np.array([position_m, 0.0, 0.0, 0.0, 0.0, 0.0])
    moved = attrs.evolve(with_pose(good, T_world_target=perturb(TRUE, change)), own_covariance=np.eye(6) * 1e-12)
    assert plausible_motion(moved, False, prediction, NOTHING, 0.125, SETTINGS) is expected


@pytest.mark.parametrize(
    ("step_ns", "words"),
    [
        (250_000_000, None),
        (8_000_000, None),
        (1_000_000, "lie 1 ms apart, in which the target may move 1 mm (1 m/s): are the stamps right?"),
        (3_000_000_000, "lie 3e+03 ms apart: a target is followed for 2 s without one and then searched anew"),
    ],
)
def test_a_rate_that_does_not_go_with_the_speeds_is_told(step_ns: int, words: str | None) -> None:
    told = NavigatorSettings().rate_notice([step_ns * i for i in range(5)])
    assert told == (None if words is None else f"the frames {words}")
    assert NavigatorSettings().rate_notice([7]) is None
