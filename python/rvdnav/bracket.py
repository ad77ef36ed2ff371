"""The four-bar bracket (yoke) as geometry: its apexes, its front edges, and whether they are consistent."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np
from numpy.typing import ArrayLike

from rvdnav.pose.arrays import FloatArray, float_array

EDGE_NAMES = ("l1_outer", "l1_inner", "l2_outer", "l2_inner", "l3_outer", "l3_inner", "l4_outer", "l4_inner")
"""Of the eight front edges, in their order everywhere."""

EDGE_APEXES = ((0, 1), (2, 3), (1, 2), (3, 0))
"""The two apexes of l1, l2, l3, l4, counted from 0: l1 runs P1 -> P2, l2 P3 -> P4, l3 P2 -> P3, l4 P4 -> P1."""

_FLATNESS = 0.01
"""Three neighbouring corners count as collinear when their triangle is lower than this fraction of the bracket."""


def tolerance(length: float) -> float:
    """How far a stated length (m) may be from the points': 0.1 mm or a thousandth, whichever is more."""
    return max(1e-4, 1e-3 * length)


def _apexes(values: ArrayLike) -> FloatArray:
    points: FloatArray = float_array(values, 4, 3).copy()
    points.setflags(write=False)
    return points


@attrs.frozen(eq=False)
class Bracket:
    """A planar quadrilateral frame of four flat bars, in the capture frame C, m.

    outer: P1..P4 (4, 3).  inner: Q1..Q4 (4, 3), Qi next to Pi.  Both lie in the front face, a plane x_C = const, and
    run from y_C towards z_C.  thickness: the bars reach back by it, towards +x_C.

    Raises ValueError where the points contradict this.
    """

    outer: FloatArray = attrs.field(converter=_apexes)
    inner: FloatArray = attrs.field(converter=_apexes)
    thickness: float

    def __attrs_post_init__(self) -> None:
        x = np.concatenate([self.outer, self.inner])[:, 0]
        for corners, names in ((self.outer, "P1..P4"), (self.inner, "Q1..Q4")):
            size = float(np.linalg.norm(corners[2:] - corners[:2], axis=1).max())  # the longer diagonal
            altitudes = _altitudes(corners)
            if np.abs(altitudes).min() <= _FLATNESS * size:
                raise ValueError(f"three of the bracket's points {names} are collinear")
            if np.ptp(x) > tolerance(size):
                raise ValueError("the bracket's front face does not lie in a plane x = const")
            if altitudes.min() < 0.0:
                raise ValueError(f"the bracket's points {names} do not run from y to z about +x in a convex loop")
        if self.bar_widths.min() <= 0.0:
            raise ValueError("the bracket's inner points do not lie inside its outer ones")

    @cached_property
    def edge_points(self) -> FloatArray:
        """End points (8, 2, 3) of the front edges, in the order of `EDGE_NAMES`, m in C."""
        return np.array([points[list(pair)] for pair in EDGE_APEXES for points in (self.outer, self.inner)])

    @property
    def bar_widths(self) -> FloatArray:
        """Distance (4, 2) of both inner points of l1, l2, l3, l4 from the outer line, m, positive inwards."""
        edges = self.edge_points
        start, along = edges[0::2, 0], edges[0::2, 1] - edges[0::2, 0]
        inwards = np.cross((1.0, 0.0, 0.0), along)
        inwards /= np.linalg.norm(inwards, axis=1, keepdims=True)
        widths: FloatArray = np.einsum("bpk,bk->bp", edges[1::2] - start[:, None], inwards)
        return widths

    @cached_property
    def side_normals(self) -> FloatArray:
        """Unit normals (8, 3) of the side faces at the front edges, in C: away from the other edge of the same bar."""
        start, end = self.edge_points[:, 0], self.edge_points[:, 1]
        along = end - start
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
        away = start - start[np.arange(len(start)) ^ 1]
        away = away - np.einsum("ki,ki->k", away, along)[:, None] * along
        normals: FloatArray = away / np.linalg.norm(away, axis=1, keepdims=True)
        return normals

    @property
    def long_base(self) -> float:
        """Length of l1, m."""
        return float(np.linalg.norm(self.outer[1] - self.outer[0]))

    @property
    def short_base(self) -> float:
        """Length of l2, m."""
        return float(np.linalg.norm(self.outer[3] - self.outer[2]))

    @property
    def heights(self) -> FloatArray:
        """Distance (2,) of P3 and of P4 from l1, m."""
        along = (self.outer[1] - self.outer[0]) / self.long_base
        distances: FloatArray = np.linalg.norm(np.cross(self.outer[2:] - self.outer[0], along), axis=1)
        return distances


def _altitudes(corners: FloatArray) -> FloatArray:
    """Smallest altitude (4,) of the triangle of each corner with its neighbours, m, positive for a turn from y to z."""
    before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
    normals = np.cross(corners - before, after - corners)
    sides = [corners - before, after - corners, before - after]
    longest = np.linalg.norm(sides, axis=2).max(axis=0)
    altitudes: FloatArray = np.linalg.norm(normals, axis=1) / longest * np.where(normals[:, 0] < 0.0, -1.0, 1.0)
    return altitudes
