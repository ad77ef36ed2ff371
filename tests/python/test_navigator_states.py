"""The navigator's states, frame by frame, on a drawn target that stands still."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from drawn_scene import START_NS, STEP_NS, Look, bracket_target, draw_images, example_rig, frame_of, pose
from rvdnav import InputError, Navigator, Rig, Solution
from rvdnav.navigator.transitions import TRANSITIONS, next_state
from rvdnav.solution import Mode, Reason, State
from rvdnav.target import Target

RIG, TARGET = example_rig(), bracket_target()
TRUE = pose(0.8, 0.01, 0.06, 2.0, -3.0, 2.0)
BLACK = np.zeros((RIG.height, RIG.width), np.uint8)
WHITE = np.full((RIG.height, RIG.width), 255, np.uint8)
PLAIN = Look(clutter=False, thick=False)
Images = tuple[np.ndarray | None, np.ndarray | None]


@pytest.fixture(scope="module")
def seen() -> Images:
    return draw_images(RIG, TARGET, TRUE, look=PLAIN)


@pytest.fixture(scope="module")
def blank() -> Images:
    return draw_images(RIG, TARGET, TRUE, look=Look(bracket=False, clutter=False))


class Clock:
    """Gives images to a navigator, one step of time after the other."""

    def __init__(self, **options: float) -> None:
        self.navigator = Navigator(RIG, TARGET, **options)
        self._times = self._tick()

    def show(self, images: Sequence[np.ndarray | None]) -> Solution:
        return self.navigator.process(frame_of(images, next(self._times)))

    @staticmethod
    def _tick() -> Iterator[int]:
        number = 0
        while True:
            yield START_NS + number * STEP_NS
            number += 1


def sigmas(solution: Solution) -> np.ndarray:
    return np.sqrt(np.diag(solution.covariance))


@pytest.mark.parametrize(
    ("state", "measured", "expired", "after"),
    [
        (State.SEARCHING, True, False, State.TRACKING),
        (State.SEARCHING, False, False, State.SEARCHING),
        (State.SEARCHING, False, True, State.SEARCHING),
        (State.TRACKING, True, False, State.TRACKING),
        (State.TRACKING, False, False, State.COASTING),
        (State.TRACKING, False, True, State.LOST),
        (State.COASTING, True, False, State.TRACKING),
        (State.COASTING, True, True, State.TRACKING),
        (State.COASTING, False, False, State.COASTING),
        (State.COASTING, False, True, State.LOST),
        (State.LOST, True, True, State.TRACKING),
        (State.LOST, False, False, State.SEARCHING),
        (State.LOST, False, True, State.SEARCHING),
    ],
)
def test_transitions(state: State, measured: bool, expired: bool, after: State) -> None:
    assert next_state(state, measured=measured, coast_expired=expired) is after


def test_every_state_has_its_transitions() -> None:
    assert set(TRANSITIONS) == set(State)


def test_a_target_lost_and_found(seen: Images, blank: Images) -> None:
    """Coasts 0.5 s on a growing covariance, is lost for one frame, searches, and tracks again at once."""
    clock = Clock(coast_seconds=0.5)
    tracked = [clock.show(seen) for _ in range(4)]
    assert [s.state for s in tracked] == [State.TRACKING] * 4
    assert all(s.mode is Mode.STEREO and not s.reasons for s in tracked)

    coasted = [clock.show(blank) for _ in range(4)]
    assert [s.state for s in coasted] == [State.COASTING] * 4
    for solution in coasted:
        assert not solution.published
        assert solution.reasons
        assert np.linalg.norm(solution.predicted_T_world_target[:3, 3] - TRUE[:3, 3]) < 0.01
    growth = np.array([sigmas(s) for s in (tracked[-1], *coasted)])
    assert (np.diff(growth, axis=0) > 0.0).all()

    lost, searching = clock.show(blank), clock.show(blank)
    assert (lost.state, searching.state) == (State.LOST, State.SEARCHING)
    assert lost.predicted_T_world_target is None
    assert searching.predicted_T_world_target is None

    again = clock.show(seen)
    assert again.state is State.TRACKING
    assert again.predicted_T_world_target is None
    assert np.linalg.norm(again.T_world_target[:3, 3] - TRUE[:3, 3]) < 1e-3


def test_the_prediction_holds_the_truth_while_coasting(seen: Images, blank: Images) -> None:
    clock = Clock()
    for _ in range(5):
        clock.show(seen)
    for _ in range(6):
        solution = clock.show(blank)
        error = solution.predicted_T_world_target[:3, 3] - TRUE[:3, 3]
        assert (np.abs(error) <= 3.0 * sigmas(solution)[:3]).all()


@pytest.mark.parametrize("gap", [1, 3, 8])
def test_tracking_goes_on_after_a_gap(seen: Images, blank: Images, gap: int) -> None:
    clock = Clock()
    for _ in range(3):
        clock.show(seen)
    for _ in range(gap):
        assert clock.show(blank).state is State.COASTING
    assert clock.show(seen).state is State.TRACKING


def test_blank_images(blank: Images) -> None:
    solution = Navigator(RIG, TARGET).process(frame_of(blank))
    assert solution.state is State.SEARCHING
    assert solution.reasons == {Reason.LEFT_UNUSABLE, Reason.RIGHT_UNUSABLE}
    assert solution.covariance is None


def test_a_scene_without_the_bracket() -> None:
    scene = draw_images(RIG, TARGET, TRUE, look=Look(bracket=False))
    solution = Navigator(RIG, TARGET).process(frame_of(scene))
    assert solution.state is State.SEARCHING
    assert Reason.NO_TARGET in solution.reasons
    assert solution.covariance is None


@pytest.mark.parametrize(
    ("spoil", "reason"),
    [
        (lambda left, right: (None, right), Reason.LEFT_MISSING),
        (lambda left, right: (left, None), Reason.RIGHT_MISSING),
        (lambda left, right: (BLACK, right), Reason.LEFT_UNUSABLE),
        (lambda left, right: (left, BLACK), Reason.RIGHT_UNUSABLE),
        (lambda left, right: (WHITE, right), Reason.LEFT_UNUSABLE),
        (lambda left, right: (left, WHITE), Reason.RIGHT_UNUSABLE),
    ],
)
def test_one_camera_without_a_usable_image(seen: Images, spoil, reason: Reason) -> None:
    searching = Navigator(RIG, TARGET).process(frame_of(spoil(*seen)))
    assert searching.state is State.SEARCHING
    assert reason in searching.reasons

    clock = Clock()
    clock.show(seen)
    clock.show(seen)
    coasting = clock.show(spoil(*seen))
    assert coasting.state is State.COASTING
    assert coasting.predicted_T_world_target is not None
    assert reason in coasting.reasons
    assert clock.show(seen).state is State.TRACKING


def test_both_images_missing(seen: Images) -> None:
    solution = Navigator(RIG, TARGET).process(frame_of((None, None)))
    assert solution.reasons == {Reason.LEFT_MISSING, Reason.RIGHT_MISSING}


@pytest.mark.parametrize("step_ns", [0, -1, -STEP_NS])
def test_frames_out_of_order(seen: Images, step_ns: int) -> None:
    navigator = Navigator(RIG, TARGET)
    last = START_NS + STEP_NS
    navigator.process(frame_of(seen, START_NS))
    assert navigator.process(frame_of(seen, last)).published
    late = navigator.process(frame_of(seen, last + step_ns))
    assert not late.published
    assert late.reasons == {Reason.TIME_ORDER}
    assert navigator.process(frame_of(seen, last + STEP_NS)).published


def test_a_jump_is_no_motion(seen: Images) -> None:
    """A target 0.3 m nearer after 1/8 s is another one, or an error."""
    clock = Clock()
    for _ in range(4):
        clock.show(seen)
    jumped = clock.show(draw_images(RIG, TARGET, pose(0.5, 0.01, 0.06), look=PLAIN))
    assert jumped.state is State.COASTING
    assert Reason.MOTION in jumped.reasons


def test_what_the_navigator_cannot_work_with() -> None:
    one_camera = Rig(RIG.cameras[:1], [np.eye(4)])
    with pytest.raises(InputError, match="two"):
        Navigator(one_camera, TARGET)
    with pytest.raises(InputError, match="known dimensions"):
        Navigator(RIG, Target("guess", TARGET.points, TARGET.lines, TARGET.bars, 0.006, dimensions_known=False))
    with pytest.raises(InputError, match="four-bar"):
        Navigator(RIG, Target("panel", TARGET.points, edges=[("P1", "P2"), ("P2", "P3")]))
    with pytest.raises(TypeError):
        Navigator(RIG, TARGET, no_such_option=1)
    for value in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="coast_seconds"):
            Navigator(RIG, TARGET, coast_seconds=value)


def test_options_of_the_core_reach_it(seen: Images) -> None:
    assert not Navigator(RIG, TARGET, range_min=1.0).process(frame_of(seen)).published
