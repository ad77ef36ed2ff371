"""The bracket as a shape with sizes: a frame of four bars, a trapezoid symmetric about z_C."""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.bracket import EDGE_APEXES, Bracket
from rvdnav.pose.arrays import FloatArray

DIMENSIONS = ("long_base", "short_base", "height", "long_base_width", "short_base_width", "leg_width")
"""Of a trapezoid frame, in their order everywhere: the bases and the height between outer edges, the bars' widths."""

_STEP_M = 1e-6


@attrs.frozen
class Trapezoid:
    """Sizes of a trapezoid frame, m: outer lengths of l1 and l2, their distance, the widths of the bars along l1 and
    l2 and of both legs.  Any numbers: whether they make a bracket is for `bracket` to say."""

    long_base: float
    short_base: float
    height: float
    long_base_width: float
    short_base_width: float
    leg_width: float

    @classmethod
    def of(cls, sizes: FloatArray) -> Trapezoid:
        """From an array (6,) in the order of `DIMENSIONS`."""
        return cls(*(float(size) for size in sizes))

    @property
    def sizes(self) -> FloatArray:
        """As an array (6,) in the order of `DIMENSIONS`."""
        return np.array(attrs.astuple(self))

    @property
    def apexes(self) -> tuple[FloatArray, FloatArray]:
        """P1..P4 (4, 3) and Q1..Q4 (4, 3) in the capture frame C, m."""
        outer, inner = _apexes(self.sizes)
        return outer, inner

    @property
    def edge_points(self) -> FloatArray:
        """End points (8, 2, 3) of the front edges, in the order of `EDGE_NAMES`, m in C."""
        return _edge_points(self.sizes)

    @staticmethod
    def edges_of(sizes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """`edge_points` of sizes (6,), and their derivatives (8, 2, 3, 6) with respect to them."""
        steps = _STEP_M * np.eye(len(sizes))
        points = _edge_points(np.concatenate([sizes[None], sizes + steps, sizes - steps]))
        derivatives = (points[1 : 1 + len(sizes)] - points[1 + len(sizes) :]) / (2.0 * _STEP_M)
        return points[0], np.moveaxis(derivatives, 0, -1)

    def bracket(self, thickness: float) -> Bracket:
        """The bracket of these sizes with bars of that thickness, m.  Raises ValueError where they make none."""
        return Bracket(*self.apexes, thickness)


def _apexes(sizes: FloatArray) -> FloatArray:
    """P1..P4 and Q1..Q4 (2, ..., 4, 3) of sizes (..., 6)."""
    long_base, short_base, height, long_width, short_width, leg_width = np.moveaxis(sizes, -1, 0)
    slope = 0.5 * (long_base - short_base) / height
    across = leg_width * np.hypot(1.0, slope)
    inner_low, inner_high = (0.5 * long_base - slope * z - across for z in (long_width, height - short_width))
    y = np.stack([np.stack([0.5 * long_base, 0.5 * short_base]), np.stack([inner_low, inner_high])])
    z = np.stack([np.stack([0.0 * height, height]), np.stack([long_width, height - short_width])])
    apexes = np.zeros((2, *sizes.shape[:-1], 4, 3))
    for corner, (end, sign) in enumerate(((0, -1.0), (0, 1.0), (1, 1.0), (1, -1.0))):
        apexes[..., corner, 1] = sign * y[:, end]
        apexes[..., corner, 2] = z[:, end]
    return apexes


def _edge_points(sizes: FloatArray) -> FloatArray:
    """End points (..., 8, 2, 3) of the front edges for sizes (..., 6)."""
    ends = np.array(EDGE_APEXES)
    outer, inner = _apexes(sizes)
    points = np.stack([outer[..., ends, :], inner[..., ends, :]], axis=-3)
    # (..., bar, side, end, 3) in the order of bars, each outer before inner.
    edges: FloatArray = points.reshape(*points.shape[:-4], 8, 2, 3)
    return edges
