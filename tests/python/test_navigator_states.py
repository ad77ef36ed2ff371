"""The navigator's states, frame by frame, on a drawn target that stands still."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pytest
from drawn_scene import START_NS, STEP_NS, Look, bracket_target, draw_images, example_rig, frame_of, pose
from rvdnav import InputError, Navigator, Solution
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
    """Gives images to a navigator, one step of time after the other, each with a pixel of its own as noise would."""

    def __init__(self, **options: float) -> None:
        self.navigator = Navigator(RIG, TARGET, **options)
        self._times = self._tick()

    def show(self, images: Sequence[np.ndarray | None]) -> Solution:
        stamp = next(self._times)
        return self.navigator.process(frame_of([own_image(image, stamp) for image in images], stamp))

    @staticmethod
    def _tick() -> Iterator[int]:
        number = 0
        while True:
            yield START_NS + number * STEP_NS
            number += 1


def own_image(image: np.ndarray | None, timestamp_ns: int) -> np.ndarray | None:
    """The image with a corner pixel that tells the time; one of a single grey level stays as it is."""
    if image is None or image.min() == image.max():
        return image
    changed = image.copy()
    changed[0, 0] = (timestamp_ns // STEP_NS) % 256
    return changed


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
    ("spoil", "reason", "mode"),
    [
        (lambda left, right: (None, right), Reason.LEFT_MISSING, Mode.MONO_RIGHT),
        (lambda left, right: (left, None), Reason.RIGHT_MISSING, Mode.MONO_LEFT),
        (lambda left, right: (BLACK, right), Reason.LEFT_UNUSABLE, Mode.MONO_RIGHT),
        (lambda left, right: (left, BLACK), Reason.RIGHT_UNUSABLE, Mode.MONO_LEFT),
        (lambda left, right: (WHITE, right), Reason.LEFT_UNUSABLE, Mode.MONO_RIGHT),
        (lambda left, right: (left, WHITE), Reason.RIGHT_UNUSABLE, Mode.MONO_LEFT),
    ],
)
def test_one_camera_without_a_usable_image(seen: Images, spoil, reason: Reason, mode: Mode) -> None:
    clock = Clock()
    stereo = [clock.show(seen) for _ in range(2)][-1]
    mono = clock.show(spoil(*seen))
    assert mono.state is State.TRACKING
    assert mono.mode is mode
    assert mono.reasons == {reason}
    assert np.linalg.norm(mono.T_world_target[:3, 3] - TRUE[:3, 3]) < 3e-3
    assert sigmas(mono)[0] > sigmas(stereo)[0]  # the range is known from the size alone
    assert clock.show(seen).mode is Mode.STEREO


def test_both_images_missing(seen: Images) -> None:
    solution = Navigator(RIG, TARGET).process(frame_of((None, None)))
    assert solution.reasons == {Reason.LEFT_MISSING, Reason.RIGHT_MISSING}


@pytest.mark.parametrize("step_ns", [0, -1, -STEP_NS])
def test_frames_out_of_order(seen: Images, step_ns: int) -> None:
    navigator = Navigator(RIG, TARGET)
    last = START_NS + STEP_NS
    shown = [[own_image(image, START_NS + number * STEP_NS) for image in seen] for number in range(4)]
    navigator.process(frame_of(shown[0], START_NS))
    assert navigator.process(frame_of(shown[1], last)).published
    late = navigator.process(frame_of(shown[2], last + step_ns))
    assert not late.published
    assert late.reasons == {Reason.TIME_ORDER}
    assert navigator.process(frame_of(shown[3], last + STEP_NS)).published


@pytest.mark.parametrize("frozen", [(True, True), (True, False), (False, True)])
def test_images_that_come_once_more_under_a_new_stamp(seen: Images, frozen: tuple[bool, bool]) -> None:
    navigator = Navigator(RIG, TARGET)
    stamps = [START_NS + number * STEP_NS for number in range(4)]
    fresh = [[own_image(image, stamp) for image in seen] for stamp in stamps]
    buffer = [image.copy() for image in fresh[0]]
    assert navigator.process(frame_of(buffer, stamps[0])).published
    for camera in (0, 1):  # in the same memory, as a frame grabber would
        buffer[camera][:] = fresh[1][camera]
    assert navigator.process(frame_of(buffer, stamps[1])).published
    repeated = [fresh[1][camera] if frozen[camera] else fresh[2][camera] for camera in (0, 1)]
    solution = navigator.process(frame_of(repeated, stamps[2]))
    assert solution.reasons == {Reason.DUPLICATE}
    # The other camera alone goes on.
    mode = {(True, True): None, (True, False): Mode.MONO_RIGHT, (False, True): Mode.MONO_LEFT}[frozen]
    assert solution.mode is mode
    assert solution.state is (State.COASTING if mode is None else State.TRACKING)
    assert navigator.process(frame_of(fresh[3], stamps[3])).published


def test_a_frozen_camera_is_known_across_a_missing_image(seen: Images) -> None:
    navigator = Navigator(RIG, TARGET)
    stamps = [START_NS + number * STEP_NS for number in range(3)]
    left, right = seen
    assert navigator.process(frame_of((left, own_image(right, stamps[0])), stamps[0])).published
    assert navigator.process(frame_of((None, own_image(right, stamps[1])), stamps[1])).reasons == {Reason.LEFT_MISSING}
    frozen = navigator.process(frame_of((left, own_image(right, stamps[2])), stamps[2]))
    assert frozen.reasons == {Reason.DUPLICATE}
    assert frozen.mode is Mode.MONO_RIGHT


def test_black_images_are_unusable_rather_than_duplicates(seen: Images) -> None:
    clock = Clock()
    clock.show(seen)
    for _ in range(3):
        reasons = clock.show((BLACK, seen[1])).reasons
        assert Reason.LEFT_UNUSABLE in reasons
        assert Reason.DUPLICATE not in reasons


def test_a_jump_is_no_motion(seen: Images) -> None:
    """A target 0.3 m nearer after 1/8 s is another one, or an error."""
    clock = Clock()
    for _ in range(4):
        clock.show(seen)
    jumped = clock.show(draw_images(RIG, TARGET, pose(0.5, 0.01, 0.06), look=PLAIN))
    assert jumped.state is State.COASTING
    assert Reason.MOTION in jumped.reasons


def test_what_the_navigator_cannot_work_with() -> None:
    with pytest.raises(InputError, match="unknown dimensions"):
        Navigator(RIG, Target("panel", TARGET.points, edges=TARGET.lines.values(), dimensions_known=False))
    with pytest.raises(InputError, match="4 edges"):
        Navigator(RIG, Target("panel", TARGET.points, edges=[("P1", "P2"), ("P2", "P3")]))
    with pytest.raises(TypeError):
        Navigator(RIG, TARGET, no_such_option=1)
    for value in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="coast_seconds"):
            Navigator(RIG, TARGET, coast_seconds=value)


def test_options_of_the_core_reach_it(seen: Images) -> None:
    """At 0.8 m the target lies within the default range gate, and before one that begins at 1 m."""
    assert Navigator(RIG, TARGET).process(frame_of(seen)).published
    beyond = Navigator(RIG, TARGET, range_min=1.0).process(frame_of(seen))
    assert (beyond.state, beyond.reasons) == (State.SEARCHING, {Reason.NO_TARGET})
    assert beyond.T_world_target is None
