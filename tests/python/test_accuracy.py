"""What is promised of rendered sequences, on a few frames each; bench/fault_table.py has the whole table."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import attrs
import numpy as np
import pytest
from rvdnav import Navigator, Solution, open_sequence
from rvdnav.evaluation import Evaluation, evaluate
from rvdnav.faults import FaultySequence, parse_fault
from rvdnav.sequence import Sequence
from rvdnav.solution import Reason

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "approach"

# Upper end of the range bin, m: median and 95th percentile of the position error, mm, and of the attitude error, deg.
LIMITS = {
    "approach": {
        0.5: (0.04, 0.15, 0.08, 0.2),
        0.8: (0.08, 0.3, 0.12, 0.3),
        1.1: (0.2, 0.5, 0.2, 0.5),
        9.0: (0.7, 1.5, 0.7, 1.2),
    },
    "sunlit": {0.8: (0.25, 2.0, 0.3, 1.5), 1.1: (0.4, 2.0, 0.4, 1.5), 9.0: (0.6, 2.0, 0.7, 1.5)},
}


def cold(sequence: Sequence, step: int) -> list[Solution]:
    """Every so many-th frame by itself, each by a fresh navigator that is told that its files are exact."""
    rig = attrs.evolve(sequence.rig, calibration_covariance=np.zeros((22, 22)))
    target = attrs.evolve(sequence.target, tolerance=dict.fromkeys(sequence.target.points, 0.0))
    return [Navigator(rig, target).process(sequence[i]) for i in range(0, len(sequence), step)]


@pytest.mark.parametrize(("name", "step"), [("approach", 2), ("sunlit", 2)])
def test_errors_of_frames_by_themselves(shared_data: Path, name: str, step: int) -> None:
    sequence = open_sequence(shared_data / "sequences" / name)
    evaluation = evaluate(cold(sequence, step), sequence.truth)
    assert evaluation.published >= 0.95 * evaluation.frames
    assert not evaluation.wrong.any()
    for lower, upper in pairwise([0.0, *LIMITS[name]]):
        here = (evaluation.ranges_m >= lower) & (evaluation.ranges_m < upper)
        assert here.any()
        position, attitude = 1e3 * evaluation.position_m[here], np.degrees(evaluation.attitude_rad[here])
        found = (np.median(position), np.percentile(position, 95), np.median(attitude), np.percentile(attitude, 95))
        assert (np.array(found) <= LIMITS[name][upper]).all(), (upper, found)


def test_covariances_are_honest(shared_data: Path) -> None:
    """Pooled over both sequences."""
    evaluations = []
    for name in LIMITS:
        sequence = open_sequence(shared_data / "sequences" / name)
        evaluations.append(evaluate(cold(sequence, 3), sequence.truth))
    nees = np.concatenate([evaluation.nees for evaluation in evaluations])
    deviations = np.concatenate([np.abs(evaluation.components) / evaluation.sigmas for evaluation in evaluations])
    assert 0.5 < nees.mean() / 6.0 < 2.0
    assert ((deviations < 3.0).mean(axis=0) >= 0.985).all()


def run(fault: str) -> tuple[FaultySequence, list[Solution], Evaluation]:
    """The example from its tenth frame on, with a fault."""
    sequence = FaultySequence(open_sequence(EXAMPLE), [parse_fault(fault)])
    navigator = Navigator(sequence.rig, sequence.target)
    solutions = [navigator.process(sequence[i]) for i in range(10, min(20, len(sequence)))]
    return sequence, solutions, evaluate(solutions, sequence.truth)


@pytest.mark.parametrize(
    ("fault", "reason"),
    [
        ("duplicated:13-15", Reason.DUPLICATE),
        ("late:13-15", Reason.TIME_ORDER),
        ("left_behind:13-15", Reason.DUPLICATE),
        ("swapped:13-15", Reason.NO_TARGET),
        ("black_left:13-15", Reason.LEFT_UNUSABLE),
        ("saturated:13-15", Reason.LEFT_UNUSABLE),
        ("miscalibrated_right_z:all", Reason.CROSS_VIEW),
        ("miscalibrated_left_focal:all", Reason.CROSS_VIEW),
        ("occluder_side:13-15", None),
        ("noise_x4:13-15", None),
        ("gain_0.3:13-15", None),
        ("corrupted_rows:13-15", None),
    ],
)
def test_a_fault_is_told_at_once_or_does_no_harm(fault: str, reason: Reason | None) -> None:
    sequence, solutions, evaluation = run(fault)
    response = sequence.response(parse_fault(fault), solutions)
    if reason is not None:
        assert response.alarm == 0
        assert reason.name in response.reasons
    assert not evaluation.wrong.any()
    assert not (np.abs(evaluation.components) > 5.0 * evaluation.sigmas).any()
    if "all" not in fault:
        assert response.again is not None
        assert response.again <= 3
