"""The budget over ranges and viewing angles."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import attrs
import numpy as np

from rvdnav.budget.design import Design
from rvdnav.budget.propagation import PoseBudget, pose_budget
from rvdnav.pose import PoseError
from rvdnav.pose.arrays import FloatArray

_DIRECTIONS = 4


@attrs.frozen
class Sigma:
    """Standard deviations of the pose: roots of the mean squares of the position's error ‖p - p_true‖, m, and of the
    attitude's, the angle of R R_trueᵀ, rad."""

    position: float
    attitude: float

    @classmethod
    def of(cls, covariance: FloatArray) -> Sigma:
        """From a covariance (6, 6), order (position, rotation)."""
        variances = np.diagonal(covariance)
        return cls(float(np.sqrt(variances[:3].sum())), float(np.sqrt(variances[3:].sum())))


@attrs.frozen(eq=False)
class Cell:
    """The budget at one range, m, and viewing angle, rad: the mean over four sides to which the target is turned.

    causes: by name; their squares add up to those of total.  groups: parameters of the calibration, by their own
    uncertainty alone.  without: all of the calibration that would be left, were a group known exactly.
    parameters: each by itself.  components (6,): standard deviations of the total, order (position, rotation) in W.
    lines: fewest that are measured.
    """

    distance: float
    angle: float
    causes: dict[str, Sigma]
    groups: dict[str, Sigma]
    without: dict[str, Sigma]
    parameters: dict[str, Sigma]
    total: Sigma
    components: FloatArray
    lines: int


def cell(design: Design, distance: float, angle: float) -> Cell | None:
    """The budget there; None where the lines in view do not determine the pose."""
    azimuths = 2.0 * np.pi * np.arange(_DIRECTIONS if angle else 1) / _DIRECTIONS
    try:
        budgets = [pose_budget(design, design.pose_at(distance, angle, float(azimuth))) for azimuth in azimuths]
    except PoseError:
        return None

    def mean(part: Callable[[PoseBudget], dict[str, FloatArray]]) -> dict[str, Sigma]:
        parts = [part(budget) for budget in budgets]
        return {name: Sigma.of(np.mean([each[name] for each in parts], axis=0)) for name in parts[0]}

    total = np.mean([budget.total for budget in budgets], axis=0)
    return Cell(
        distance=distance,
        angle=angle,
        causes=mean(lambda budget: budget.causes),
        groups=mean(lambda budget: budget.groups),
        without=mean(lambda budget: budget.without),
        parameters=mean(lambda budget: budget.parameters),
        total=Sigma.of(total),
        components=np.sqrt(np.diagonal(total)),
        lines=min(budget.lines for budget in budgets),
    )


@attrs.frozen(eq=False)
class Sweep:
    """Cells [range][angle]; None where the pose is not determined."""

    ranges: tuple[float, ...]
    angles: tuple[float, ...]
    cells: tuple[tuple[Cell | None, ...], ...]

    @property
    def head_on(self) -> tuple[Cell | None, ...]:
        """Those of the smallest angle, by range."""
        return tuple(row[0] for row in self.cells)


def sweep(design: Design, ranges: Sequence[float], angles: Sequence[float]) -> Sweep:
    """The budget over ranges, m, and angles, rad, both in ascending order."""
    ranges, angles = tuple(sorted(ranges)), tuple(sorted(angles))
    return Sweep(ranges, angles, tuple(tuple(cell(design, r, a) for a in angles) for r in ranges))
