"""Errors, bins and consistency figures against hand-made truths."""

import numpy as np
import pytest
from rvdnav.errors import InputError
from rvdnav.evaluation import evaluate, pose_error
from rvdnav.solution import Mode, Solution, State
from scipy.spatial.transform import Rotation
from solutions import Truth, transform


def published(timestamp_ns, T, covariance=None):
    return Solution(
        timestamp_ns=timestamp_ns,
        state=State.TRACKING,
        mode=Mode.STEREO,
        T_world_target=T,
        covariance=np.eye(6) * 1e-6 if covariance is None else covariance,
    )


def searching(timestamp_ns):
    return Solution(timestamp_ns=timestamp_ns, state=State.SEARCHING)


def test_the_errors_of_one_frame():
    true = transform([1.2, 0.0, 0.0], [0.3, -0.1, 0.2])
    extra = np.radians([0.0, 0.0, 1.5])
    measured = true.copy()
    measured[:3, 3] += [0.003, 0.004, 0.0]
    measured[:3, :3] = Rotation.from_rotvec(extra).as_matrix() @ true[:3, :3]
    result = evaluate([published(7, measured, np.eye(6) * 1.44e-6)], Truth({7: true}))
    assert result.position_m == pytest.approx([0.005])
    assert np.degrees(result.attitude_rad) == pytest.approx([1.5])
    assert result.ranges_m == pytest.approx([1.2])
    np.testing.assert_allclose(result.components[0], [0.003, 0.004, 0, *extra], atol=1e-12)
    expected_nees = (9e-6 + 16e-6 + np.radians(1.5) ** 2) / 1.44e-6
    assert result.nees == pytest.approx([expected_nees])
    assert result.mean_nees_ratio == pytest.approx(expected_nees / 6)
    np.testing.assert_array_equal(result.within_3_sigma, [1, 0, 1, 1, 1, 0])  # 3 sigma is 3.6 mm, 0.2 deg
    assert list(result.timestamps_ns) == [7]


def test_the_error_is_in_the_world_not_in_the_target():
    true = transform([0, 0, 1], [0, 0, np.pi / 2])
    measured = true @ transform([0, 0, 0], [0.01, 0, 0])  # about x_C, which is y_W here
    np.testing.assert_allclose(pose_error(measured, true), [0, 0, 0, 0, 0.01, 0], atol=1e-12)


def test_nees_uses_the_full_covariance():
    rng = np.random.default_rng(4)
    root = rng.normal(size=(6, 6)) * 1e-3
    covariance = root @ root.T + np.eye(6) * 1e-8
    true = transform([0.7, 0, 0])
    error = np.array([1e-3, -2e-3, 5e-4, 2e-3, 1e-3, -1e-3])
    measured = transform(true[:3, 3] + error[:3], error[3:])
    result = evaluate([published(0, measured, covariance)], Truth({0: true}))
    assert result.nees[0] == pytest.approx(error @ np.linalg.inv(covariance) @ error)


def test_bins_split_at_their_lower_limits_and_count_unpublished_frames():
    ranges = [0.3, 0.5, 0.79, 0.8, 1.09, 1.1, 1.5]
    truth = Truth({i: transform([r, 0, 0]) for i, r in enumerate(ranges)})
    solutions = [published(i, transform([r + 0.001 * (i + 1), 0, 0])) for i, r in enumerate(ranges)]
    solutions[2] = searching(2)
    result = evaluate(solutions, truth)
    assert [(row.frames, row.published) for row in result.rows] == [(1, 1), (2, 1), (2, 2), (2, 2)]
    assert [row.name for row in result.rows] == ["< 0.5 m", "0.5-0.8 m", "0.8-1.1 m", ">= 1.1 m"]
    assert (result.overall.frames, result.overall.published, result.overall.name) == (7, 6, "all")
    assert result.published_fraction == pytest.approx(6 / 7)
    position = result.rows[2].position_m
    assert (position.median, position.max) == (pytest.approx(0.0045), pytest.approx(0.005))
    assert position.p95 == pytest.approx(0.00495)


def test_wrong_allows_more_attitude_error_farther_away_and_the_paper_does_not():
    # 2 deg * (1 + range): 2.6 deg at 0.3 m, 5 deg at 1.5 m.
    cases = [(0.3, 0.0, 2.5, False), (0.3, 0.0, 2.7, True), (1.5, 0.0, 4.9, False), (1.5, 0.0, 5.1, True)]
    cases += [(1.5, 0.0199, 0.0, False), (1.5, 0.0201, 0.0, True)]
    truth, solutions = Truth(), []
    for i, (distance, offset, degrees, _) in enumerate(cases):
        truth[i] = transform([distance, 0, 0])
        solutions.append(published(i, transform([distance, offset, 0], [np.radians(degrees), 0, 0])))
    result = evaluate(solutions, truth)
    assert result.wrong.tolist() == [case[3] for case in cases]
    assert result.within_paper_limits == pytest.approx(1 / 6)


def test_honest_errors_have_a_nees_of_six():
    rng = np.random.default_rng(11)
    root = rng.normal(size=(6, 6)) * 1e-4
    covariance = root @ root.T
    truth, solutions = Truth(), []
    for i in range(600):
        error = root @ rng.normal(size=6)
        truth[i] = transform([0.6, 0.1, 0.2], [0.2, 0.1, -0.1])
        measured = truth[i].copy()
        measured[:3, 3] += error[:3]
        measured[:3, :3] = Rotation.from_rotvec(error[3:]).as_matrix() @ measured[:3, :3]
        solutions.append(published(i, measured, covariance))
    result = evaluate(solutions, truth)
    assert result.mean_nees_ratio == pytest.approx(1.0, abs=0.07)
    assert (result.within_3_sigma > 0.985).all()


def test_frames_without_truth_are_not_judged():
    result = evaluate([published(1, np.eye(4)), published(2, np.eye(4))], Truth({2: transform([0.1, 0, 0])}))
    assert (result.frames, result.published) == (1, 1)


def test_nothing_published_is_a_result_and_no_truth_is_an_error():
    result = evaluate([searching(0)], Truth({0: np.eye(4)}))
    assert (result.published, result.published_fraction) == (0, 0.0)
    assert result.overall.position_m is None
    assert np.isnan(result.mean_nees_ratio)
    assert np.isnan(result.within_3_sigma).all()
    assert np.isnan(result.within_paper_limits)
    with pytest.raises(InputError, match="no frame"):
        evaluate([searching(0)], Truth())
