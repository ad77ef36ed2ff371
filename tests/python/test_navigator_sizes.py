"""What frames add up to: the information filter over a bracket's sizes."""

from __future__ import annotations

import numpy as np
import pytest
from rvdnav.navigator.sizes import Sizes

TRUTH = np.array([0.18, 0.09, 0.14, 0.014, 0.013, 0.015])
SIGMA = np.array([3e-4, 2e-4, 4e-4, 1e-4, 2e-4, 1e-4])
NO_PIXEL = 0.0


def frame(error: np.ndarray, scale: float = 1.0) -> Sizes:
    return Sizes.of(TRUTH + error, np.diag((scale * SIGMA) ** 2), NO_PIXEL)


def test_the_mean_weighs_by_information() -> None:
    both = frame(np.full(6, 1e-4)).combined(frame(np.full(6, -1e-4), scale=0.5))
    np.testing.assert_allclose(both.mean, TRUTH + (1e-4 - 4e-4) / 5.0, atol=1e-9)
    assert both.frames == 2


def test_many_frames_do_not_average_away_what_they_share() -> None:
    sizes = frame(np.zeros(6))
    one = np.sqrt(np.diag(sizes.covariance))
    for _ in range(400):
        sizes = sizes.combined(frame(np.zeros(6)))
    many = np.sqrt(np.diag(sizes.covariance))
    assert (many > 0.5 * SIGMA).all()
    assert (many < one).all()


def test_near_frames_are_surer_whatever_came_before() -> None:
    far = frame(np.zeros(6), scale=10.0)
    for _ in range(20):
        far = far.combined(frame(np.zeros(6), scale=10.0))
    assert (np.diag(far.combined(frame(np.zeros(6))).covariance) < 0.2 * np.diag(far.covariance)).all()


def test_known_after_three_good_frames() -> None:
    sizes = frame(np.zeros(6))
    assert not sizes.known
    assert sizes.combined(frame(np.zeros(6))).combined(frame(np.zeros(6))).known
    vague = frame(np.zeros(6), scale=5.0)
    assert not vague.combined(vague).combined(vague).known


def test_another_bracket_is_not_admitted() -> None:
    sizes = frame(np.zeros(6))
    assert sizes.admits(frame(2 * SIGMA))
    assert not sizes.admits(frame(np.array([5e-3, 0, 0, 0, 0, 0])))


def test_the_report_is_in_metres_by_name() -> None:
    report = frame(np.zeros(6)).report()
    assert report.sizes_m["leg_width"] == pytest.approx(0.015)
    assert report.sigmas_m["height"] > 4e-4
    assert (report.frames, report.known) == (1, False)
