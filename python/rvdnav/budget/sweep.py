"""The budget over ranges and viewing angles."""

from __future__ import annotations

from collections import Counter
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
    try:
        return _drawn_up(design, distance, angle)
    except PoseError:
        return None


def _drawn_up(design: Design, distance: float, angle: float) -> Cell:
    azimuths = 2.0 * np.pi * np.arange(_DIRECTIONS if angle else 1) / _DIRECTIONS
    budgets = [pose_budget(design, design.pose_at(distance, angle, float(azimuth))) for azimuth in azimuths]

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
    """Cells [range][angle]; None where the pose is not determined.  gaps: why it is not, and in how many cells."""

    ranges: tuple[float, ...]
    angles: tuple[float, ...]
    cells: tuple[tuple[Cell | None, ...], ...]
    gaps: tuple[tuple[str, int], ...]

    @property
    def head_on(self) -> tuple[Cell | None, ...]:
        """Those of the smallest angle, by range."""
        return tuple(row[0] for row in self.cells)

    @property
    def corners(self) -> tuple[Cell | None, ...]:
        """Those of the smallest and the largest range and angle."""
        rows, columns = (dict.fromkeys((0, len(values) - 1)) for values in (self.ranges, self.angles))
        return tuple(self.cells[i][j] for i in rows for j in columns)


def sweep(design: Design, ranges: Sequence[float], angles: Sequence[float]) -> Sweep:
    """The budget over ranges, m, and angles, rad, both in ascending order."""
    ranges, angles = tuple(sorted(ranges)), tuple(sorted(angles))
    gaps: Counter[str] = Counter()

    def at(distance: float, angle: float) -> Cell | None:
        try:
            return _drawn_up(design, distance, angle)
        except PoseError as error:
            gaps[str(error)] += 1
            return None

    cells = tuple(tuple(at(distance, angle) for angle in angles) for distance in ranges)
    return Sweep(ranges, angles, cells, tuple(gaps.most_common()))
