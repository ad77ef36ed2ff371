"""``rvdnav experiment paper``: the paper's run, its figures and its claims in one report."""

from __future__ import annotations

import os
from pathlib import Path

from rvdnav.cli.examples import example
from rvdnav.cli.simulate import render
from rvdnav.cli.tables import print_evaluation
from rvdnav.cli.terminal import console
from rvdnav.errors import InputError
from rvdnav.experiment import REPORT, navigate, write_paper_report
from rvdnav.output import staged_directory, staged_report, write_solutions
from rvdnav.sequence import open_sequence

_SEQUENCE = "sequence"


def experiment(name: str, run: Path | None, out: Path) -> int:
    """Repeat the paper's experiment on a sequence with truth or on a scenario, rendered into ``out``.

    Returns 0 if any pose was published, else 1.  Raises InputError.
    """
    if name != "paper":
        raise InputError(f"experiment {name!r}: there is only 'paper'")
    place = example("scenarios/paper.yaml") if run is None else run
    if not os.path.exists(place):
        raise InputError(f"{place}: no such sequence or scenario")
    if place.is_file():
        render(place, out / _SEQUENCE)
        place = out / _SEQUENCE
    with staged_directory(out) as staging:
        navigated = navigate(open_sequence(place))
        write_solutions(staging, navigated.solutions)
    print_evaluation(navigated.evaluation)
    with staged_report(out, REPORT) as page:
        write_paper_report(page, navigated)
    console.print(f"report: {out / REPORT}", soft_wrap=True)
    return 0 if navigated.evaluation.published else 1
