"""Brackets whose size the navigator is not told: measured, learnt with an honest sigma, then navigated by."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import attrs
import numpy as np
import pytest
from drawn_scene import (
    START_NS,
    STEP_NS,
    Look,
    bracket_target,
    draw_frame,
    draw_images,
    example_rig,
    frame_of,
    pose,
    wide_rig,
)
from rvdnav import Frame, Navigator, Rig, Target, open_sequence
from rvdnav.blackbox import exact
from rvdnav.errors import InputError
from rvdnav.evaluation import pose_error
from rvdnav.solution import LearnedDimensions, Mode, Reason, Solution, State
from rvdnav.trapezoid import DIMENSIONS

RIGS = {"example": example_rig, "wide": wide_rig}
BRACKETS = {
    "180": bracket_target(),
    "240": bracket_target(0.24, 0.15, 0.12, 0.02),
    "tall": bracket_target(0.2, 0.12, 0.22, 0.018, 0.01),
}
STEREO_FRAMES = 4


def unknown(target: Target) -> Target:
    """The target as a file of unknown dimensions gives it: with another bracket's sizes."""
    other = bracket_target(0.31, 0.07, 0.2, 0.03)
    return Target("unknown", other.points, target.lines, target.bars, target.bar_thickness, dimensions_known=False)


def true_sizes(target: Target) -> np.ndarray:
    bracket = target.bracket
    assert bracket is not None
    widths = bracket.bar_widths.mean(axis=1)
    return np.array([bracket.long_base, bracket.short_base, bracket.heights.mean(), *widths[:3]])


def errors_of(dimensions: LearnedDimensions, target: Target) -> tuple[np.ndarray, np.ndarray]:
    """Errors and standard deviations (6,), m."""
    assert tuple(dimensions.sizes_m) == DIMENSIONS
    sizes, sigmas = (
        np.array([values[name] for name in DIMENSIONS]) for values in (dimensions.sizes_m, dimensions.sigmas_m)
    )
    return sizes - true_sizes(target), sigmas


def approach(number: int) -> np.ndarray:
    return pose(0.8 - 0.02 * number, 0.01 * number, 0.04, 3 * np.sin(number), 4 * np.cos(number), -2 + number)


def frames(rig: Rig, target: Target, count: int) -> Iterator[tuple[Frame, np.ndarray]]:
    for number in range(count):
        T = approach(number)
        yield draw_frame(rig, target, T, timestamp_ns=START_NS + number * STEP_NS, seed=number), T


def one_view(frame: Frame, camera: int) -> Frame:
    images = [frame.left, frame.right]
    images[1 - camera] = None
    return attrs.evolve(frame, left=images[0], right=images[1])


@pytest.mark.parametrize("bracket", BRACKETS)
@pytest.mark.parametrize("rig", RIGS)
def test_learns_the_size_and_navigates_by_it_with_one_camera(rig: str, bracket: str) -> None:
    cameras, target = RIGS[rig](), BRACKETS[bracket]
    navigator = Navigator(cameras, unknown(target))
    assert navigator.learned_target is None
    distances = []
    for number, (frame, T) in enumerate(frames(cameras, target, STEREO_FRAMES + 2)):
        mono = number - STEREO_FRAMES
        solution = navigator.process(frame if mono < 0 else one_view(frame, mono))
        assert solution.published, (number, solution.reasons)
        assert solution.mode is (Mode.STEREO, Mode.MONO_LEFT, Mode.MONO_RIGHT)[max(mono + 1, 0)]
        error = pose_error(solution.T_world_target, T)
        assert np.linalg.norm(error[:3]) < (0.8e-3 if mono < 0 else 2e-3)
        assert np.degrees(np.linalg.norm(error[3:])) < 0.6
        distances.append(error @ np.linalg.solve(solution.covariance, error) / 6)
        off, sigma = errors_of(solution.dimensions, target)
        assert (np.abs(off) < 3 * sigma).all()
        assert np.abs(off[:3]).max() < 0.5e-3
        assert solution.dimensions.frames == min(number + 1, STEREO_FRAMES)
    assert np.mean(distances) < 2.0
    learned = navigator.learned_target
    assert learned.dimensions_known
    np.testing.assert_allclose(true_sizes(learned), [*solution.dimensions.sizes_m.values()], atol=1e-9)
    assert solution.dimensions.known
    assert sigma.max() < 1e-3


def test_without_a_bracket_there_is_nothing() -> None:
    for number, rig in enumerate((example_rig(), wide_rig())):
        for tilt in (0.0, 20.0, -25.0):
            T = pose(0.7 + 0.2 * number, 0.02, 0.03, tilt, -0.5 * tilt, tilt)
            frame = draw_frame(rig, bracket_target(), T, look=Look(bracket=False), seed=number)
            solution = Navigator(rig, unknown(bracket_target())).process(frame)
            assert not solution.published
            assert solution.dimensions is None
            assert solution.reasons & {Reason.NO_TARGET, Reason.AMBIGUOUS}


@pytest.mark.parametrize("short_base", [0.1799, 0.175])
def test_nearly_equal_bases_are_ambiguous(short_base: float) -> None:
    """Half a turn maps a frame with equal bases onto itself."""
    rig, target = example_rig(), bracket_target(0.18, short_base, 0.14)
    solution = Navigator(rig, unknown(target)).process(draw_frame(rig, target, approach(1)))
    assert not solution.published
    assert Reason.AMBIGUOUS in solution.reasons


def test_more_edge_pixels_than_the_core_takes() -> None:
    """Noise all over both images, as of a receiver without a signal, is no target; the limit is told."""
    rig = example_rig()
    noise = np.random.default_rng(5).integers(0, 256, (2, rig.height, rig.width), np.uint8)
    solution = Navigator(rig, unknown(bracket_target()), max_edgels=20000).process(frame_of(noise))
    assert not solution.published
    assert Reason.LIMIT in solution.reasons


def test_one_camera_cannot_start() -> None:
    rig, target = example_rig(), bracket_target()
    left, right = draw_images(rig, target, approach(0))
    for images, missing in (((left, None), Reason.RIGHT_MISSING), ((None, right), Reason.LEFT_MISSING)):
        solution = Navigator(rig, unknown(target)).process(frame_of(images))
        assert not solution.published
        assert solution.reasons == {Reason.UNKNOWN_SIZE, missing}
    one = Rig(rig.cameras[:1], rig.T_world_cam[:1])
    with pytest.raises(InputError, match="two cameras"):
        Navigator(one, unknown(target))


def test_one_view_waits_until_the_size_is_known() -> None:
    rig, target = example_rig(), bracket_target()
    navigator = Navigator(rig, unknown(target))
    shown = [frame for frame, _ in frames(rig, target, 3)]
    assert navigator.process(shown[0]).published
    waiting = navigator.process(one_view(shown[1], 0))
    assert waiting.state is State.COASTING
    assert Reason.UNKNOWN_SIZE in waiting.reasons
    assert navigator.process(shown[2]).published


def test_a_snapshot_of_the_memory_goes_on_to_the_same_bits() -> None:
    rig, target = example_rig(), bracket_target()
    navigator, replay = (Navigator(rig, unknown(target)) for _ in range(2))
    shown = [frame for frame, _ in frames(rig, target, 4)]
    for frame in shown[:2]:
        navigator.process(frame)
    replay.memory = exact.from_json(json.loads(json.dumps(exact.to_json(navigator.memory))))
    for frame in shown[2:]:
        first, second = (without_times(each.process(frame)) for each in (navigator, replay))
        assert first == second
        assert json.loads(first)["dimensions"]["frames"] > 2


def without_times(solution: Solution) -> str:
    return json.dumps({key: value for key, value in solution.to_json().items() if key != "stage_times_s"})


@pytest.mark.parametrize(("name", "numbers"), [("approach", (0, 20, 40)), ("sunlit", (9, 21))])
def test_cold_start_on_rendered_frames(shared_data: Path, name: str, numbers: tuple[int, ...]) -> None:
    sequence = open_sequence(shared_data / "sequences" / name)
    for number in numbers:
        frame = sequence[number]
        solution = Navigator(sequence.rig, unknown(sequence.target)).process(frame)
        assert solution.published, (number, solution.reasons)
        error = pose_error(solution.T_world_target, sequence.truth.at(frame.timestamp_ns))
        assert np.linalg.norm(error[:3]) < 2e-3
        assert np.degrees(np.linalg.norm(error[3:])) < 1.5
        off, sigma = errors_of(solution.dimensions, sequence.target)
        assert (np.abs(off) < 3 * sigma).all()
