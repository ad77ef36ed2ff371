"""``rvdnav budget``: how far the pose may err, from which causes, and what must improve."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from rich.table import Table

from rvdnav.budget import Assumptions, Budget, draw_up, parse_requirement, write_budget
from rvdnav.budget.rows import (
    CORRELATED,
    Grid,
    angle_grids,
    assumption_grid,
    calibration_grid,
    cause_grids,
    change_grid,
    check_grids,
    coverage,
    improvement_grid,
    verdict,
)
from rvdnav.cli.terminal import console, print_note, progress_bars
from rvdnav.errors import InputError
from rvdnav.output import staged_report
from rvdnav.rig import CAMCHAIN, RIG, load_rig
from rvdnav.target import load_target

REPORT = "budget.html"
_TARGET = "target.yaml"


def budget(
    path: Path,
    out: Path,
    target: Path | None,
    assumptions: Assumptions,
    *,
    ranges: str,
    angles: str,
    at: float | None,
    requirements: Sequence[str],
    checked: bool,
) -> int:
    """Draw up the budget of the rig and target at ``path`` into ``out``.

    Returns 0, or 1 where a check by Monte Carlo does not agree.  Raises InputError.
    """
    wanted = [parse_requirement(text) for text in requirements]
    distances = _numbers("--ranges", ranges, above=0.0, below=math.inf)
    degrees = _numbers("--angles", angles, above=-1e-9, below=85.0)
    detail = distances[-1] if at is None else at
    if not 0.0 < detail < math.inf:
        raise InputError(f"--at {detail:g}: not a range")
    folder = _folder(path)
    notices: list[str] = []
    rig = load_rig(folder, notices)
    for notice in notices:
        print_note(notice)
    known = load_target(folder / _TARGET if target is None else target)
    try:
        with progress_bars() as tell:
            result = draw_up(
                folder.resolve().name,
                rig,
                known,
                assumptions,
                ranges=distances,
                angles=[math.radians(angle) for angle in degrees],
                at=detail,
                requirements=wanted,
                checked=checked,
                drawn=partial(tell, "Monte Carlo"),
            )
    except ValueError as error:  # a lens that folds back as soon as its calibration errs a little
        raise InputError(f"{path}: no budget can be drawn up: {error}") from error
    _print(result)
    with staged_report(out, REPORT) as page:
        write_budget(page, result)
    console.print(f"report: {out / REPORT}", soft_wrap=True)
    return 0 if all(check.agrees for check in result.checks) else 1


def assume(
    noise: float, contrast: float, displacement_px: float, tolerance_mm: float, timing_ms: float, speed: float
) -> Assumptions:
    """The assumptions that the options make.  Raises InputError for one out of range."""
    from_zero = {
        "noise": noise,
        "displacement": displacement_px,
        "tolerance": tolerance_mm,
        "timing": timing_ms,
        "speed": speed,
    }
    for name, value in from_zero.items():
        if not 0.0 <= value < math.inf:
            raise InputError(f"--{name} {value:g}: not a number from 0 on")
    if not 0.0 < contrast < math.inf:
        raise InputError(f"--contrast {contrast:g}: not a number above 0")
    return Assumptions(
        noise=noise,
        contrast=contrast,
        displacement=displacement_px,
        dimensions=1e-3 * tolerance_mm,
        timing=1e-3 * timing_ms,
        speed=speed,
    )


def _folder(path: Path) -> Path:
    """The folder of the rig's files, which is named itself or by one of them."""
    if os.path.isdir(path):
        return path
    if not os.path.exists(path):
        raise InputError(f"{path}: no such file or folder")
    if path.name not in (CAMCHAIN, RIG):
        raise InputError(f"{path}: neither a folder nor a {CAMCHAIN} or {RIG}")
    return path.parent


def _numbers(option: str, text: str, *, above: float, below: float) -> list[float]:
    try:
        values = sorted({float(word) for word in text.split(",")})
    except ValueError:
        raise InputError(f"{option} {text!r}: not numbers with commas between") from None
    for value in values:
        if not above < value < below:
            raise InputError(f"{option} {text!r}: {value:g} is out of range")
    return values


def _print(result: Budget) -> None:
    _print_grid(assumption_grid(result), numbers=False)
    for grid in (*cause_grids(result.sweep), *angle_grids(result.sweep), calibration_grid(result.at)):
        _print_grid(grid)
    console.print(CORRELATED)
    for grid in (change_grid(result), *check_grids(result)):
        _print_grid(grid)
    for found in result.improvements:
        _print_grid(improvement_grid(found))
        for sentence in verdict(found):
            console.print(sentence)
    for sentence in coverage(result):
        console.print(sentence, soft_wrap=True)


def _print_grid(grid: Grid, *, numbers: bool = True) -> None:
    table = Table(title=grid.title, title_justify="left")
    table.add_column(grid.headings[0])
    for heading in grid.headings[1:]:
        table.add_column(heading, justify="right" if numbers else "left")
    for row in grid.rows:
        if grid.total and row is grid.rows[-1]:
            table.add_section()
        table.add_row(*row)
    console.print(table)
