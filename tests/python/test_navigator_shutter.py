"""A rolling shutter that rig.yaml states: poses are of the stamp, whatever row shows the target."""

import attrs
import numpy as np
import pytest
from drawn_scene import START_NS, STEP_NS, bracket_target, draw_images, example_rig, frame_of, pose
from rvdnav import Navigator
from rvdnav.evaluation import pose_error
from rvdnav.pose import perturb

LINE_DELAY_NS = 30_000
VELOCITY = np.array([-0.10, 0.12, 0.05, 0.05, -0.1, 0.08])
BANDS = 24
FRAMES = 6


def rolling_frame(rig, target, number):
    """The bands of both images, each as it was at the exposure of its middle row; and the pose at the stamp."""
    seconds = number * STEP_NS * 1e-9
    start = perturb(pose(0.7, -0.02, 0.03, 2.0, -6.0, 4.0), VELOCITY * seconds)
    images = [np.zeros((rig.height, rig.width), np.uint8) for _ in range(2)]
    rows = np.array_split(np.arange(rig.height), BANDS)
    for band in rows:
        T = perturb(start, VELOCITY * (LINE_DELAY_NS * 1e-9 * band.mean()))
        for image, drawn in zip(images, draw_images(rig, target, T, seed=number), strict=True):
            image[band] = drawn[band]
    return frame_of(tuple(images), START_NS + number * STEP_NS), start


@pytest.fixture(scope="module")
def errors():
    """Of a rig that says so, and of one that doesn't: the solutions' errors (6,), and their standard deviations."""
    target = bracket_target()
    silent = example_rig()
    rigs = (attrs.evolve(silent, line_delay_ns=LINE_DELAY_NS), silent)
    navigators = [Navigator(rig, target) for rig in rigs]
    result = [[], []]
    for number in range(FRAMES):
        frame, T = rolling_frame(silent, target, number)
        for navigator, kept in zip(navigators, result, strict=True):
            solution = navigator.process(frame)
            if solution.published:
                error = pose_error(solution.T_world_target, T)
                kept.append((error, np.sqrt(np.diag(solution.covariance))))
    return result


def test_poses_are_of_the_stamp(errors):
    stated, silent = errors
    assert len(stated) == FRAMES
    position = [1e3 * np.linalg.norm(error[:3]) for error, _ in stated[2:]]
    assert max(position) < 0.5
    # Without the statement the target is where it was some rows later.
    later = 1e3 * np.linalg.norm(VELOCITY[:3]) * LINE_DELAY_NS * 1e-9 * 0.5 * example_rig().height
    assert min(1e3 * np.linalg.norm(error[:3]) for error, _ in silent[2:]) > 0.7 * later
    assert max(position) < 0.4 * later


def test_an_unknown_motion_is_in_the_covariance(errors):
    first, second = errors[0][0], errors[0][-1]
    assert (np.abs(first[0]) < 4.0 * first[1]).all()
    assert (np.abs(second[0]) < 4.0 * second[1]).all()
    assert first[1][0] > 2.0 * second[1][0]
