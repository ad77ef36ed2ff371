"""Robust losses of the refinement: weights, costs and the robust scale.

A block is what is trusted or rejected as a whole: one scalar residual of an edge sample (d = 1) or both endpoint
distances of a line (d = 2).  `norms` (m,) are the lengths of the whitened blocks, without unit.
Reference: P. J. Huber and E. M. Ronchetti, "Robust Statistics", 2nd ed. (2009), chapters 4-7.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from rvdnav.pose.arrays import FloatArray

Loss = Literal["tukey", "huber"]

# Bounds that make the losses 95 % efficient at a normal distribution.
EFFICIENT_K: dict[Loss, float] = {"tukey": 4.685, "huber": 1.345}
# Median length of a standard normal vector of d components, d = 1, 2.
_MEDIAN_NORM = {1: 0.6744897501960817, 2: 1.1774100225154747}


def robust_scale(norms: FloatArray, components: int, floor: float) -> float:
    """Scale of the blocks' noise from their median length, 1 if the blocks are standard normal; at least `floor`."""
    return max(float(np.median(norms)) / _MEDIAN_NORM[components], floor)


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
        rho = np.where(u <= 1.0, 0.5 * u * u, u - 0.5)
    else:
        rho = (1.0 - np.maximum(1.0 - u * u, 0.0) ** 3) / 6.0
    return float(rho.sum()) * bound * bound


def response(norms: FloatArray, components: int, loss: Loss, k: float, scale: float) -> float:
    """By how much a weighted mean under this loss answers to a small common shift, as a fraction of its weight.

    It is sum(psi') / sum(w) with psi = w r, the factor between the weighted normal matrix and the loss's mean
    curvature.  A covariance that leaves it out is too small by its square (about 0.69 for Tukey's loss on normal
    noise).  The curvature of a sample that is nearly rejected is negative; the bound keeps a heavily contaminated set
    from giving a meaningless factor.
    """
    w = weights(norms, loss, k, scale)
    u = norms / (k * scale)
    # |r| w'(|r|), what psi' has beyond w.
    change = np.where(u > 1.0, -w, 0.0) if loss == "huber" else -4.0 * u * u * np.maximum(1.0 - u * u, 0.0)
    return float(np.clip((w + change / components).sum() / w.sum(), 0.4, 1.0))
