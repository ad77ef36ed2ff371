"""What tracking must survive: a bracket partly out of view, an arm before it, jumps in light, lost frames."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from drawn_scene import START_NS, STEP_NS, bracket_target, draw_images, example_rig, frame_of, pose, wide_rig
from rvdnav import Navigator, Rig, Solution
from rvdnav.evaluation import pose_error
from rvdnav.solution import State

TARGET = bracket_target()
Images = tuple[np.ndarray, np.ndarray]


def check(solution: Solution, T: np.ndarray) -> None:
    """A published pose is right to half a millimetre and within five standard deviations."""
    error = pose_error(solution.T_world_target, T)
    assert np.linalg.norm(error[:3]) < 0.5e-3
    assert np.degrees(np.linalg.norm(error[3:])) < 0.3
    assert (np.abs(error) < 5.0 * np.sqrt(np.diag(solution.covariance))).all()


def apexes_in_image(rig: Rig, camera: int, T: np.ndarray) -> int:
    points = np.concatenate([TARGET.bracket.outer, TARGET.bracket.inner]) @ T[:3, :3].T + T[:3, 3]
    uv = rig.project(camera, points)
    return int(((uv > 0.0) & (uv < (rig.width - 1, rig.height - 1))).all(axis=1).sum())


@pytest.mark.parametrize(
    ("rig", "offset", "least"),
    [(example_rig, (-0.05, 0.08), 4), (example_rig, (0.07, -0.09), 4), (wide_rig, (0.06, -0.06), 5)],
)
def test_from_the_whole_to_a_part(rig: Callable[[], Rig], offset: tuple[float, float], least: int) -> None:
    """From 0.5 m to 0.28 m, until a view holds no more than so many of the eight apexes."""
    rig = rig()
    navigator = Navigator(rig, TARGET)
    seen = 8
    for number in range(12):
        T = pose(0.5 - 0.02 * number, *offset, 3.0 - 0.3 * number, 4.0 - 0.4 * number, 2.0)
        images = draw_images(rig, TARGET, T, seed=number)
        solution = navigator.process(frame_of(images, START_NS + number * STEP_NS))
        assert solution.state is State.TRACKING, (number, solution.reasons)
        check(solution, T)
        seen = min(seen, *(apexes_in_image(rig, camera, T) for camera in (0, 1)))
    assert seen <= least


def with_arm(rig: Rig, images: Images, T: np.ndarray, *, part: tuple[float, float]) -> Images:
    """A dark arm from the upper border over a part of the bracket's width, in both images."""
    points = TARGET.bracket.outer @ T[:3, :3].T + T[:3, 3]
    covered = []
    for camera, image in enumerate(images):
        u, v = rig.project(camera, points).T
        left, right = (int(u.min() + share * np.ptp(u)) for share in part)
        arm = np.random.default_rng(3).normal(60.0, 1.5, image.shape)
        image = image.copy()
        image[: int(v.max()) + 5, left:right] = arm[: int(v.max()) + 5, left:right]
        covered.append(image)
    return covered[0], covered[1]


@pytest.mark.parametrize("part", [(-0.05, 0.33), (0.33, 0.66), (0.7, 1.05)])
def test_an_arm_over_a_third_of_the_bracket(part: tuple[float, float]) -> None:
    """Right poses or none, coasting on a growing covariance, and a pose again within three frames after it is gone."""
    rig = example_rig()
    navigator = Navigator(rig, TARGET)
    sigmas: list[float] = []
    for number in range(13):
        T = pose(0.8 - 0.02 * number, 0.01, 0.05, 2.0, 4.0, -2.0)
        images = draw_images(rig, TARGET, T, seed=number)
        hidden = 4 <= number < 9
        if hidden:
            images = with_arm(rig, images, T, part=part)
        solution = navigator.process(frame_of(images, START_NS + number * STEP_NS))
        if solution.published:
            sigmas.clear()
            check(solution, T)
        else:
            assert solution.state is State.COASTING
            sigmas.append(float(np.trace(solution.covariance)))
            assert sigmas == sorted(sigmas)
        assert solution.published or 4 <= number < 11


@pytest.mark.parametrize("gains", [(1.0, 0.35, 0.35, 1.0), (1.0, 1.6, 0.5, 1.6)])
def test_jumps_in_light(gains: tuple[float, ...]) -> None:
    rig = example_rig()
    navigator = Navigator(rig, TARGET)
    for number in range(12):
        T = pose(0.9 - 0.03 * number, 0.01, 0.05, 2.0, 4.0, -2.0)
        gain = gains[number // 3]
        images = [
            np.clip(np.round(gain * image), 0, 255).astype(np.uint8)
            for image in draw_images(rig, TARGET, T, seed=number)
        ]
        solution = navigator.process(frame_of(images, START_NS + number * STEP_NS))
        assert solution.published, (number, solution.reasons)
        check(solution, T)


def test_frames_that_never_come() -> None:
    rig = example_rig()
    navigator = Navigator(rig, TARGET)
    for number in (0, 1, 2, 3, 7, 8, 16, 17):
        T = pose(0.9 - 0.02 * number, 0.01, 0.05, 2.0, 4.0, -2.0)
        images = draw_images(rig, TARGET, T, seed=number)
        solution = navigator.process(frame_of(images, START_NS + number * STEP_NS))
        assert solution.published, (number, solution.reasons)
        check(solution, T)
