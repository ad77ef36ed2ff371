"""Robust losses of the refinement: weights, costs and the robust scale.

`norms` (m,) are the lengths of whitened blocks of two residuals, without unit: the endpoint distances of a line, which
is trusted or rejected as a whole.
Reference: P. J. Huber and E. M. Ronchetti, "Robust Statistics", 2nd ed. (2009), chapters 4-7.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.errors import PoseError

Loss = Literal["tukey", "huber"]

# Bounds that make the losses 95 % efficient at a normal distribution.
EFFICIENT_K: dict[Loss, float] = {"tukey": 4.685, "huber": 1.345}
_COMPONENTS = 2
# Median length of a standard normal vector of two components.
_MEDIAN_NORM = 1.1774100225154747


def robust_scale(norms: FloatArray, floor: float) -> float:
    """Scale of the blocks' noise from their median length, 1 if the blocks are standard normal; at least `floor`."""
    ordered = np.sort(norms)
    middle = len(ordered) // 2
    return max(0.5 * float(ordered[middle] + ordered[-1 - middle]) / _MEDIAN_NORM, floor)


def weights(norms: FloatArray, loss: Loss, k: float, scale: float) -> FloatArray:
    """Weights (m,) in [0, 1] of iteratively reweighted least squares."""
    u = norms / (k * scale)
    if loss == "huber":
        return 1.0 / np.maximum(u, 1.0)
    return np.maximum(1.0 - u * u, 0.0) ** 2


def cost(norms: FloatArray, loss: Loss, k: float, scale: float) -> float:
    """Sum of the loss over all blocks, in units of squared norm."""
    bound = k * scale
    u = norms / bound
    if loss == "huber":
        inside = np.minimum(u, 1.0)
        rho = inside * (u - 0.5 * inside)
    else:
        inside = np.maximum(1.0 - u * u, 0.0)
        rho = (1.0 - inside * inside * inside) / 6.0
    return float(rho.sum()) * bound * bound


def response(norms: FloatArray, loss: Loss, k: float, scale: float) -> float:
    """By how much a weighted mean under this loss answers to a small common shift, as a fraction of its weight.

    It is sum(psi') / sum(w) with psi = w r, the factor between the weighted normal matrix and the loss's mean
    curvature.  A covariance that leaves it out is too small by its square.  The curvature of a block that is nearly
    rejected is negative; the bounds keep a heavily contaminated set from giving a meaningless factor.
    Raises PoseError where no residual has any weight left.
    """
    u = norms / (k * scale)
    if loss == "huber":
        w = 1.0 / np.maximum(u, 1.0)
        change = np.where(u > 1.0, -w, 0.0)
    else:
        inside = np.maximum(1.0 - u * u, 0.0)
        w, change = inside**2, -4.0 * u * u * inside
    total = float(w.sum())
    if not total > 0.0:
        raise PoseError("no measurement agrees with the pose")
    # change: |r| w'(|r|), what psi' has beyond w, in one of the block's two directions.
    return min(max(1.0 + float(change.sum()) / (_COMPONENTS * total), 0.4), 1.0)
