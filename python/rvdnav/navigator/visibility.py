"""Which parts of a target's edges an eye sees: edges of faces that look away and what lies behind faces is hidden."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray

# Places along an edge at which it is asked whether they are seen.
_PLACES = 65
# Distances below this part of the target's size are none.
_TOUCH = 1e-6
GRAZING = math.sin(math.radians(3.0))
"""Sine of the elevation of the eye above a face below which its far edges can't be told from the near ones, and a small
error of the pose would hide them."""


@attrs.frozen(eq=False)
class Pieces:
    """Parts of edges that are seen from one place; arrays of one length k, ordered by edge.

    edge (k,).  points (k, 2, 3): ends of the part, m in C, in the direction of the edge; exactly the edge's own for an
    edge that is seen whole.
    """

    edge: IntArray
    points: FloatArray

    def only(self, chosen: BoolArray) -> Pieces:
        """Those of the pieces that are chosen (k,)."""
        return Pieces(self.edge[chosen], self.points[chosen])

    def spans(self, edge_points: FloatArray) -> FloatArray:
        """(m, 2, 3) from the first to the last seen place of each edge; the whole edge where none of it is seen."""
        spans: FloatArray = edge_points.copy()
        first = np.unique(self.edge, return_index=True)[1]
        last = len(self.edge) - 1 - np.unique(self.edge[::-1], return_index=True)[1]
        spans[self.edge[first], 0] = self.points[first, 0]
        spans[self.edge[last], 1] = self.points[last, 1]
        return spans


def whole_edges(edge_points: FloatArray) -> Pieces:
    """All edges (m, 2, 3), seen from end to end."""
    return Pieces(np.arange(len(edge_points)), edge_points)


@attrs.frozen(eq=False)
class Faces:
    """Planar polygons of a target in the capture frame C, and the edges that lie on them.

    normals (f, 3): unit, outward.  origins (f, 3): a corner.  axes (f, 2, 3): of the polygons' planes.  corners
    (f, v, 2): in those axes from the origins, the last one repeated where a face has fewer than v.  adjoining (m, f):
    which edges lie on which faces.  touch: distance below which a place lies on a face, m.
    """

    normals: FloatArray
    origins: FloatArray
    axes: FloatArray
    corners: FloatArray
    adjoining: BoolArray
    touch: float

    @classmethod
    def of(cls, polygons: Sequence[FloatArray], edge_points: FloatArray) -> Faces:
        """From polygons (v, 3), counter-clockwise seen from outside, and edges (m, 2, 3)."""
        most = max(len(polygon) for polygon in polygons)
        padded = np.array([np.concatenate([p, np.repeat(p[-1:], most - len(p), axis=0)]) for p in polygons])
        # Newell's method: right for any planar polygon, convex or not.
        normals = np.cross(padded, np.roll(padded, -1, axis=1)).sum(axis=1)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        origins = padded[:, 0]
        first = padded[:, 1] - origins
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        axes = np.stack([first, np.cross(normals, first)], axis=1)
        corners = np.einsum("fvk,fak->fva", padded - origins[:, None], axes)
        touch = _TOUCH * float(np.ptp(edge_points.reshape(-1, 3), axis=0).max())
        bare = cls(normals, origins, axes, corners, np.zeros((len(edge_points), len(polygons)), np.bool_), touch)
        ends_and_middle = np.concatenate([edge_points, edge_points.mean(axis=1, keepdims=True)], axis=1)
        adjoining: BoolArray = np.logical_and.reduce(bare._lie_on(ends_and_middle), axis=1)
        return attrs.evolve(bare, adjoining=adjoining)

    def visible_pieces(self, eye_C: FloatArray, edge_points: FloatArray, least_elevation: float = 0.0) -> Pieces:
        """What an eye (3,) sees of the edges (m, 2, 3); see `visible`."""
        part = np.linspace(0.0, 1.0, _PLACES)[:, None]
        start, span = edge_points[:, 0], edge_points[:, 1] - edge_points[:, 0]
        places = start[:, None] + part * span[:, None]
        seen = self.visible(eye_C, places, least_elevation)
        edge, points = [], []
        for index in np.flatnonzero(seen.any(axis=1)):
            if seen[index].all():
                edge.append(index)
                points.append(edge_points[index])
                continue
            change = np.diff(np.concatenate([[False], seen[index], [False]]).astype(np.int8))
            for first, after in zip(np.flatnonzero(change > 0), np.flatnonzero(change < 0), strict=True):
                if after - first > 1:
                    edge.append(index)
                    points.append(places[index, [first, after - 1]])
        return Pieces(np.array(edge, np.int64), np.array(points).reshape(-1, 2, 3))

    def visible(self, eye_C: FloatArray, places: FloatArray, least_elevation: float = 0.0) -> BoolArray:
        """(m, n) whether an eye (3,) sees places (m, n, 3) on the m edges.

        least_elevation: sine of the angle by which the eye must stand above a face for its edges to count.
        """
        height = np.einsum("fk,fk->f", eye_C - self.origins, self.normals)
        middles = self.origins + np.einsum("fa,fak->fk", self.corners.mean(axis=1), self.axes)
        least = np.maximum(least_elevation * np.linalg.norm(eye_C - middles, axis=1), self.touch)
        away = self.adjoining.any(axis=1) & ~(self.adjoining & (height > least)).any(axis=1)
        seen: BoolArray = ~(away[:, None] | self._behind(eye_C, height, places))
        return seen

    def _behind(self, eye_C: FloatArray, eye_height: FloatArray, places: FloatArray) -> BoolArray:
        """Whether the rays from the eye meet a face before they come to the places."""
        height = np.einsum("mnfk,fk->mnf", places[:, :, None] - self.origins, self.normals)
        between = (height * eye_height < 0.0) & (np.abs(height) > self.touch) & (np.abs(eye_height) > self.touch)
        part = eye_height / np.where(between, eye_height - height, 1.0)
        hits = eye_C + part[..., None] * (places[:, :, None] - eye_C)
        behind: BoolArray = (between & self._inside(self._in_plane(hits))).any(axis=2)
        return behind

    def _in_plane(self, points: FloatArray) -> FloatArray:
        """(..., f, 2) coordinates of points (..., f, 3) in the faces' planes."""
        plane: FloatArray = np.einsum("...fk,fak->...fa", points - self.origins, self.axes)
        return plane

    def _inside(self, xy: FloatArray) -> BoolArray:
        """(..., f) whether points (..., f, 2) lie within the polygons: a ray along x crosses an odd number of sides."""
        a, b = self.corners, np.roll(self.corners, -1, axis=1)
        x, y = xy[..., None, 0], xy[..., None, 1]
        rise = b[..., 1] - a[..., 1]
        crosses = (a[..., 1] > y) != (b[..., 1] > y)
        at = a[..., 0] + (y - a[..., 1]) * (b[..., 0] - a[..., 0]) / np.where(rise == 0.0, 1.0, rise)
        inside: BoolArray = np.logical_xor.reduce(crosses & (x < at), axis=-1)
        return inside

    def _lie_on(self, places: FloatArray) -> BoolArray:
        """(m, n, f) whether places (m, n, 3) lie on the faces, borders included."""
        height = np.einsum("mnfk,fk->mnf", places[:, :, None] - self.origins, self.normals)
        xy = self._in_plane(places[:, :, None])
        a, b = self.corners, np.roll(self.corners, -1, axis=1)
        side = b - a
        offset = xy[..., None, :] - a
        square = np.einsum("fvk,fvk->fv", side, side)
        along = np.clip(np.einsum("...fvk,fvk->...fv", offset, side) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
        distance = np.linalg.norm(offset - along[..., None] * side, axis=-1).min(axis=-1)
        on: BoolArray = (np.abs(height) <= self.touch) & (self._inside(xy) | (distance <= self.touch))
        return on
