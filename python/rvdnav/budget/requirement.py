"""What must improve for a required accuracy."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import attrs

from rvdnav.budget.design import Design
from rvdnav.budget.levers import factor_needed
from rvdnav.budget.sweep import Cell, Sigma
from rvdnav.errors import InputError

_METRES = {"um": 1e-6, "mm": 1e-3, "cm": 1e-2, "m": 1.0}
_RADIANS = {"deg": math.radians(1.0), "mrad": 1e-3, "rad": 1.0}


@attrs.frozen
class Requirement:
    """The largest standard deviation allowed: of the position, m, or of the attitude, rad."""

    text: str
    value: float
    is_position: bool

    def of(self, sigma: Sigma) -> float:
        """The one of a cause's standard deviations that this is about."""
        return sigma.position if self.is_position else sigma.attitude


def parse_requirement(text: str) -> Requirement:
    """From a number and its unit: um, mm, cm, m for the position; deg, mrad, rad for the attitude.

    Raises InputError for anything else.
    """
    match = re.fullmatch(r"\s*([0-9.]+(?:e[-+]?[0-9]+)?)\s*([a-z]+)\s*", text)
    try:
        number = float(match[1]) if match else math.nan
    except ValueError:
        number = math.nan
    unit = match[2] if match else ""
    if not (number > 0.0 and math.isfinite(number)) or unit not in _METRES | _RADIANS:
        raise InputError(f"--require {text!r}: not a positive number with a unit, such as 1mm or 0.1deg")
    return Requirement(text.strip(), number * (_METRES | _RADIANS)[unit], unit in _METRES)


@attrs.frozen
class Part:
    """A cause's standard deviation (m or rad), its share of the total variance, and the factor by which it alone would
    have to shrink, or from 1 on may grow; None where the others are too large even without it."""

    name: str
    sigma: float
    share: float
    factor: float | None


@attrs.frozen(eq=False)
class Improvement:
    """What a requirement asks of a design at a range and angle.

    total: standard deviation there (m or rad).  parts: the causes, the largest first.
    factor: by which all causes together would have to shrink; from 1 on the requirement is met.
    fewest: the fewest causes that could meet it, the largest ones, and the factor for these.
    baseline, focal_length: by what factor either alone would have to grow; None where that does not do.
    """

    requirement: Requirement
    cell: Cell
    total: float
    parts: tuple[Part, ...]
    factor: float
    fewest: tuple[tuple[str, ...], float]
    baseline: float | None
    focal_length: float | None

    @property
    def met(self) -> bool:
        """Whether the design is good enough as it is."""
        return self.factor >= 1.0


def improvement(design: Design, cell: Cell, requirement: Requirement) -> Improvement:
    """What must improve at a cell of the design's budget."""
    total, allowed = requirement.of(cell.total), requirement.value**2
    sigmas = sorted(((name, requirement.of(sigma)) for name, sigma in cell.causes.items()), key=lambda item: -item[1])
    parts = tuple(
        Part(name, sigma, sigma**2 / total**2, _factor(allowed, total**2 - sigma**2, sigma)) for name, sigma in sigmas
    )
    met = total**2 <= allowed

    def enough(other: Cell) -> bool:
        return requirement.of(other.total) ** 2 <= allowed

    baseline = focal_length = None
    if not met:
        place = (cell.distance, cell.angle)
        if design.rig.is_stereo:
            baseline = factor_needed(design.with_baseline, *place, enough)
        focal_length = factor_needed(design.with_focal_length, *place, enough)
    return Improvement(
        requirement,
        cell,
        total,
        parts,
        requirement.value / total,
        _fewest(sigmas, allowed),
        baseline,
        focal_length,
    )


def _factor(allowed: float, others: float, sigma: float) -> float | None:
    if allowed <= others:
        return None
    return math.sqrt(allowed - others) / sigma if sigma > 0.0 else math.inf


def _fewest(sigmas: Sequence[tuple[str, float]], allowed: float) -> tuple[tuple[str, ...], float]:
    """The fewest of the causes, from the largest on, whose shrinking can do, and by what factor."""
    for count in range(1, len(sigmas) + 1):
        largest = math.sqrt(sum(sigma**2 for _, sigma in sigmas[:count]))
        factor = _factor(allowed, sum(sigma**2 for _, sigma in sigmas[count:]), largest)
        if factor is not None:
            break
    assert factor is not None  # of all causes together nothing is left
    return tuple(name for name, _ in sigmas[:count]), factor
