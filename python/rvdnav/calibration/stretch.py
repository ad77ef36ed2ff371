"""Whether the board's squares are square: a fault of the print that the views show, unlike its scale."""

from __future__ import annotations

import numpy as np

from rvdnav.calibration.adjustment import Adjustment, adjust
from rvdnav.pose.arrays import FloatArray

_STEP = 1e-3


def board_stretch(adjustment: Adjustment, points_B: FloatArray, uv: FloatArray) -> tuple[float, float]:
    """By how much, as a share, the squares are wider than high, and its sigma.

    adjustment: over the board's points_B (n, 3), m, and their pixels uv (v, 2, n, 2).  A parabola through the sums of
    squares of three boards stretched along x gives both.  Views of a board in one orientation leave it undetermined,
    with an infinite sigma.
    """
    costs = []
    for stretch in (-_STEP, 0.0, _STEP):
        stretched = adjust(adjustment.model, points_B * (1.0 + stretch, 1.0, 1.0), uv)
        costs.append(float(np.nansum(stretched.residuals**2)))
    curvature = (costs[0] - 2.0 * costs[1] + costs[2]) / _STEP**2
    slope = (costs[2] - costs[0]) / (2.0 * _STEP)
    if not curvature > 0.0:
        return 0.0, float("inf")
    variance = adjustment.sigma_px**2 * adjustment.correlation
    return -slope / curvature, float(np.sqrt(2.0 * variance / curvature))
