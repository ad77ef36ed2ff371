"""``rvdnav simulate``: a scenario in, a sequence folder out."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from rvdnav.cli.tables import console
from rvdnav.simulation import load_scenario, simulate


def render(path: Path, out: Path) -> int:
    """Render the scenario at ``path`` into the folder ``out``.  Raises InputError."""
    scenario = load_scenario(path)
    errors = Console(stderr=True, highlight=False, markup=False)
    columns = (TextColumn("images"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), TextColumn("left"))
    try:
        with Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal) as bar:
            made = simulate(scenario, out, progress=partial(_show, bar))
    except (KeyboardInterrupt, SystemExit):
        errors.print("rvdnav: interrupted; the same command goes on from here", soft_wrap=True)
        raise
    note = f"{scenario.frames} frames" if made else "complete already"
    console.print(f"sequence: {out} ({note})", soft_wrap=True)
    return 0


def _show(bar: Progress, done: int, total: int) -> None:
    # The images of an earlier run are there from the start, or the time left would be reckoned with them.
    if not bar.tasks:
        bar.add_task("images", total=total, completed=done)
    else:
        bar.update(bar.tasks[0].id, completed=done)
