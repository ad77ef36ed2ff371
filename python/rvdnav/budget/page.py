"""The budget's page: budget.html, in the style of the reports."""

from __future__ import annotations

from pathlib import Path

from rvdnav.budget.budget import Budget
from rvdnav.budget.check import SAMPLES
from rvdnav.budget.figures import angle_figure, both, calibration_figure, number, range_figure
from rvdnav.budget.requirement import Improvement
from rvdnav.budget.rows import (
    CORRELATED,
    Grid,
    assumption_grid,
    calibration_grid,
    cause_grids,
    change_grid,
    check_grids,
    coverage,
    improvement_grid,
    verdict,
)
from rvdnav.report.html import figure_html, note_html, section, table_html
from rvdnav.report.page import write_page


def write_budget(path: Path, budget: Budget) -> None:
    """Write the page of a budget, which needs no network."""
    calibration = calibration_grid(budget.at)
    sections = [
        *(section(improvement_grid(found).title, _improvement(found)) for found in budget.improvements),
        section("Causes over the range", figure_html(range_figure(budget.sweep), "causes")),
        *(section(grid.title, _table(grid)) for grid in cause_grids(budget.sweep)),
        section("Total over range and viewing angle", figure_html(angle_figure(budget.sweep), "angles")),
        section(calibration.title, note_html(CORRELATED) + _table(calibration)),
        section(
            f"Each parameter of the calibration by itself, at {budget.at.distance:g} m",
            figure_html(calibration_figure(budget.at), "calibration"),
        ),
        *(section(grid.title, _table(grid)) for grid in (change_grid(budget), *check_grids(budget))),
        section("Counted", "".join(map(note_html, coverage(budget)))),
        section("Assumed", _table(assumption_grid(budget))),
    ]
    write_page(path, budget.name, "Error budget of the pose: one standard deviation", _tiles(budget), sections)


def _tiles(budget: Budget) -> list[tuple[str, str, str]]:
    tiles = []
    for found in (budget.sweep.head_on[0], budget.at):
        if found is not None:
            position, attitude = map(number, both(found.total))
            largest = max(found.causes, key=lambda name: found.causes[name].position)
            tiles.append((f"at {found.distance:g} m", f"{position} mm", f"{attitude}°; mostly {largest}"))
    tiles += [
        (f"required: {found.requirement.text}", "met" if found.met else "not met", f"at {found.cell.distance:g} m")
        for found in budget.improvements
    ]
    if budget.checks:
        worst = max((abs(ratio - 1.0) for check in budget.checks for ratio in check.ratios), default=0.0)
        note = f"{SAMPLES} draws at each of {len(budget.checks)} poses"
        tiles.append(("Monte Carlo", f"within {100.0 * worst:.0f} %", note))
    return tiles


def _improvement(found: Improvement) -> str:
    return "".join(map(note_html, verdict(found))) + _table(improvement_grid(found))


def _table(grid: Grid) -> str:
    return table_html(grid.headings, grid.rows, total=grid.total)
