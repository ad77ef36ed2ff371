"""One camera: after stereo, from a cold start, with a rig of one camera, and the two poses that one view leaves."""

from __future__ import annotations

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
from readable_navigator.sampling import sample_edges
from rvdnav import Frame, Navigator, Rig, Solution, open_sequence
from rvdnav.core import Core
from rvdnav.evaluation import pose_error
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.navigator.knowledge import Knowledge, Learned
from rvdnav.navigator.measurement import measure
from rvdnav.navigator.two_fold import decide
from rvdnav.pose import PredictedPose, inverse_T, make_T
from rvdnav.solution import Mode, Reason, State
from rvdnav.target import Target
from scipy.spatial.transform import Rotation

TARGET = bracket_target()
SMALL = bracket_target(0.09, 0.055, 0.07, 0.01)
"""So small that from afar one view can hardly tell which way it is tilted."""
MODES = (Mode.MONO_LEFT, Mode.MONO_RIGHT)


def blinded(frame: Frame, camera: int) -> Frame:
    """The frame with the images of one camera alone."""
    return attrs.evolve(frame, left=frame.left if camera == 0 else None, right=frame.right if camera == 1 else None)


def errors_of(solution: Solution, T: np.ndarray) -> tuple[float, float, float]:
    """mm, degrees, and the largest component in its standard deviations."""
    error = pose_error(solution.T_world_target, T)
    sigmas = np.sqrt(np.diag(solution.covariance))
    return (
        1e3 * float(np.linalg.norm(error[:3])),
        float(np.degrees(np.linalg.norm(error[3:]))),
        float(np.abs(error / sigmas).max()),
    )


@pytest.mark.parametrize("camera", [0, 1])
@pytest.mark.parametrize("rig", [example_rig, wide_rig])
def test_goes_on_with_one_camera_when_the_other_is_lost(rig, camera: int) -> None:
    rig = rig()
    navigator = Navigator(rig, TARGET)
    for number in range(10):
        T = pose(0.8 - 0.04 * number, 0.01, 0.05, 8.0 - number, -9.0 + number, 2.0)
        frame = draw_frame(rig, TARGET, T, timestamp_ns=START_NS + number * STEP_NS, seed=number)
        solution = navigator.process(blinded(frame, camera) if number >= 2 else frame)
        assert solution.state is State.TRACKING
        assert solution.mode is (Mode.STEREO if number < 2 else MODES[camera])
        position, attitude, deviations = errors_of(solution, T)
        assert position < 1.0
        assert attitude < 0.5
        assert deviations < 4.0


def test_goes_on_with_one_camera_when_the_target_leaves_the_other_image() -> None:
    """Both images arrive all along, but in the end the right one shows the surroundings alone: that is one view."""
    rig = example_rig()
    navigator = Navigator(rig, SMALL)
    modes = []
    for number in range(9):
        T = pose(0.45, 0.0, 0.1 + 0.021 * number, 3.0, 10.0, 1.0)
        solution = navigator.process(draw_frame(rig, SMALL, T, timestamp_ns=START_NS + number * STEP_NS, seed=number))
        assert solution.state is State.TRACKING
        assert errors_of(solution, T)[2] < 4.0
        u = rig.project(1, SMALL.bracket.outer @ T[:3, :3].T + T[:3, 3])[:, 0]
        modes.append((solution.mode, bool((u > 0.0).any())))
    assert modes[0] == (Mode.STEREO, True)
    assert modes[-1] == (Mode.MONO_LEFT, False)
    assert all(seen for mode, seen in modes if mode is Mode.STEREO)


def test_starts_with_one_camera() -> None:
    """A tilted bracket in the left view alone: perspective tells which way it is tilted."""
    rig = example_rig()
    T = pose(0.5, 0.01, 0.06, 14.0, 16.0, -2.0)
    solution = Navigator(rig, TARGET).process(blinded(draw_frame(rig, TARGET, T), 0))
    assert solution.mode is Mode.MONO_LEFT
    assert solution.reasons == {Reason.RIGHT_MISSING}
    assert solution.acquisition.score > 0.5
    position, attitude, deviations = errors_of(solution, T)
    assert position < 1.0
    assert attitude < 0.5
    assert deviations < 4.0


def test_a_rig_of_one_camera_anywhere_in_the_world() -> None:
    stereo = example_rig()
    T_world_cam = make_T(
        Rotation.from_euler("xyz", [20, -30, 70], degrees=True).as_matrix(), np.array([0.3, -0.2, 0.5])
    )
    navigator = Navigator(Rig(stereo.cameras[:1], [T_world_cam]), TARGET)
    for number in range(3):
        seen = pose(0.7 - 0.03 * number, 0.01, 0.06, 12.0, 9.0, -2.0)
        T = T_world_cam @ inverse_T(stereo.T_world_cam[0]) @ seen
        left, _ = draw_images(stereo, TARGET, seen, seed=number)
        solution = navigator.process(frame_of((left, None), START_NS + number * STEP_NS))
        assert solution.mode is Mode.MONO_LEFT
        assert not solution.reasons
        assert errors_of(solution, T)[0] < 1.0


@pytest.mark.parametrize("tilt", [-12.0, 8.0])
def test_a_mirror_image_is_found_and_given_its_weight(tilt: float) -> None:
    """Far away and tilted either tilt explains the image; a prediction tells, and nothing else."""
    rig, model = example_rig(), EdgeModel.of_bracket(SMALL.bracket)
    cameras = rectified_cameras(rig)
    T = pose(1.4, 0.0, 0.05, 1.5, tilt, 0.0)
    left, _ = draw_images(rig, SMALL, T, look=Look(clutter=False, thick=False))
    knowledge = Knowledge(rig, model)
    learned, unknown = Learned.nothing(knowledge.lasting), np.zeros((2, 8), np.int64)
    measurement = measure(Core(rig, SMALL), rig, model, knowledge, learned, (left, None), T, unknown)
    undecided = decide(measurement, model, cameras, None, None)
    assert undecided.rival is not None
    assert undecided.rival_probability > 0.01
    # The rival is tilted the other way about the line of sight, and seen at almost the same place.
    poses = (undecided.T_world_target, undecided.rival)
    middle = T[:3, :3] @ SMALL.bracket.outer.mean(axis=0) + T[:3, 3]
    sight = middle - rig.T_world_cam[0][:3, 3]
    away = [np.cross(A[:3, 0], sight) for A in poses]
    assert away[0] @ away[1] < 0.0
    seen = [rig.project(0, SMALL.bracket.outer @ A[:3, :3].T + A[:3, 3]) for A in poses]
    assert np.abs(seen[0] - seen[1]).max() < 1.0
    # Its part widens the covariance along the way to it.
    widened = undecided.widened(measurement).pose.covariance
    apart = pose_error(undecided.rival, measurement.pose.T_world_target)
    assert (np.linalg.eigvalsh(widened - measurement.pose.covariance) > -1e-12).all()
    assert apart @ np.linalg.solve(widened, apart) < 1.0 / undecided.rival_probability + 1e-6

    sure = np.diag([0.01, 0.01, 0.01, 0.02, 0.02, 0.02]) ** 2
    true = min(poses, key=lambda A: errors(A, T))
    other = max(poses, key=lambda A: errors(A, T))
    for predicted in (true, other):
        decision = decide(measurement, model, cameras, PredictedPose(predicted, sure), None)
        assert errors(decision.T_world_target, predicted) < 1e-6
        # Where earlier frames were undecided their odds count for the prediction's side, whichever it is.
        biased = decide(measurement, model, cameras, PredictedPose(predicted, sure), 30.0)
        assert errors(biased.T_world_target, predicted) < 1e-6
        assert biased.log_odds > 10.0
    # From a prediction that foresaw neither nothing is learnt.
    astray = PredictedPose(make_T(other[:3, :3], other[:3, 3] + [0.0, 0.2, 0.0]), 0.1 * sure)
    for earlier_odds in (None, 30.0):
        decision = decide(measurement, model, cameras, astray, earlier_odds)
        assert errors(decision.T_world_target, undecided.T_world_target) < 1e-6
        assert decision.log_odds == pytest.approx(undecided.log_odds, abs=0.1)


def test_a_view_of_noise_alone_vouches_for_nothing() -> None:
    """In each window some step of the noise is the steepest; together they show no edge."""
    rig, model = example_rig(), EdgeModel.of_bracket(TARGET.bracket)
    T = pose(0.5, 0.01, 0.06, 4.0, 6.0, -2.0)
    _, right = draw_images(rig, TARGET, T)
    noise = np.random.default_rng(3).normal(60.0, 40.0, right.shape).clip(0, 255).astype(np.uint8)
    knowledge = Knowledge(rig, model)
    learned, unknown = Learned.nothing(knowledge.lasting), np.zeros((2, 8), np.int64)
    core = Core(rig, TARGET)
    sampled = sample_edges(core, rig, (noise, right), T, model, 2.5, unknown)
    found = sampled.count(np.ones(len(sampled.camera), np.bool_)) / sampled.attempted
    assert found[0].mean() > 0.3
    measurement = measure(core, rig, model, knowledge, learned, (noise, right), T, unknown)
    assert (measurement.coverage[0] == 0.0).all()
    assert measurement.coverage[1].mean() > 0.9


def errors(A: np.ndarray, B: np.ndarray) -> float:
    return float(np.degrees(np.linalg.norm(pose_error(A, B)[3:])))


def test_what_one_view_cannot_tell_is_not_published_until_later_frames_do() -> None:
    """From far AMBIGUOUS with both poses; nearer, perspective decides and the pose is right."""
    rig = example_rig()
    navigator = Navigator(rig, SMALL)
    published, ambiguous = [], 0
    for number in range(20):
        T = pose(1.2 - 0.04 * number, 0.0, 0.05, 1.5, -12.0, 0.0)
        frame = draw_frame(rig, SMALL, T, timestamp_ns=START_NS + number * STEP_NS, seed=number)
        solution = navigator.process(blinded(frame, 0))
        published.append(solution.published)
        if solution.published:
            check_not_wrong(solution, T)
        elif Reason.AMBIGUOUS in solution.reasons:
            ambiguous += 1
            assert solution.state is not State.TRACKING
            assert solution.rival_T_world_target is not None
    assert ambiguous >= 2
    assert all(published[-4:])


def check_not_wrong(solution: Solution, T: np.ndarray) -> None:
    position, attitude, deviations = errors_of(solution, T)
    assert position < 20.0
    assert attitude < 2.0 * (1.0 + T[0, 3])
    assert deviations < 5.0


@pytest.mark.parametrize("target", [TARGET, SMALL])
def test_frames_of_one_view_at_all_tilts_are_never_wrong(target: Target) -> None:
    rig = example_rig()
    rng = np.random.default_rng(5)
    published = 0
    for number in range(16):
        distance = rng.uniform(0.4, 1.4) * (1.0 if target is TARGET else 0.5)
        T = pose(distance, *rng.uniform(-0.02, 0.06, 2), *rng.uniform(-20.0, 20.0, 2), rng.uniform(-20, 20))
        solution = Navigator(rig, target).process(blinded(draw_frame(rig, target, T, seed=number), number % 2))
        if solution.published:
            published += 1
            check_not_wrong(solution, T)
    assert published >= 8


@pytest.mark.parametrize("camera", [0, 1])
def test_a_rendered_approach_with_one_camera(shared_data: Path, camera: int) -> None:
    """Started by stereo at 0.8 m and then blinded."""
    sequence = open_sequence(shared_data / "sequences" / "approach")
    navigator = Navigator(sequence.rig, sequence.target)
    found = []
    for number in range(23, 34):
        frame = sequence[number]
        solution = navigator.process(frame if number < 25 else blinded(frame, camera))
        assert solution.published, (number, solution.reasons)
        if number >= 25:
            found.append(errors_of(solution, sequence.truth.at(frame.timestamp_ns)))
    position, attitude, deviations = np.array(found).T
    assert np.median(position) < 0.3
    assert np.median(attitude) < 0.2
    assert deviations.max() < 5.0
