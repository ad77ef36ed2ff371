"""Everything that one error budget tells."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence

import attrs

from rvdnav.budget.assumptions import Assumptions
from rvdnav.budget.check import SAMPLES, Check, check
from rvdnav.budget.design import Design
from rvdnav.budget.levers import Change, changes
from rvdnav.budget.requirement import Improvement, Requirement, improvement
from rvdnav.budget.sweep import Cell, Sweep, cell, sweep
from rvdnav.errors import InputError
from rvdnav.navigator.edge_model import edge_model
from rvdnav.rig import Rig
from rvdnav.target import Target


@attrs.frozen(eq=False)
class Budget:
    """An error budget.

    calibration_known: the rig carries the covariance of its calibration; else one is assumed.  sweep: over ranges and
    angles.  at: the cell that other designs, the calibration's parameters and the requirements are told for.
    checks: by Monte Carlo, where asked for.
    """

    name: str
    design: Design
    calibration_known: bool
    sweep: Sweep
    at: Cell
    changes: tuple[Change, ...]
    improvements: tuple[Improvement, ...]
    checks: tuple[Check, ...]


def draw_up(
    name: str,
    rig: Rig,
    target: Target,
    assumptions: Assumptions,
    *,
    ranges: Sequence[float],
    angles: Sequence[float],
    at: float,
    requirements: Sequence[Requirement] = (),
    checked: bool = False,
    drawn: Callable[[int, int], None] = lambda draws, total: None,
) -> Budget:
    """The budget of a rig before a target, over ranges, m, and angles, rad, with more detail at one range, m.

    checked: compare with Monte Carlo at the corners of ranges and angles; drawn is called with the draws so far and
    all of them.  Raises InputError where no pose is determined at that range.
    """
    design = Design(rig, edge_model(target), assumptions)
    middle = cell(design, at, min(angles))
    if middle is None:
        raise InputError(f"at {at:g} m too little of target {target.name} is in view for a pose")
    if not middle.total.position > 0.0:
        raise InputError("budget: nothing is assumed to err")
    result = sweep(design, ranges, angles)
    places = check_places(result) if checked else []
    draws = itertools.count(1)

    def done() -> None:
        drawn(next(draws), SAMPLES * len(places))

    return Budget(
        name=name,
        design=design,
        calibration_known=rig.calibration_covariance is not None,
        sweep=result,
        at=middle,
        changes=tuple(changes(design, at, middle.angle)),
        improvements=tuple(improvement(design, middle, requirement) for requirement in requirements),
        checks=tuple(check(design, *place, done=done) for place in places),
    )


def check_places(result: Sweep) -> list[tuple[float, float]]:
    """Range, m, and angle, rad, of the poses of a check: the corners of the sweep where there is a pose."""
    return [(found.distance, found.angle) for found in result.corners if found is not None]
