"""What the navigator measures of a target: straight edges with names, and what is known beyond them."""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.bracket import EDGE_NAMES, Bracket
from rvdnav.navigator.visibility import GRAZING, Faces, Pieces, whole_edges
from rvdnav.pose.arrays import FloatArray
from rvdnav.target import Target


@attrs.frozen(eq=False)
class EdgeModel:
    """A target's straight edges in the capture frame C.

    names (m,).  edge_points (m, 2, 3): their ends, m.  bracket: the four-bar bracket whose front edges they are, in the
    order of `EDGE_NAMES`, or None for any other target.  faces: what may hide them, None if nothing does.
    """

    names: tuple[str, ...]
    edge_points: FloatArray
    bracket: Bracket | None
    faces: Faces | None = None

    @classmethod
    def of_bracket(cls, bracket: Bracket) -> EdgeModel:
        """The eight front edges of a bracket."""
        return cls(EDGE_NAMES, bracket.edge_points, bracket)

    def __len__(self) -> int:
        return len(self.names)

    def visible_pieces(self, T_world_target: FloatArray, eye_W: FloatArray, *, grazing: bool = False) -> Pieces:
        """What of the edges is seen from eye_W (3,) with the target at T_world_target (4, 4).

        grazing: those too that only faces at a grazing angle show, which are no good to measure.
        """
        if self.faces is None:
            return whole_edges(self.edge_points)
        eye_C = T_world_target[:3, :3].T @ (eye_W - T_world_target[:3, 3])
        return self.faces.visible_pieces(eye_C, self.edge_points, 0.0 if grazing else GRAZING)


def edge_model(target: Target) -> EdgeModel:
    """The edges of a target by which it is navigated: the front edges of its bracket, else those of its bars and its
    other edges, each once."""
    if target.bracket is not None:
        model = EdgeModel.of_bracket(target.bracket)
    else:
        once = _edges_once(target)
        names = tuple(f"{a}-{b}" for a, b in once)
        ends = np.array([[target.points[a], target.points[b]] for a, b in once]).reshape(-1, 2, 3)
        model = EdgeModel(names, ends, None)
    if not target.faces:
        return model
    polygons = [np.array([target.points[name] for name in face]) for face in target.faces]
    return attrs.evolve(model, faces=Faces.of(polygons, model.edge_points))


def _edges_once(target: Target) -> list[tuple[str, str]]:
    """Names of the ends of the bars' edges and the others; an edge is the same from either end."""
    once: dict[frozenset[str], tuple[str, str]] = {}
    for ends in (*(ends for bar in target.bars for ends in (bar.outer, bar.inner)), *target.edges):
        once.setdefault(frozenset(ends), ends)
    return list(once.values())
