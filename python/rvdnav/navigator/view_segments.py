"""A view's straight segments as arrays, and how each lies to every other."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.pose.arrays import FloatArray, IntArray

# Pieces of one line: rad, px across, and the largest gap as a part of the whole.
_SAME_ANGLE = 0.04
_SAME_LINE_PX = 1.5
_MAX_GAP = 0.3
# Joined lines this near to each other, px across and at their ends, are one.
_ALIKE_PX = 1.0
_ALIKE_ENDS_PX = 6.0


@attrs.frozen(eq=False)
class Segments:
    """Segments of a rectified view; arrays of one length n.

    rho (n,), px, and theta (n,), rad: their lines.  ends (n, 2): places along the lines, px, the lower first.
    polarity (n,): +1 brighter towards growing rho, -1 darker.
    """

    rho: FloatArray
    theta: FloatArray
    ends: FloatArray
    polarity: IntArray

    @classmethod
    def of(cls, records: NDArray[np.void]) -> Segments:
        """From SEGMENT records."""
        ends = np.column_stack([records["t_min"], records["t_max"]])
        return cls(records["rho"].copy(), records["theta"].copy(), ends, records["polarity"].astype(np.int64))

    @property
    def normal(self) -> FloatArray:
        """Unit normals (n, 2)."""
        return np.column_stack([np.cos(self.theta), np.sin(self.theta)])

    @property
    def tangent(self) -> FloatArray:
        """Unit tangents (n, 2), along which the places grow."""
        return np.column_stack([-np.sin(self.theta), np.cos(self.theta)])

    @property
    def length(self) -> FloatArray:
        """(n,) px."""
        length: FloatArray = self.ends[:, 1] - self.ends[:, 0]
        return length

    @property
    def end_points(self) -> FloatArray:
        """(n, 2, 2) px."""
        return self.rho[:, None, None] * self.normal[:, None] + self.ends[:, :, None] * self.tangent[:, None]

    def aligned(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Of every pair (i, j): +1 or -1 as their normals agree, sine of the angle between them, j's ends along i
        (n, n, 2), the lower first, and the distance of j's middle from i's line along i's normal."""
        cosine = self.normal @ self.normal.T
        sine = self.tangent @ self.normal.T
        points = self.end_points
        along = np.einsum("ia,jea->ije", self.tangent, points)
        across = (points.mean(axis=1) @ self.normal.T).T - self.rho[:, None]
        return np.where(cosine < 0.0, -1.0, 1.0), sine, np.sort(along, axis=2), across

    def with_joined(self) -> Segments:
        """These, and each two pieces of one line as one more."""
        sign, sine, along, across = self.aligned()
        low = np.minimum(self.ends[:, None, 0], along[..., 0])
        high = np.maximum(self.ends[:, None, 1], along[..., 1])
        gap = (high - low) - self.length[:, None] - (along[..., 1] - along[..., 0])
        piece = (np.abs(sine) < _SAME_ANGLE) & (np.abs(across) < _SAME_LINE_PX)
        piece &= (gap > 0.0) & (gap < _MAX_GAP * (high - low))
        piece &= sign * self.polarity[:, None] * self.polarity > 0
        i, j = np.nonzero(np.triu(piece, 1))
        if len(i) == 0:
            return self
        # Through the middles of both pieces.
        a, b = (self.end_points[k].mean(axis=1) for k in (i, j))
        backwards = np.einsum("ni,ni->n", b - a, self.tangent[i]) < 0.0
        d = np.where(backwards[:, None], a - b, b - a)
        theta = np.arctan2(-d[:, 0], d[:, 1])
        bare = Segments(np.zeros(len(i)), theta, np.zeros((len(i), 2)), self.polarity[i])
        points = np.concatenate([self.end_points[i], self.end_points[j]], axis=1)
        places = np.einsum("nea,na->ne", points, bare.tangent)
        rho, ends = np.einsum("na,na->n", bare.normal, a), np.column_stack([places.min(axis=1), places.max(axis=1)])
        # Many pieces of one line join to nearly the same; one of these is enough.
        alike = np.column_stack([rho / _ALIKE_PX, theta / _SAME_ANGLE, ends / _ALIKE_ENDS_PX, bare.polarity]).round()
        _, kept = np.unique(alike, axis=0, return_index=True)
        return Segments(
            np.concatenate([self.rho, rho[kept]]),
            np.concatenate([self.theta, theta[kept]]),
            np.concatenate([self.ends, ends[kept]]),
            np.concatenate([self.polarity, bare.polarity[kept]]),
        )
