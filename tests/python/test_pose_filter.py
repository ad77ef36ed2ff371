"""The constant-velocity filter: exact motion, honest covariance, a plain linear filter as reference, refusals."""

from __future__ import annotations

import numpy as np
import pytest
from pose_scene import Array, pose
from rvdnav.pose import ConstantVelocityFilter, PoseError, difference, make_T, perturb, rotation_angle
from scipy.spatial.transform import Rotation

STEP_NS = 125_000_000
NOISE = np.diag([1e-3, 1e-3, 1e-3, 5e-3, 5e-3, 5e-3]) ** 2
V = np.array([-0.03, 0.01, 0.02])
OMEGA = np.array([0.05, -0.1, 0.2])


def moved(seconds: float) -> Array:
    start = pose()
    R = Rotation.from_rotvec(OMEGA * seconds).as_matrix() @ start[:3, :3]
    return make_T(R, start[:3, 3] + V * seconds)


def run(steps: int, seed: int = 1) -> ConstantVelocityFilter:
    rng = np.random.default_rng(seed)
    tracker = ConstantVelocityFilter()
    for i in range(steps):
        measured = perturb(moved(i * 0.125), rng.multivariate_normal(np.zeros(6), NOISE))
        tracker.update(i * STEP_NS, measured, NOISE)
    return tracker


def test_first_update_is_taken_as_it_is_and_predicts_rest() -> None:
    tracker = ConstantVelocityFilter()
    assert not tracker.initialised
    tracker.update(10, pose(), NOISE)
    assert tracker.initialised
    assert np.array_equal(tracker.smoothed.T_world_target, pose())
    assert np.array_equal(tracker.smoothed.covariance, NOISE)
    predicted = tracker.predict(10 + 2_000_000_000)
    assert np.allclose(predicted.T_world_target, pose())
    # 0.3 m/s and 0.3 rad/s of unknown velocity, 0.05 m/s²/√Hz and 0.1 rad/s²/√Hz of acceleration, over 2 s.
    expected = np.diagonal(NOISE) + (0.3 * 2) ** 2 + np.repeat([0.05**2, 0.1**2], 3) * 8 / 3
    assert np.allclose(np.diagonal(predicted.covariance), expected)


def test_constant_motion_is_learnt_and_predicted() -> None:
    tracker = ConstantVelocityFilter(1e-4, 1e-4)
    for i in range(60):
        tracker.update(i * STEP_NS, moved(i * 0.125), NOISE)
    assert np.allclose(tracker.linear_velocity, V, atol=1e-4)
    assert np.allclose(tracker.angular_velocity, OMEGA, atol=1e-3)
    predicted = tracker.predict(59 * STEP_NS + 3_000_000_000)
    error = difference(predicted.T_world_target, moved(59 * 0.125 + 3.0))
    assert np.linalg.norm(error[:3]) < 5e-4
    assert np.linalg.norm(error[3:]) < 3e-3


def test_smoothing_beats_the_measurements() -> None:
    rng = np.random.default_rng(2)
    tracker = ConstantVelocityFilter(0.005, 0.01)
    raw, smooth = [], []
    for i in range(200):
        truth = moved(i * 0.125)
        measured = perturb(truth, rng.multivariate_normal(np.zeros(6), NOISE))
        tracker.update(i * STEP_NS, measured, NOISE)
        raw.append(difference(measured, truth))
        smooth.append(difference(tracker.smoothed.T_world_target, truth))
    ratio = np.std(smooth[40:], axis=0) / np.std(raw[40:], axis=0)
    assert ratio.max() < 0.8


def test_position_part_is_the_textbook_linear_filter() -> None:
    rng = np.random.default_rng(3)
    tracker = ConstantVelocityFilter(0.05, 0.1)
    x, P, stamp = np.zeros(2), np.zeros((2, 2)), 0
    for i, dt_ns in enumerate([0, 100_000_000, 125_000_000, 900_000_000, 50_000_000]):
        stamp += dt_ns
        z = 1.0 + 0.01 * rng.normal()
        tracker.update(stamp, make_T(np.eye(3), np.array([z, 0.0, 0.0])), NOISE)
        if i == 0:
            x, P = np.array([z, 0.0]), np.diag([NOISE[0, 0], 0.3**2])
            continue
        dt = dt_ns * 1e-9
        F = np.array([[1.0, dt], [0.0, 1.0]])
        x = F @ x
        P = F @ P @ F.T + 0.05**2 * np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])
        K = P[:, 0] / (P[0, 0] + NOISE[0, 0])
        x = x + K * (z - x[0])
        P = P - np.outer(K, P[0])
        assert tracker.smoothed.T_world_target[0, 3] == pytest.approx(x[0], rel=1e-12)
        assert tracker.linear_velocity[0] == pytest.approx(x[1], rel=1e-9)
        assert tracker.smoothed.covariance[0, 0] == pytest.approx(P[0, 0], rel=1e-9)


def test_covariance_grows_while_coasting_and_predicting_changes_nothing() -> None:
    tracker = run(20)
    before = tracker.smoothed
    volumes = [
        np.linalg.eigvalsh(tracker.predict(19 * STEP_NS + int(t * 1e9)).covariance) for t in (0.0, 0.125, 0.5, 1.0, 3.0)
    ]
    assert np.all(np.diff(volumes, axis=0) > 0.0)
    assert np.array_equal(tracker.smoothed.T_world_target, before.T_world_target)
    assert np.array_equal(tracker.predict(19 * STEP_NS).covariance, before.covariance)


def test_covariance_is_honest_under_random_accelerations() -> None:
    rng = np.random.default_rng(4)
    filtered, predicted = [], []
    sub = 25
    h = 0.125 / sub
    for _ in range(40):
        tracker = ConstantVelocityFilter(0.05, 0.1)
        T, rate = pose(), np.concatenate([V, OMEGA])
        for i in range(25):
            if i > 0:
                for _ in range(sub):
                    rate = rate + np.repeat([0.05, 0.1], 3) * np.sqrt(h) * rng.normal(size=6)
                    T = perturb(T, rate * h)
            if i > 5:
                guess = tracker.predict(i * STEP_NS)
                error = difference(T, guess.T_world_target)
                predicted.append(error @ np.linalg.solve(guess.covariance, error) / 6)
            tracker.update(i * STEP_NS, perturb(T, rng.multivariate_normal(np.zeros(6), NOISE)), NOISE)
            if i > 5:
                error = difference(T, tracker.smoothed.T_world_target)
                filtered.append(error @ np.linalg.solve(tracker.smoothed.covariance, error) / 6)
    assert 0.85 < np.mean(filtered) < 1.15
    assert 0.85 < np.mean(predicted) < 1.15


def test_an_axis_known_well_turns_with_the_target() -> None:
    rate = 2.0
    tracker = ConstantVelocityFilter(0.0, 0.0)
    noise = np.eye(6) * 1e-4
    for i in range(200):
        R = Rotation.from_rotvec([0.0, 0.0, rate * i * 0.125]).as_matrix()
        if i == 199:
            noise[3, 3] = 1e-10
        tracker.update(i * STEP_NS, make_T(R, V), noise)
    now = np.diagonal(tracker.smoothed.covariance)
    quarter_turn = np.diagonal(tracker.predict(199 * STEP_NS + round(np.pi / 2 / rate * 1e9)).covariance)
    assert now[3] < 1e-3 * now[4]
    assert quarter_turn[3] > 1e3 * now[3]
    assert quarter_turn[4] < now[4]


def test_a_long_run_keeps_a_rotation_and_a_positive_covariance() -> None:
    tracker = run(300)
    smoothed = tracker.smoothed
    R = smoothed.T_world_target[:3, :3]
    assert np.allclose(R @ R.T, np.eye(3), atol=1e-13)
    assert rotation_angle(R @ moved(299 * 0.125)[:3, :3].T) < 0.03
    assert np.array_equal(smoothed.covariance, smoothed.covariance.T)
    assert np.linalg.eigvalsh(smoothed.covariance)[0] > 0.0


def test_loosening_lets_the_next_pose_decide_the_velocity() -> None:
    second, accurate = 10**9, np.eye(6) * 1e-10
    poses = [make_T(np.eye(3), np.array([1.0 - 0.1 * k, 0.0, 0.0])) for k in range(4)]
    tracker = ConstantVelocityFilter()
    for k, T in enumerate(poses):
        tracker.update(k * second // 8, T, accurate)
    tracker.loosen()
    np.testing.assert_allclose(tracker.linear_velocity, [-0.8, 0.0, 0.0], atol=1e-3)
    assert tracker.predict(second // 2).covariance[0, 0] > (0.3 / 8) ** 2
    tracker.update(second // 2, poses[-1], accurate)
    np.testing.assert_allclose(tracker.linear_velocity, np.zeros(3), atol=0.01)


def test_reset_forgets() -> None:
    tracker = run(5)
    tracker.reset()
    assert not tracker.initialised
    tracker.update(0, pose(), NOISE)
    assert np.array_equal(tracker.linear_velocity, np.zeros(3))


def test_refusals() -> None:
    tracker = ConstantVelocityFilter()
    for call in (lambda: tracker.predict(0), lambda: tracker.smoothed, lambda: tracker.linear_velocity):
        with pytest.raises(PoseError, match="no pose yet"):
            call()
    tracker.update(100, pose(), NOISE)
    with pytest.raises(PoseError, match="backwards"):
        tracker.predict(99)
    with pytest.raises(PoseError, match="backwards"):
        tracker.update(99, pose(), NOISE)
    with pytest.raises(PoseError, match="same timestamp"):
        tracker.update(100, pose(), NOISE)
    with pytest.raises(PoseError, match="positive definite"):
        tracker.update(200, pose(), -NOISE)
    with pytest.raises(ValueError, match="finite"):
        tracker.update(200, pose() * np.nan, NOISE)
    assert np.array_equal(tracker.smoothed.T_world_target, pose())
