"""What is told of errors of target and calibration: on drawn frames of a rig and a target that the files don't have."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
import pytest
from drawn_scene import START_NS, bracket_target, draw_frame, example_rig, pose
from rvdnav import Navigator, Rig, open_sequence
from rvdnav.corrections import Corrections
from rvdnav.evaluation import pose_error
from rvdnav.faults import FaultySequence, parse_fault
from rvdnav.faults.knowledge import target_points
from rvdnav.rig import calibration_parameters
from rvdnav.solution import Reason, Solution
from rvdnav.target import Target

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "approach"
SEQUENCES = Path(__file__).resolve().parents[3] / "shared" / "data" / "sequences"
RIG = attrs.evolve(example_rig(), calibration_covariance=None)  # as made by hand
TARGET = attrs.evolve(bracket_target(), tolerance=None)  # as with calipers: 0.3 mm
NAMES = calibration_parameters(2)
SIGMAS = np.sqrt(np.diagonal(RIG.calibration_or_default))
POSES = [pose(0.62 - 0.02 * k, 0.01 * k, 0.05, 9 - 5 * k, 3 * k - 4, 2 * k) for k in range(4)]
ALARMS = {Reason.TARGET_TOLERANCE, Reason.CALIBRATION}
TIMES = 5.0


def solutions(true_rig: Rig, true_target: Target, rig: Rig = RIG, target: Target = TARGET) -> list[Solution]:
    """Of frames drawn of true ones, by a navigator that is told others."""
    navigator = Navigator(rig, target)
    return [
        navigator.process(
            draw_frame(true_rig, true_target, T, timestamp_ns=START_NS + number * 500_000_000, seed=number)
        )
        for number, T in enumerate(POSES)
    ]


def errors(told: Corrections, delta: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """Of all corrections less the true errors (22,), (8, 3), in their standard deviations."""
    values = [*told.calibration.values(), *told.points.values()]
    truth = np.concatenate([delta, moved.ravel()])
    assert list(told.calibration) == list(NAMES)
    assert tuple(told.points) == TARGET.bracket_names
    found, sigma = (np.hstack([getattr(own, name) for own in values]) for name in ("value", "sigma"))
    return (found - truth) / sigma


def moved_points(target: Target) -> np.ndarray:
    """(8, 3), m: from the told target to this one."""
    return np.array([target.points[name] - TARGET.points[name] for name in TARGET.bracket_names])


# Of an error of 1.5 stated standard deviations, what of it the images show at least: one camera's focal length is seen
# against the other's, the roll by itself, the others through the pitch and yaw of both views, and the baseline hardly.
CASES = {
    ("cam1.fx", "cam1.fy"): 0.4,
    ("cam1.cx",): 0.1,
    ("cam1_cam0.rx",): 0.04,
    ("cam1_cam0.ry",): 0.04,
    ("cam1_cam0.rz",): 0.7,
    ("cam1_cam0.tx",): 0.04,
}


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("wrong", CASES)
def test_a_correction_is_what_to_add_to_the_calibration(wrong: tuple[str, ...], sign: int) -> None:
    delta = 1.5 * sign * SIGMAS * np.isin(NAMES, wrong)
    last = solutions(RIG.perturbed(delta), TARGET)[-1]
    told = last.corrections
    assert told is not None
    assert told.frames == len(POSES)
    assert not last.reasons & ALARMS
    assert (np.abs(errors(told, delta, np.zeros((8, 3)))) < 3.0).all()
    for name in wrong:
        own = told.calibration[name]
        assert own.stated == pytest.approx(SIGMAS[NAMES.index(name)])
        assert own.value * sign > CASES[wrong] * 1.5 * own.stated
        assert own.sigma < own.stated


@pytest.mark.parametrize("draw", [2, 6])  # one view lies 8 and 3 rows off
def test_a_calibration_far_off_is_followed_from_the_first_frame_on(draw: int) -> None:
    """Rows further apart than the profiles across the edges reach, and a bar's width when far away."""
    recorded = open_sequence(EXAMPLE)
    sequence = FaultySequence(recorded, [parse_fault("calibration=0.5,3,0.1:all")], seed=draw)
    rig = attrs.evolve(sequence.rig, calibration_covariance=None)
    assert recorded.truth is not None
    for number in (4, 16):
        solution = Navigator(rig, attrs.evolve(sequence.target, tolerance=None)).process(sequence[number])
        assert solution.published
        error = pose_error(solution.T_world_target, recorded.truth.at(solution.timestamp_ns))
        assert np.linalg.norm(error[:3]) < 0.02
        assert (np.abs(error) < 5.0 * np.sqrt(np.diagonal(solution.covariance))).all()


@pytest.mark.parametrize("seed", range(3))
def test_a_correction_is_what_to_add_to_the_points(seed: int) -> None:
    true = target_points(TARGET, np.random.default_rng(seed), 0.45)
    moved = moved_points(true)
    last = solutions(RIG, true)[-1]
    told = last.corrections
    assert told is not None
    assert not last.reasons & ALARMS
    assert (np.abs(errors(told, np.zeros(22), moved)) < 3.0).all()
    assert {own.stated for own in told.points.values()} == {3e-4}
    in_plane = np.array([own.value for own in told.points.values()])[:, 1:]
    # All but the place of the whole, which is the pose's.
    assert np.corrcoef(in_plane.ravel(), moved[:, 1:].ravel())[0, 1] > 0.85


def test_reduced_images_correct_the_rig_that_was_given() -> None:
    delta = 1.5 * SIGMAS * np.isin(NAMES, ["cam1.fx", "cam1.fy"])
    frames = [draw_frame(RIG.perturbed(delta), TARGET, T, timestamp_ns=START_NS + 1) for T in POSES[:1]]
    whole, half = (Navigator(RIG, TARGET, max_pixels=pixels).process(frames[0]) for pixels in (10**6, 2 * 10**5))
    assert whole.corrections is not None
    assert half.corrections is not None
    own, reduced = (told.calibration["cam1.fx"] for told in (whole.corrections, half.corrections))
    assert own.stated == reduced.stated
    assert reduced.value == pytest.approx(own.value, abs=own.sigma)
    assert reduced.value > 0.2 * delta[NAMES.index("cam1.fx")]


def test_nothing_is_corrected_where_all_is_exact() -> None:
    rig = attrs.evolve(RIG, calibration_covariance=np.zeros((22, 22)))
    assert all(s.published and s.corrections is None for s in solutions(rig, bracket_target(), rig, bracket_target()))
    half = solutions(rig, TARGET, rig, TARGET)[-1].corrections
    assert half is not None
    assert (half.calibration, half.calibration_scale) == ({}, 1.0)


@pytest.mark.parametrize("seed", range(4))
def test_errors_as_stated_raise_no_alarm(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    delta = np.linalg.cholesky(RIG.calibration_or_default) @ rng.standard_normal(22)
    run = solutions(RIG.perturbed(delta), target_points(TARGET, rng, 0.3))
    assert run[-1].published
    assert not any(s.reasons & ALARMS for s in run)


@pytest.mark.parametrize("seed", range(3))
def test_points_off_by_several_times_the_tolerance_raise_the_alarm(seed: int) -> None:
    true = target_points(TARGET, np.random.default_rng(200 + seed), 0.3 * TIMES)
    published = [s for s in solutions(RIG, true) if s.published]
    assert published
    assert all(Reason.TARGET_TOLERANCE in s.reasons for s in published)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("wrong", [{"cam0.f": -(0.5**0.5), "cam1.f": 0.5**0.5}, {"cam1_cam0.rz": 1.0}])
def test_a_calibration_off_by_several_times_its_covariance_raises_the_alarm(wrong: dict[str, float], sign: int) -> None:
    """In what the images show: the focal lengths against each other, the roll between the cameras."""
    delta = TIMES * sign * SIGMAS * [sum(part for start, part in wrong.items() if n.startswith(start)) for n in NAMES]
    last = solutions(RIG.perturbed(delta), TARGET)[-1]
    assert last.published
    assert last.reasons & ALARMS == {Reason.CALIBRATION}


@pytest.mark.skipif(not SEQUENCES.is_dir(), reason="the given sequences are not here")
@pytest.mark.parametrize(
    ("name", "fault", "told"),
    [
        ("approach", None, set()),
        ("sunlit", None, set()),
        ("sunlit", "target_points=1.5:all", {Reason.TARGET_TOLERANCE}),
        ("sunlit", "calibration=1,5,0.15:all", {Reason.CALIBRATION}),
    ],
)
def test_the_given_sequences(name: str, fault: str | None, told: set[Reason]) -> None:
    sequence = FaultySequence(open_sequence(SEQUENCES / name), [] if fault is None else [parse_fault(fault)])
    navigator = Navigator(sequence.rig, sequence.target)
    run = [navigator.process(sequence[index]) for index in range(0, 20, 2)]
    assert any(s.published for s in run)
    assert fault is not None or all(s.published for s in run)
    assert {reason for s in run for reason in s.reasons & ALARMS} == told
