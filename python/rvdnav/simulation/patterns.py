"""Where inside its pixel each ray goes."""

from __future__ import annotations

import numpy as np

from rvdnav.pose.arrays import FloatArray

_PATTERNS = 2048


class PixelPatterns:
    """Patterns of `samples` points in a pixel, of which every pixel draws one.

    The largest square number n² of points is multi-jittered: one in each cell of an n x n grid, and one in each of n²
    columns and rows, which makes the coverage by an edge along rows or columns twice as exact as the grid alone does.
    The rest lie anywhere in the pixel.
    Method: K. Chiu, P. Shirley, C. Wang, "Multi-jittered sampling", Graphics Gems IV (1994).
    """

    def __init__(self, samples: int, rng: np.random.Generator) -> None:
        side = int(samples**0.5)
        cell = np.arange(side)
        # In every column of cells the points take different sub-columns, and likewise in every row.
        fine = rng.permuted(np.broadcast_to(cell, (2, _PATTERNS, side, side)), axis=-1)
        i, j = np.meshgrid(cell, cell, indexing="ij")
        regular = np.stack([i + (fine[0] + 0.5) / side, j + (fine[1].swapaxes(1, 2) + 0.5) / side]) / side
        regular += (rng.random(regular.shape) - 0.5) / side**2
        rest = rng.random((2, _PATTERNS, samples - side * side))
        self.points: FloatArray = np.concatenate([regular.reshape(2, _PATTERNS, -1), rest], axis=2) - 0.5
        """(2, patterns, samples), u and v off the pixel's centre, px in [-0.5, 0.5]."""

    def draw(self, shape: tuple[int, int], rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
        """u and v (h, w, samples) for an image of that shape."""
        which = rng.integers(_PATTERNS, size=shape)
        return self.points[0][which], self.points[1][which]
