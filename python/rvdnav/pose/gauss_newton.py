"""Robust Gauss-Newton on a pose, or on a pose and more: the solver of the refinement."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np
from attrs import frozen

from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.errors import PoseError
from rvdnav.pose.loss import EFFICIENT_K, Loss, cost, response, robust_scale, weights

Estimate = TypeVar("Estimate")
"""What is sought: a pose (4, 4), or that and sizes."""

# Steps are measured in standard deviations of the estimate: sqrt(stepᵀ H step) / scale.
_CONVERGED_STEP = 1e-4
_START_STEP = 0.3
_START_ITERATIONS = 8
_MAX_ITERATIONS = 20
_DAMPING = (0.0, 1e-3, 1e-2, 1e-1, 1.0, 10.0, 1e2)
# Largest condition number of the normal matrix scaled to unit diagonal.
_MAX_CONDITION = 1e8


@frozen(eq=False)
class Prior(Generic[Estimate]):
    """What is known of the last q parameters beside the blocks.

    deviation: of an estimate's parameters from what was expected of them (q,).  information (q, q): the inverse of that
    expectation's covariance, positive definite.
    """

    deviation: Callable[[Estimate], FloatArray]
    information: FloatArray


@frozen(eq=False)
class GaussNewtonSolution(Generic[Estimate]):
    """The minimum that was found: the estimate, the whitened blocks there (m, 2) with their derivatives (m, 2, p) by
    its p parameters and weights (m,), the inverse (p, p) of the normal matrix sum(w Jᵀ J) and the prior's information,
    the loss's response (see `loss.response`) and how it went."""

    estimate: Estimate
    residuals: FloatArray
    jacobians: FloatArray
    weights: FloatArray
    inverse: FloatArray
    response: float
    iterations: int
    converged: bool


def minimise(
    start: Estimate,
    evaluate: Callable[[Estimate], tuple[FloatArray, FloatArray]],
    move: Callable[[Estimate, FloatArray], Estimate],
    *,
    loss: Loss,
    k: float | None,
    scale_floor: float,
    near: bool,
    prior: Prior[Estimate] | None = None,
) -> GaussNewtonSolution[Estimate]:
    """The estimate that minimises the robust loss of the blocks, from a start on.

    evaluate: residual blocks (m, 2), whitened, and their derivatives (m, 2, p).  move: the estimate changed by a step
    (p,) of the parameters that the derivatives are taken by.  prior: adds half the square of the deviation, in the
    metric of its information.

    Tukey's loss is not convex, so the start is Huber's loss with the scale taken anew in every step; then the asked
    loss takes over and the scale is held, which makes the cost one function that every accepted step lowers.  From an
    estimate that is known to be near the minimum (`near`), that start is left out.  A step that raises the cost is
    damped (Levenberg-Marquardt).  Raises PoseError if the blocks do not determine the estimate or `evaluate` raises it
    at the start.
    """
    estimate = start
    residuals, jacobians = evaluate(estimate)
    norms = _norms(residuals)
    asked_k = EFFICIENT_K[loss] if k is None else k
    phase: Loss = "huber"
    phase_k, scale = EFFICIENT_K["huber"], scale_floor
    if near:
        scale = robust_scale(norms, scale_floor)
        phase, phase_k = loss, asked_k
    starting, iterations, converged = not near, 0, False
    while iterations < _MAX_ITERATIONS and not converged:
        if starting:
            scale = robust_scale(norms, scale_floor)
        w = weights(norms, phase, phase_k, scale)
        normal_matrix, gradient = _normal_equations(residuals, jacobians, w)
        # The loss curves less than its weights say; without this the steps are too short and convergence is slow.
        gradient /= response(norms, phase, phase_k, scale)
        _add_prior(normal_matrix, gradient, prior, estimate)
        system = _System.of(normal_matrix, 0 if prior is None else len(prior.information))
        before = cost(norms, phase, phase_k, scale) + _prior_cost(prior, estimate)
        for damping in _DAMPING:
            step = -system.solve(gradient, damping)
            length = float(np.sqrt(step @ normal_matrix @ step)) / scale
            moved = move(estimate, step)
            trial = _try(evaluate, moved)
            if trial is None:
                continue
            trial_norms = _norms(trial[0])
            # A step this short is at the rounding of the cost, where comparing costs says nothing.
            after = cost(trial_norms, phase, phase_k, scale) + _prior_cost(prior, moved)
            if length < _CONVERGED_STEP or after <= before:
                estimate, norms = moved, trial_norms
                residuals, jacobians = trial
                break
        else:
            break
        iterations += 1
        if not starting:
            converged = length < _CONVERGED_STEP
        elif length < _START_STEP or iterations == _START_ITERATIONS:
            scale = robust_scale(norms, scale_floor)
            phase, phase_k, starting = loss, asked_k, False
    w = weights(norms, phase, phase_k, scale)
    normal_matrix, gradient = _normal_equations(residuals, jacobians, w)
    _add_prior(normal_matrix, gradient, prior, estimate)
    return GaussNewtonSolution(
        estimate=estimate,
        residuals=residuals,
        jacobians=jacobians,
        weights=w,
        inverse=_System.of(normal_matrix, 0 if prior is None else len(prior.information)).inverse(),
        response=response(norms, phase, phase_k, scale),
        iterations=iterations,
        converged=converged,
    )


def _norms(residuals: FloatArray) -> FloatArray:
    norms: FloatArray = np.sqrt(np.einsum("md,md->m", residuals, residuals))
    return norms


def _normal_equations(residuals: FloatArray, jacobians: FloatArray, w: FloatArray) -> tuple[FloatArray, FloatArray]:
    parameters = jacobians.shape[-1]
    rows = jacobians.reshape(-1, parameters)
    weighted = (jacobians * w[:, None, None]).reshape(-1, parameters)
    return weighted.T @ rows, weighted.T @ residuals.ravel()


def _add_prior(
    normal_matrix: FloatArray, gradient: FloatArray, prior: Prior[Estimate] | None, estimate: Estimate
) -> None:
    if prior is None:
        return
    last = slice(len(gradient) - len(prior.information), None)
    normal_matrix[last, last] += prior.information
    gradient[last] += prior.information @ prior.deviation(estimate)


def _prior_cost(prior: Prior[Estimate] | None, estimate: Estimate) -> float:
    if prior is None:
        return 0.0
    deviation = prior.deviation(estimate)
    return 0.5 * float(deviation @ prior.information @ deviation)


@frozen(eq=False)
class _System:
    """Normal equations of which the last q parameters, those with a prior, are eliminated first: it makes them
    definite.

    units (f,): of the free parameters, in which what remains of the normal matrix has a unit diagonal; its eigenvalues
    and -vectors there.  known (q, q): the inverse of the eliminated block.  mixed (q, f): that times the mixed block.
    Metres and radians differ in scale by the distance; only in such units does a condition number say something.
    """

    units: FloatArray
    eigenvalues: FloatArray
    eigenvectors: FloatArray
    known: FloatArray
    mixed: FloatArray

    @classmethod
    def of(cls, normal_matrix: FloatArray, last: int) -> _System:
        """Raises PoseError if what remains is singular or nearly so."""
        free = len(normal_matrix) - last
        A, B, C = normal_matrix[:free, :free], normal_matrix[free:, :free], normal_matrix[free:, free:]
        known: FloatArray = np.asarray(np.linalg.inv(C) if last else C, np.float64)
        mixed = known @ B
        reduced = A - B.T @ mixed
        diagonal = np.diagonal(reduced)
        if (diagonal > 0.0).all():
            units = 1.0 / np.sqrt(diagonal)
            eigenvalues, eigenvectors = np.linalg.eigh(reduced * (units[:, None] * units))
            if eigenvalues[0] * _MAX_CONDITION > eigenvalues[-1]:
                return cls(units, eigenvalues, eigenvectors, known, mixed)
        raise PoseError("the measurements do not determine the pose")

    def solve(self, right: FloatArray, damping: float) -> FloatArray:
        """The solution (f + q,) for a right-hand side, the free parameters' directions damped."""
        free = len(self.units)
        along = self.eigenvectors.T @ (self.units * (right[:free] - self.mixed.T @ right[free:]))
        first = self.units * (self.eigenvectors @ (along / (self.eigenvalues + damping)))
        solution: FloatArray = np.concatenate([first, self.known @ right[free:] - self.mixed @ first])
        return solution

    def inverse(self) -> FloatArray:
        """Of the whole normal matrix (f + q, f + q)."""
        root = self.units[:, None] * self.eigenvectors / np.sqrt(self.eigenvalues)
        first = root @ root.T
        mixed = -self.mixed @ first
        inverse: FloatArray = np.block([[first, mixed.T], [mixed, self.known - mixed @ self.mixed.T]])
        return inverse


def _try(
    evaluate: Callable[[Estimate], tuple[FloatArray, FloatArray]], estimate: Estimate
) -> tuple[FloatArray, FloatArray] | None:
    try:
        return evaluate(estimate)
    except PoseError:
        return None
