"""What a refinement gives: the pose, its covariance, and what is left of the measurements."""

from __future__ import annotations

from typing import Any

import numpy as np
from attrs import frozen

from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.gauss_newton import GaussNewtonSolution
from rvdnav.pose.so3 import make_T, project_to_so3
from rvdnav.pose.systematics import JointInformation, Systematics

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
    z (p,): the systematics' parameters, in their stated standard deviations; joint_covariance (6 + p, 6 + p): of the
    pose and them.  scales: of the systematics' groups.  told: by the lines, of pose and parameters.
    displacement_px: standard deviation of what displaces each line by itself beyond its covariance.
    """

    T_world_target: FloatArray
    covariance: FloatArray
    residuals: FloatArray
    gain: FloatArray
    weights: FloatArray
    sigma0: float
    iterations: int
    converged: bool
    z: FloatArray
    joint_covariance: FloatArray
    scales: FloatArray
    told: JointInformation
    displacement_px: float


def redundancy(weights: FloatArray, parameters: float = _PARAMETERS) -> float:
    """Degrees of freedom that weighted lines (n,) leave beside the parameters: two a line, at least 1."""
    return max(2.0 * float(weights.sum()) - parameters, 1.0)


def weighted_rms(residuals: FloatArray, weights: FloatArray) -> float:
    """RMS of lines' residuals (n, 2), in their unit, with weights (n,)."""
    squares: FloatArray = weights[:, None] * residuals**2
    return float(np.sqrt(squares.sum() / max(2.0 * float(weights.sum()), 1e-12)))


def determined_parameters(solution: GaussNewtonSolution[Any]) -> float:
    """How many of the parameters the blocks determine rather than the prior: the trace of H⁻¹ sum(w Jᵀ J)."""
    J = solution.jacobians
    return float(np.einsum("n,nki,ij,nkj->", solution.weights, J, solution.inverse, J, optimize=True))


def unit_weight(solution: GaussNewtonSolution[Any]) -> tuple[float, float]:
    """omega² = sum(w² |r|²) / (c² (2 sum(w) - p)), but at least 1, and sigma0, the root of sum(w |r|²) / (2 sum(w) -
    p), over the whitened residuals r of p parameters.

    Of parameters with a prior p counts the part that the blocks determine.  The loss's response c undoes the shrinking
    by robust weights (Huber and Ronchetti, 2009, chapter 7).
    """
    w, freedom = solution.weights, redundancy(solution.weights, determined_parameters(solution))
    squares = np.einsum("nd,nd->n", solution.residuals, solution.residuals)
    omega_squared = float(w**2 @ squares) / (solution.response**2 * freedom)
    return max(omega_squared, _MIN_OMEGA_SQUARED), float(np.sqrt(w @ squares / freedom))


def refined_pose(
    solution: GaussNewtonSolution[tuple[FloatArray, FloatArray]],
    residuals: FloatArray,
    whitening: FloatArray,
    systematics: Systematics,
    displacement_px: float,
) -> RefinedPose:
    """The result that the solver's minimum stands for; residuals (n, 2) in px, and what whitened them (n, 2, 2).

    Its covariance is that of pose and systematics together, omega² H⁻¹ with the normal matrix H = sum(w Jᵀ J) and the
    systematics' prior, see `unit_weight`.
    """
    w = solution.weights
    omega_squared, sigma0 = unit_weight(solution)
    T, z = solution.estimate
    joint = omega_squared * solution.inverse
    return RefinedPose(
        T_world_target=make_T(project_to_so3(T[:3, :3]), T[:3, 3]),
        covariance=joint[:6, :6],
        residuals=residuals,
        gain=np.einsum("ij,nkj,nkl->inl", solution.inverse[:6], solution.jacobians, w[:, None, None] * whitening),
        weights=w,
        sigma0=sigma0,
        iterations=solution.iterations,
        converged=solution.converged,
        z=z,
        joint_covariance=joint,
        scales=systematics.scales,
        told=JointInformation.of(solution, z, omega_squared),
        displacement_px=displacement_px,
    )
