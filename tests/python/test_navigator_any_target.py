"""Straight-edged targets that are no bracket, from an initial pose: printed boxes, panels and frames, drawn exactly."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drawn_scene import START_NS, STEP_NS, bracket_target, draw_frame, example_rig, frame_of, pose, wide_rig
from drawn_solid import (
    Surface,
    box_target,
    draw_solid,
    frame_surfaces,
    frame_target,
    panel_surfaces,
    panel_target,
    surfaces,
)
from rvdnav import Navigator, Rig
from rvdnav.errors import InputError
from rvdnav.evaluation import pose_error
from rvdnav.navigator import parse_pose
from rvdnav.pose import perturb
from rvdnav.solution import Mode, Reason, Solution, State
from rvdnav.target import Target
from scipy.spatial.transform import Rotation

Motion = Callable[[int], np.ndarray]


def left_alone(rig: Rig) -> Rig:
    return Rig(rig.cameras[:1], rig.T_world_cam[:1])


def turned(x: float, start: tuple[float, float], step: tuple[float, float]) -> Motion:
    """Coming nearer at 48 mm/s and swaying, turned about y and z: degrees at the start and a frame."""

    def motion(number: int) -> np.ndarray:
        angles = np.array(start) + number * np.array(step)
        T = np.eye(4)
        T[:3, :3] = Rotation.from_euler("yz", angles, degrees=True).as_matrix()
        T[:3, 3] = [x - 0.006 * number, 0.02 * np.sin(number / 6), 0.04 + 0.02 * np.cos(number / 5)]
        return T

    return motion


# Faces come into sight and leave it: the third component of the turn takes the right side away and brings the left one.
TUMBLE = turned(0.75, (20.0, 30.0), (1.5, -3.0))


def follow(
    rig: Rig, target: Target, faces: list[Surface], motion: Motion, frames: int, seed: int = 0
) -> list[tuple[Solution, np.ndarray]]:
    """Solutions and true poses from an initial pose that is off by 0.7 of the deviations that it is believed with."""
    rng = np.random.default_rng(seed)
    off = 0.7 * np.concatenate([rng.normal(0.0, 0.0075, 3), rng.normal(0.0, np.radians(1.5), 3)])
    navigator = Navigator(rig, target, initial_pose=perturb(motion(0), off))
    result = []
    for number in range(frames):
        T = motion(number)
        frame = draw_solid(rig, faces, T, timestamp_ns=START_NS + number * STEP_NS, seed=number)
        result.append((navigator.process(frame), T))
    return result


def errors_of(result: list[tuple[Solution, np.ndarray]]) -> np.ndarray:
    """Position, mm, and attitude errors, degrees, (n, 2) of the published ones; none may lie beyond 5 sigma."""
    errors = []
    for solution, T in result:
        if solution.T_world_target is None:
            continue
        error = pose_error(solution.T_world_target, T)
        assert (np.abs(error) < 5.0 * np.sqrt(np.diag(solution.covariance))).all()
        errors.append([1e3 * np.linalg.norm(error[:3]), np.degrees(np.linalg.norm(error[3:]))])
    return np.array(errors)


def test_one_camera_follows_a_printed_box_round() -> None:
    target = box_target()
    result = follow(left_alone(example_rig()), target, surfaces(target), TUMBLE, 24)
    errors = errors_of(result)
    assert len(errors) >= 23
    assert result[0][0].state is State.TRACKING
    assert {solution.mode for solution, _ in result if solution.published} == {Mode.MONO_LEFT}
    assert errors.max(axis=0)[0] < 1.0
    assert errors.max(axis=0)[1] < 0.4
    assert np.median(errors, axis=0)[0] < 0.2
    assert np.median(errors, axis=0)[1] < 0.06
    # The edges that were used change with the faces in sight.
    used = [{r.edge for r in solution.line_residuals if r.used} for solution, _ in result if solution.published]
    assert len(set.union(*used)) > max(len(edges) for edges in used)


def test_two_cameras_follow_a_printed_box() -> None:
    target = box_target((0.1, 0.16, 0.22))
    result = follow(wide_rig(), target, surfaces(target, 8), turned(0.8, (-25.0, 10.0), (-2.0, 3.0)), 10)
    errors = errors_of(result)
    assert len(errors) >= 9
    assert errors.max(axis=0)[0] < 0.6
    assert errors.max(axis=0)[1] < 0.2


def test_one_camera_keeps_to_a_box_that_speeds_up() -> None:
    """Up to 0.8 m/s² along the line of sight, far beyond what the filter expects; its prints shrink it by a tenth."""
    target = box_target((0.22, 0.3, 0.26))

    def motion(number: int) -> np.ndarray:
        u = number / 11.0
        u = 0.5 * u + 0.5 * u * u * (3.0 - 2.0 * u)
        return pose(1.4 - 0.5 * u, -0.05 + 0.1 * u, 0.08 - 0.14 * u, 15 + 15 * u, 25 + 40 * u, 10 - 20 * u)

    errors = errors_of(follow(left_alone(example_rig()), target, surfaces(target), motion, 8))
    assert len(errors) >= 7
    assert errors.max(axis=0)[0] < 1.5
    assert errors.max(axis=0)[1] < 0.3


@pytest.mark.parametrize("start", [(15.0, -20.0), (15.0, 150.0)], ids=["front", "behind"])
@pytest.mark.parametrize("shape", ["panel", "frame"])
def test_panels_and_frames_are_followed_from_both_sides(shape: str, start: tuple[float, float]) -> None:
    target = panel_target() if shape == "panel" else frame_target()
    faces = panel_surfaces(target) if shape == "panel" else frame_surfaces(target)
    errors = errors_of(follow(example_rig(), target, faces, turned(0.7, start, (1.0, 1.5)), 5))
    assert len(errors) >= 4
    assert errors.max(axis=0)[0] < 1.0
    assert errors.max(axis=0)[1] < 0.4


def test_a_pose_far_off_or_a_box_of_another_size_is_not_published() -> None:
    rig, target = example_rig(), box_target()
    faces, T = surfaces(target), TUMBLE(2)
    larger = box_target((0.176, 0.132, 0.22))
    frames = [draw_solid(rig, faces, TUMBLE(2), timestamp_ns=START_NS + i * STEP_NS, seed=i) for i in range(2)]
    for model, off in (
        (target, [0.0, 0.05, 0.0, 0.0, 0.0, 0.0]),
        (target, [0.0, 0.0, 0.0, 0.0, 0.25, 0.2]),
        (target, [0.06, 0.0, 0.03, 0.0, 0.0, 0.1]),
        (larger, [0.0] * 6),
    ):
        navigator = Navigator(rig, model, initial_pose=perturb(T, np.array(off)))
        for frame in frames:
            solution = navigator.process(frame)
            assert solution.T_world_target is None or np.abs(pose_error(solution.T_world_target, T)).max() < 0.005
        assert model is target or solution.T_world_target is None


def test_without_a_pose_it_says_that_it_needs_one() -> None:
    rig, target = example_rig(), box_target()
    faces = surfaces(target)
    frames = [draw_solid(rig, faces, TUMBLE(i), timestamp_ns=START_NS + i * STEP_NS, seed=i) for i in range(2)]
    solution = Navigator(rig, target).process(frames[0])
    assert (solution.state, solution.reasons) == (State.SEARCHING, {Reason.NO_PRIOR})
    navigator = Navigator(rig, target, initial_pose=TUMBLE(0), coast_seconds=0.3)
    empty = np.random.default_rng(1).integers(0, 60, (2, rig.height, rig.width), np.uint8)
    stamps = START_NS + np.array([0, 1, 2, 4, 5]) * STEP_NS
    states = [navigator.process(frames[0]).state]
    states += [navigator.process(frame_of(np.roll(empty, i, axis=2), int(stamps[i]))).state for i in range(1, 4)]
    assert states == [State.TRACKING, State.COASTING, State.COASTING, State.LOST]
    solution = navigator.process(draw_solid(rig, faces, TUMBLE(5), timestamp_ns=int(stamps[4])))
    assert (solution.state, solution.reasons) == (State.SEARCHING, {Reason.NO_PRIOR})


def test_a_bracket_is_found_in_spite_of_a_wrong_initial_pose() -> None:
    rig, target, T = example_rig(), bracket_target(), pose(0.8, 0.01, 0.06, 3.0, -4.0, 2.0)
    frame = draw_frame(rig, target, T)
    for off in (np.zeros(6), np.array([0.004, 0.003, -0.004, 0.01, 0.01, -0.01]), np.array([0.1, 0.1, 0.0, 0, 0.5, 0])):
        solution = Navigator(rig, target, initial_pose=perturb(T, off)).process(frame)
        assert np.linalg.norm(pose_error(solution.T_world_target, T)[:3]) < 0.0005


def test_a_bracket_with_faces_is_measured_alike_and_not_from_behind() -> None:
    rig, plain, T = example_rig(), bracket_target(), pose(0.7, 0.01, 0.05, 5.0, 8.0, -3.0)
    bars = [(f"P{i}", f"P{i % 4 + 1}", f"Q{i % 4 + 1}", f"Q{i}") for i in range(1, 5)]
    frame = draw_frame(rig, plain, T)
    found = []
    for faces in ((), bars, [bar[::-1] for bar in bars]):
        target = Target("faces", plain.points, plain.lines, plain.bars, plain.bar_thickness, faces=faces)
        found.append(Navigator(rig, target).process(frame).T_world_target)
    # Of the two ways round, one is that of bars which look away from the cameras.
    assert sum(pose is None for pose in found) == 1
    without, with_faces = (pose for pose in found if pose is not None)
    np.testing.assert_array_equal(with_faces, without)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("1 0 0 0 0 0", "6 numbers"),
        ("1 0 0 0 0 0 one", "not numbers"),
        ("1 0 nan 0 0 0 1", "not finite"),
        ("1 0 0 0 0 0 1.01", "length 1.01"),
        ("1 0 0 0 0 0 0", "length 0"),
    ],
)
def test_bad_initial_poses_are_refused(text: str, fault: str) -> None:
    with pytest.raises(InputError, match=fault):
        parse_pose(text)


def test_an_initial_pose_is_read_as_written_and_must_lie_before_the_cameras() -> None:
    T = parse_pose("0.9 0.01 -0.02  0 0 0.70710678 0.70710678")
    np.testing.assert_allclose(T[:3, :3], Rotation.from_euler("z", 90, degrees=True).as_matrix(), atol=1e-7)
    np.testing.assert_array_equal(T[:3, 3], [0.9, 0.01, -0.02])
    with pytest.raises(InputError, match="in front of the cameras"):
        Navigator(example_rig(), bracket_target(), initial_pose=parse_pose("-0.9 0 0 0 0 0 1"))
    with pytest.raises(InputError, match="rotation"):
        Navigator(example_rig(), bracket_target(), initial_pose=np.diag([1.1, 1.0, 1.0, 1.0]))


def test_more_edge_pixels_than_the_core_takes() -> None:
    target, T = box_target(), TUMBLE(0)
    navigator = Navigator(example_rig(), target, initial_pose=T, max_edgels=2000)
    assert navigator.process(draw_solid(example_rig(), surfaces(target), T, timestamp_ns=START_NS)).published
