"""What the navigator measures of a target: straight edges with names, and what is known beyond them."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from attrs import evolve, frozen

from rvdnav.bracket import EDGE_APEXES, EDGE_NAMES, Bracket
from rvdnav.core import TargetEdges
from rvdnav.navigator.visibility import GRAZING, Faces, Pieces, whole_edges
from rvdnav.pose.arrays import FloatArray, IntArray
from rvdnav.target import Target

CORNER_NAMES = ("P1", "P2", "P3", "P4", "Q1", "Q2", "Q3", "Q4")
"""Of a bracket: outer and inner ones, in its order."""


@frozen(eq=False)
class EdgeModel:
    """A target's straight edges in the capture frame C.

    names (m,).  points (k, 3): the edges' ends, m, with point_names (k,); point_sigmas (k,): to which each coordinate
    is known, m.  ends (m, 2): numbers of an edge's two points.  bracket: the four-bar bracket whose front edges they
    are, in the order of `EDGE_NAMES`, or None for any other target.  faces: what may hide them, None if nothing does.
    """

    names: tuple[str, ...]
    points: FloatArray
    point_names: tuple[str, ...]
    point_sigmas: FloatArray
    ends: IntArray
    bracket: Bracket | None
    faces: Faces | None = None

    @classmethod
    def of_bracket(
        cls, bracket: Bracket, point_sigmas: FloatArray | None = None, point_names: tuple[str, ...] = CORNER_NAMES
    ) -> EdgeModel:
        """The eight front edges of a bracket; point_sigmas (8,) of P1..P4 and Q1..Q4, exact if not given."""
        ends = np.array([(a + inner, b + inner) for a, b in EDGE_APEXES for inner in (0, 4)])
        sigmas = np.zeros(2 * len(bracket.outer)) if point_sigmas is None else point_sigmas
        return cls(EDGE_NAMES, np.concatenate([bracket.outer, bracket.inner]), point_names, sigmas, ends, bracket)

    @cached_property
    def edge_points(self) -> FloatArray:
        """(m, 2, 3) the edges' ends, m."""
        edge_points: FloatArray = self.points[self.ends]
        return edge_points

    @cached_property
    def in_core(self) -> TargetEdges:
        """As the core takes it."""
        normals = None if self.bracket is None else self.bracket.side_normals
        thickness = None if self.bracket is None else self.bracket.thickness
        return TargetEdges(
            self.points, self.point_sigmas, self.ends, thickness=thickness, side_normals=normals, faces=self.faces
        )

    @property
    def exact(self) -> EdgeModel:
        """With its points taken to be exact."""
        return evolve(self, point_sigmas=np.zeros(len(self.points)))

    def parts(self, edge: IntArray, points: FloatArray) -> FloatArray:
        """Where on its edge (n,) each of points (n, 2, 3) lies, (n, 2): 0 at the first end, 1 at the second."""
        start, end = self.edge_points[edge, 0], self.edge_points[edge, 1]
        along = end - start
        part = np.einsum("nki,ni->nk", points - start[:, None], along)
        return np.asarray(part / np.einsum("ni,ni->n", along, along)[:, None], np.float64)

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
        sigmas = np.array([target.point_sigma(name) for name in target.bracket_names])
        model = EdgeModel.of_bracket(target.bracket, sigmas, target.bracket_names)
    else:
        once = _edges_once(target)
        corners = tuple(dict.fromkeys(name for pair in once for name in pair))
        model = EdgeModel(
            tuple(f"{a}-{b}" for a, b in once),
            np.array([target.points[name] for name in corners]).reshape(-1, 3),
            corners,
            np.array([target.point_sigma(name) for name in corners]),
            np.array([[corners.index(name) for name in pair] for pair in once], np.int64).reshape(-1, 2),
            None,
        )
    if not target.faces:
        return model
    polygons = [np.array([target.points[name] for name in face]) for face in target.faces]
    return evolve(model, faces=Faces.of(polygons, model.edge_points))


def _edges_once(target: Target) -> list[tuple[str, str]]:
    """Names of the ends of the bars' edges and the others; an edge is the same from either end."""
    once: dict[frozenset[str], tuple[str, str]] = {}
    for ends in (*(ends for bar in target.bars for ends in (bar.outer, bar.inner)), *target.edges):
        once.setdefault(frozenset(ends), ends)
    return list(once.values())
