"""What the navigator measures of a target: straight edges with names, and what is known beyond them."""

from __future__ import annotations

import attrs

from rvdnav.bracket import EDGE_NAMES, Bracket
from rvdnav.pose.arrays import FloatArray
from rvdnav.target import Target


@attrs.frozen(eq=False)
class EdgeModel:
    """A target's straight edges in the capture frame C.

    names (m,).  edge_points (m, 2, 3): their ends, m.  bracket: the four-bar bracket whose front edges they are, in the
    order of `EDGE_NAMES`, or None for any other target.
    """

    names: tuple[str, ...]
    edge_points: FloatArray
    bracket: Bracket | None

    @classmethod
    def of_bracket(cls, bracket: Bracket) -> EdgeModel:
        """The eight front edges of a bracket."""
        return cls(EDGE_NAMES, bracket.edge_points, bracket)

    def __len__(self) -> int:
        return len(self.names)


def edge_model(target: Target) -> EdgeModel | None:
    """The edges of a target by which it is navigated: its bracket's, or None where it has none."""
    return None if target.bracket is None else EdgeModel.of_bracket(target.bracket)
