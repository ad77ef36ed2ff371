"""The tables of a budget as rows of text, for the terminal and the page alike."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np

from rvdnav.budget.board_calibration import CORNER_SIGMA_PX, VIEWS
from rvdnav.budget.budget import Budget
from rvdnav.budget.causes import CALIBRATION, CAUSES, DIMENSIONS, DISPLACEMENT, NOISE, SIDES, TIMING
from rvdnav.budget.check import SAMPLES
from rvdnav.budget.figures import both, number
from rvdnav.budget.requirement import Improvement
from rvdnav.budget.sweep import Cell, Sigma, Sweep

_NONE = "–"
BOARD = f"{VIEWS} views of a board with corners to {CORNER_SIGMA_PX:g} px give"
CORRELATED = (
    "The errors of a calibration are correlated and partly cancel: parameters by themselves can weigh more than all "
    "together."
)


@attrs.frozen
class Grid:
    """A table: its title, the headings of its columns, and its rows; total: the last row is one."""

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    total: bool = False


def cause_grids(result: Sweep) -> tuple[Grid, Grid]:
    """Every cause by range, head-on: the position's in mm and the attitude's in degrees."""
    headings = ("cause", *(f"{distance:g} m" for distance in result.ranges))
    angle = f"at {np.degrees(result.angles[0]):g}°"
    titles = (f"Position σ {angle}, mm", f"Attitude σ {angle}, °")
    position, attitude = (
        Grid(
            title,
            headings,
            (
                *((name, *(_one(c, index, name) for c in result.head_on)) for name in CAUSES),
                ("total", *(_one(c, index) for c in result.head_on)),
            ),
            total=True,
        )
        for index, title in enumerate(titles)
    )
    return position, attitude


def angle_grids(result: Sweep) -> tuple[Grid, Grid]:
    """The total over range and viewing angle: the position's in mm and the attitude's in degrees."""
    headings = ("range", *(f"{np.degrees(angle):g}°" for angle in result.angles))
    position, attitude = (
        Grid(
            title,
            headings,
            tuple(
                (f"{distance:g} m", *(_one(c, index) for c in row))
                for distance, row in zip(result.ranges, result.cells, strict=True)
            ),
        )
        for index, title in enumerate(("Position σ by viewing angle, mm", "Attitude σ by viewing angle, °"))
    )
    return position, attitude


def calibration_grid(found: Cell) -> Grid:
    """What parts of the calibration do at a cell."""
    rows = [(name, _two(sigma), _two(found.without[name])) for name, sigma in found.groups.items()]
    rows.append(("all together", _two(found.causes[CALIBRATION]), _NONE))
    title = f"Calibration at {_place(found)}, mm / °"
    return Grid(title, ("parameters", "these alone", "the rest, were they known"), tuple(rows), total=True)


def change_grid(budget: Budget) -> Grid:
    """Other designs at the budget's cell."""
    rows = [
        (change.name, _NONE if change.cell is None else str(change.cell.lines), _cell(change.cell))
        for change in budget.changes
    ]
    title = f"Other designs at {_place(budget.at)}, mm / °"
    return Grid(title, ("design", "lines", "total σ"), tuple(rows))


def assumption_grid(budget: Budget) -> Grid:
    """What the budget was drawn up for."""
    rig, assumed = budget.design.rig, budget.design.assumptions
    cameras = f"baseline {rig.baseline * 1e3:.1f} mm, " if rig.is_stereo else "one camera, "
    rows = [
        ("rig", f"{cameras}focal length {rig.focal_rect:.1f} px, {rig.width} x {rig.height} px"),
        (CALIBRATION, "covariance of rig.yaml" if budget.calibration_known else f"none in rig.yaml: as {BOARD}"),
        (
            NOISE,
            f"{assumed.noise:g} grey levels at steps of {assumed.contrast:g}: {assumed.profile_sigma:.3f} px",
        ),
        (DISPLACEMENT, f"{assumed.displacement:g} px, of offset and of tilt"),
        (SIDES, f"{assumed.side_part:g} of the width that is in sight"),
        (DIMENSIONS, f"{assumed.dimensions * 1e3:g} mm, of each coordinate of each corner"),
    ]
    if rig.is_stereo:
        motion = f"{assumed.speed:g} m/s and {np.degrees(assumed.turn_rate):g}°/s in any direction"
        rows.append((TIMING, f"{assumed.timing * 1e3:g} ms between the exposures, at {motion}"))
    return Grid("Assumed, one standard deviation", ("cause", "size"), tuple(rows))


def check_grids(budget: Budget) -> list[Grid]:
    """Monte Carlo over linear, by component; none without a check."""
    checks = budget.checks
    if not checks:
        return []
    rows = [
        (
            f"{check.distance:g} m, {np.degrees(check.angle):g}°",
            *(f"{ratio:.3f}" for ratio in check.ratios),
            "yes" if check.agrees else "NO",
        )
        for check in checks
    ]
    headings = ("at", "x", "y", "z", "about x", "about y", "about z", "agree")
    return [Grid(f"σ of {SAMPLES} draws / linear σ", headings, tuple(rows))]


def coverage(budget: Budget) -> list[str]:
    """For how many ranges and angles, designs and places of a check there are figures, and why not for all."""
    cells = [found for row in budget.sweep.cells for found in row]
    gaps = ", ".join(f"{why} ({count})" for why, count in budget.sweep.gaps)
    designs = [change.cell for change in budget.changes]
    sentences = [
        _counted("ranges and angles with a pose", cells, gaps),
        _counted("designs with a pose", designs, "too little of the target is in view"),
    ]
    if budget.checks:
        sentences.append(_counted("corners of ranges and angles checked", budget.sweep.corners, "there is no pose"))
    return sentences


def _counted(what: str, found: Sequence[Cell | None], otherwise: str) -> str:
    count = sum(one is not None for one in found)
    told = f"{what}: {count} of {len(found)}"
    return told if count == len(found) else f"{told}; at the others ({_NONE}): {otherwise}"


def improvement_grid(result: Improvement) -> Grid:
    """The causes as a requirement sees them."""
    rows = [
        (
            part.name,
            _single(result, part.sigma),
            f"{100.0 * part.share:.0f} %",
            _alone(part.factor),
        )
        for part in result.parts
    ]
    place = _place(result.cell)
    return Grid(
        f"Required: {result.requirement.text} at {place}",
        ("cause", "σ", "of the variance", "enough alone"),
        tuple(rows),
    )


def verdict(result: Improvement) -> list[str]:
    """What a requirement asks, in sentences."""
    total = _single(result, result.total)
    if result.met:
        return [f"Met: σ is {total}, {result.factor:.2f} times better than required."]
    names, factor = result.fewest
    largest = result.parts[0]
    lines = [
        f"Not met: σ is {total}, {1.0 / result.factor:.2f} times too large. "
        f"Largest cause: {largest.name}, {100.0 * largest.share:.0f} % of the variance.",
        f"The least that suffices: {_listed(names)} to {100.0 * factor:.0f} %, or everything to "
        f"{100.0 * result.factor:.0f} %, of the present size.",
    ]
    grown = [("baseline", result.baseline), ("focal length", result.focal_length)]
    able = [f"{factor:.2f} times the {name}" for name, factor in grown if factor is not None]
    if able:
        lines.append(f"Or, with the errors as they are: {' or '.join(able)}.")
    else:
        lines.append("No baseline or focal length up to 4 times as long suffices by itself.")
    return lines


def _alone(factor: float | None) -> str:
    if factor is None:
        return "no"
    if factor < 1.0:
        return f"to {100.0 * factor:.0f} %"
    return f"up to {factor:.1f} times" if factor < 100.0 else "any"


def _place(found: Cell) -> str:
    return f"{found.distance:g} m, {np.degrees(found.angle):g}°"


def _listed(names: Sequence[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def _single(result: Improvement, sigma: float) -> str:
    if result.requirement.is_position:
        return f"{number(sigma * 1e3)} mm"
    return f"{number(float(np.degrees(sigma)))}°"


def _one(found: Cell | None, index: int, cause: str | None = None) -> str:
    if found is None:
        return _NONE
    return number(both(found.total if cause is None else found.causes[cause])[index])


def _cell(found: Cell | None) -> str:
    return _NONE if found is None else _two(found.total)


def _two(sigma: Sigma) -> str:
    return " / ".join(map(number, both(sigma)))
