"""What a refinement gives: the pose, its covariance, and what is left of the measurements."""

from __future__ import annotations

import numpy as np
from attrs import frozen

from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.gauss_newton import GaussNewtonSolution

_PARAMETERS = 6
# Lines are few and share six parameters with the pose, so their scatter alone would make a scale that is too small.
_MIN_OMEGA_SQUARED = 1.0


@frozen(eq=False)
class RefinedPose:
    """A refined pose and how far to trust it.

    T_world_target (4, 4).  covariance (6, 6): order (position, rotation) in W, p = p̂ + dp, R = exp([dtheta]x) R̂; m²,
    m·rad, rad²; positive definite.  residuals (n, 2), px: distances of the edges' endpoints from their lines.
    gain (6, n, 2), m/px and rad/px: a small change dr (n, 2) of the residuals moves the pose by -gain dr, in the order
    of the covariance, with the lines' weights held.  weights (n,) of the lines, in [0, 1].  sigma0: a-posteriori
    standard deviation of unit weight, the root of sum(w |r|²) / (2 sum(w) - 6) over the whitened residuals r.
    """

    T_world_target: FloatArray
    covariance: FloatArray
    residuals: FloatArray
    gain: FloatArray
    weights: FloatArray
    sigma0: float
    iterations: int
    converged: bool


def redundancy(weights: FloatArray) -> float:
    """Degrees of freedom that weighted lines (n,) leave beside the pose: two a line, at least 1."""
    return max(2.0 * float(weights.sum()) - _PARAMETERS, 1.0)


def refined_pose(solution: GaussNewtonSolution, residuals: FloatArray, whitening: FloatArray) -> RefinedPose:
    """The result that the solver's minimum stands for; residuals (n, 2) in px, and what whitened them (n, 2, 2).

    Its covariance is omega² H⁻¹ with the normal matrix H = sum(w Jᵀ J) and omega² = sum(w² |r|²) / (c² (2 sum(w) - 6)),
    but at least 1; the loss's response c undoes the shrinking by robust weights (Huber and Ronchetti, 2009, chapter 7).
    """
    w, freedom = solution.weights, redundancy(solution.weights)
    squares = np.einsum("nd,nd->n", solution.residuals, solution.residuals)
    omega_squared = float(w**2 @ squares) / (solution.response**2 * freedom)
    return RefinedPose(
        T_world_target=solution.T,
        covariance=max(omega_squared, _MIN_OMEGA_SQUARED) * solution.inverse,
        residuals=residuals,
        gain=np.einsum("ij,nkj,nkl->inl", solution.inverse, solution.jacobians, w[:, None, None] * whitening),
        weights=w,
        sigma0=float(np.sqrt(w @ squares / freedom)),
        iterations=solution.iterations,
        converged=solution.converged,
    )
