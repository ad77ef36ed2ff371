"""What other designs would give: baseline, focal length, number and length of lines, cameras."""

from __future__ import annotations

import math
from collections.abc import Callable

import attrs

from rvdnav.budget.design import Design
from rvdnav.budget.sweep import Cell, cell

# Not bisected at once: the target leaves the view of cameras far apart or of narrow fields.
_FACTORS = tuple(math.pow(2.0, step / 4.0) for step in range(1, 9))
_BISECTIONS = 4


@attrs.frozen(eq=False)
class Change:
    """A change of the design, in words, and the budget with it; None where the pose is not determined then."""

    name: str
    cell: Cell | None


def changes(design: Design, distance: float, angle: float) -> list[Change]:
    """The budget at a range, m, and angle, rad, of designs that differ in one thing each, after the design's own."""
    others = "every other edge" if design.model.bracket is None else "outer edges alone"
    designs = {
        "as it is": design,
        "half the focal length": design.with_focal_length(0.5),
        "twice the focal length": design.with_focal_length(2.0),
        "half of every line": attrs.evolve(design, part=0.5 * design.part),
        others: attrs.evolve(design, edges=design.edges[::2]),
    }
    if design.rig.is_stereo:
        designs |= {
            "half the baseline": design.with_baseline(0.5),
            "twice the baseline": design.with_baseline(2.0),
            "left camera alone": attrs.evolve(design, views=(0,)),
        }
    return [Change(name, cell(changed, distance, angle)) for name, changed in designs.items()]


def factor_needed(
    changed: Callable[[float], Design], distance: float, angle: float, enough: Callable[[Cell], bool]
) -> float | None:
    """The smallest factor from 1 on, up to 4, with which a changed design is good enough; None where there is none."""
    low = 1.0
    for high in _FACTORS:
        if _enough(changed(high), distance, angle, enough):
            break
        low = high
    else:
        return None
    for _ in range(_BISECTIONS):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if _enough(changed(middle), distance, angle, enough) else (middle, high)
    return high


def _enough(design: Design, distance: float, angle: float, enough: Callable[[Cell], bool]) -> bool:
    found = cell(design, distance, angle)
    return found is not None and enough(found)
