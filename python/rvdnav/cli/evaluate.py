"""``rvdnav evaluate``: a run's results against the sequence's true poses."""

from __future__ import annotations

from pathlib import Path

from rvdnav import __version__, evaluation
from rvdnav.cli.blackboxes import black_boxes
from rvdnav.cli.tables import print_evaluation
from rvdnav.cli.terminal import console
from rvdnav.errors import InputError
from rvdnav.jsonio import write_json
from rvdnav.output import read_solutions, staged_report
from rvdnav.report import provenance, write_report
from rvdnav.sequence import open_sequence

REPORT = "evaluation.html"


def evaluate(path: Path, directory: Path, json_path: Path | None = None) -> int:
    """Judge the run in ``directory``; 0 if any pose was published, else 1.  json_path: where to write the figures too.

    Raises InputError.
    """
    sequence = open_sequence(path)
    if sequence.truth is None:
        raise InputError(f"{path / 'groundtruth.tum'}: no such file; nothing to compare with")
    solutions = read_solutions(directory)
    if not {solution.timestamp_ns for solution in solutions} & set(sequence.timestamps_ns):
        raise InputError(f"{directory}: no frame of the run is one of {path}: is it a run over another sequence?")
    result = evaluation.evaluate(solutions, sequence.truth)
    print_evaluation(result)
    with staged_report(directory, REPORT) as page:
        write_report(
            page,
            f"Evaluation against {path.resolve().name}",
            solutions,
            truth=sequence.truth,
            evaluation=result,
            black_boxes=black_boxes(directory, solutions),
            facts=provenance(["evaluate", path.resolve().name, directory.resolve().name], path),
        )
    if json_path is not None:
        write_json(json_path, {"rvdnav": __version__, "sequence": path.resolve().name, **result.to_json()})
    console.print(f"plots: {directory / REPORT}", soft_wrap=True)
    return 0 if result.published else 1
