"""``rvdnav evaluate``: a run's results against the sequence's true poses."""

from __future__ import annotations

from pathlib import Path

from rvdnav import evaluation
from rvdnav.cli.blackboxes import black_boxes
from rvdnav.cli.tables import print_evaluation
from rvdnav.cli.terminal import console
from rvdnav.errors import InputError
from rvdnav.output import read_solutions, staged_directory
from rvdnav.report import write_report
from rvdnav.sequence import open_sequence


def evaluate(path: Path, directory: Path) -> int:
    """Judge the run in ``directory``; 0 if any pose was published, else 1.  Raises InputError."""
    sequence = open_sequence(path)
    if sequence.truth is None:
        raise InputError(f"{path / 'groundtruth.tum'}: no such file; nothing to compare with")
    solutions = read_solutions(directory)
    result = evaluation.evaluate(solutions, sequence.truth)
    with staged_directory(directory) as staging:
        write_report(
            staging / "evaluation.html",
            path.resolve().name,
            solutions,
            truth=sequence.truth,
            evaluation=result,
            black_boxes=black_boxes(directory, solutions),
        )
    print_evaluation(result)
    console.print(f"plots: {directory / 'evaluation.html'}", soft_wrap=True)
    return 0 if result.published else 1
