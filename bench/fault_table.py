"""The fault table: faults without a strength, over the given sequences, struck in the middle; Markdown on stdout.

    python bench/fault_table.py SEQUENCE...

A line is one fault on one sequence, by a fresh navigator with default settings.  Faults of the calibration hold in all
frames, the others in a stretch in the middle.
"""

from __future__ import annotations

import sys

import attrs
import numpy as np
from rvdnav import Navigator, Sequence, open_sequence
from rvdnav.evaluation import Evaluation, evaluate
from rvdnav.faults import FAULT_NAMES, STRENGTHS, Fault, FaultySequence, Response

SIGMAS = 5.0
HEADINGS = (
    "fault",
    "sequence",
    "refused of struck",
    "reasons",
    "alarm after",
    "again after",
    "wrong",
    "beyond 5σ",
    "largest error, mm / °",
)


@attrs.frozen(eq=False)
class Outcome:
    """What became of one fault on one sequence; frames without a true pose are not judged."""

    fault: Fault
    response: Response
    evaluation: Evaluation

    @property
    def beyond(self) -> int:
        """Published frames with a component beyond SIGMAS standard deviations."""
        result = self.evaluation
        return int(np.count_nonzero((np.abs(result.components) > SIGMAS * result.sigmas).any(axis=1)))


def strike(sequence: Sequence, name: str) -> Outcome:
    """Run a sequence with a fault: in all frames where it is the calibration's, else in a sixth from the middle on."""
    middle, length = len(sequence) // 2, max(len(sequence) // 6, 3)
    stretch = range(middle, middle + length)
    fault = Fault(name) if name.startswith("miscalibrated") else Fault(name, (stretch,))
    faulty = FaultySequence(sequence, [fault])
    navigator = Navigator(faulty.rig, faulty.target)
    solutions = [navigator.process(frame) for frame in faulty]
    assert sequence.truth is not None
    return Outcome(fault, faulty.response(fault, solutions), evaluate(solutions, sequence.truth))


def row(name: str, outcome: Outcome) -> tuple[str, ...]:
    """The outcome as the cells of the table."""
    result, response = outcome.evaluation, outcome.response
    largest = "–"
    if result.published:
        largest = f"{1e3 * result.position_m.max():.2f} / {np.degrees(result.attitude_rad.max()):.2f}"
    return (
        outcome.fault.name,
        name,
        f"{response.refused} of {len(response.struck)}",
        ", ".join(response.reasons[:3]) or "–",
        "–" if response.alarm is None else str(response.alarm),
        "–" if response.again is None else str(response.again),
        str(int(result.wrong.sum())),
        f"{outcome.beyond} of {result.published}",
        largest,
    )


def main(paths: list[str]) -> None:
    """Print the table for the sequences at those paths."""
    print(f"| {' | '.join(HEADINGS)} |")
    print("|" + "---|" * len(HEADINGS))
    sequences = [open_sequence(path) for path in paths]
    for name in (name for name in FAULT_NAMES if name not in STRENGTHS):
        for sequence in sequences:
            print(f"| {' | '.join(row(sequence.path.name, strike(sequence, name)))} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
