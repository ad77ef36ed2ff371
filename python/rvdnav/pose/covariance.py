"""Covariance of a refined pose, with the errors that all samples of an edge share.

Model of the whitened residuals at the truth: white noise of variance omega², and for each cluster, that is each edge in
each camera, a common offset of variance sigma_o² and a tilt (linear along the edge) of variance sigma_t², in px².
Blur, the pixel grid, the remains of lens calibration and an edge that is not where the model says move whole edges;
hundreds of samples do not average that away, so sigma0² H⁻¹ alone would be far too small.

Write H = sum w J Jᵀ, and for cluster e the patterns z_o = 1/sigma, z_t = s/sigma (s: place along the edge, centred,
ends near ±1) with N = sum w z² and C = sum w z J / N.  Then

    covariance = H⁻¹ (omega² H + sum_e sigma_o² N_o² C_o C_oᵀ + sigma_t² N_t² C_t C_tᵀ) H⁻¹,

the cluster (sandwich) covariance whose middle part uses the variances common to all clusters instead of each cluster's
own residuals: these are too few (16 for a bracket) for a 6x6 matrix, and they shrink in the fit.  The first term alone
is the a-posteriori scaled inverse information.  omega² comes from the scatter about the line within each edge.
sigma_o² and sigma_t² solve the moment equations of the weighted sums of squares of the clusters' offsets and tilts
left after the fit, whose expectation follows from the projector of the reduced problem I - C H⁻¹ Cᵀ N; negative ones
are zero.  With nu degrees of freedom left, a variance is multiplied by nu/(nu - 2), which makes the expected
normalised squared error right in spite of the variance's own uncertainty.  The residuals are divided by the loss's
response, which undoes the shrinking by robust weights.
References: B. R. Moulton, "Random group effects and the precision of regression estimates" (1986); S. R. Searle,
G. Casella, C. E. McCulloch, "Variance Components" (1992), chapter 5; Huber and Ronchetti (2009), chapter 7.
"""

from __future__ import annotations

import numpy as np

from rvdnav.pose.arrays import FloatArray, IntArray
from rvdnav.pose.gauss_newton import GaussNewtonSolution

# Scatter below this fraction of the stated sigma is not believed; so the covariance of exact data is positive definite.
_MIN_OMEGA = 0.1
# With less redundancy than this a variance cannot be seen in the residuals.
_MIN_REDUNDANCY = 2.0


def clustered_covariance(
    solution: GaussNewtonSolution, cluster: IntArray, along: FloatArray, sigma: FloatArray
) -> FloatArray:
    """Covariance (6, 6) of the pose, order (position, rotation) in W, m², m·rad, rad²; always positive definite.

    cluster (n,): numbers 0..G-1 of each sample's edge and camera.  along (n,): px along that edge.  sigma (n,): px.
    """
    H_inverse = solution.inverse
    N, C, offsets, omega_squared = _reduce(solution, cluster, along, sigma)
    unseen = float(np.median(sigma)) ** 2
    variances = _edge_variances(N, C, offsets, H_inverse, omega_squared, unseen)
    scores = (N[:, :, None] * C * np.sqrt(variances)[:, None, None]).reshape(-1, 6)
    covariance = H_inverse @ (omega_squared * solution.normal_matrix + scores.T @ scores) @ H_inverse
    symmetric: FloatArray = (covariance + covariance.T) / 2.0
    return symmetric


def white_covariance(solution: GaussNewtonSolution, min_omega: float) -> FloatArray:
    """Covariance (6, 6) for independent blocks: omega² H⁻¹, with the a-posteriori omega, at least `min_omega`."""
    components = solution.residuals.shape[1]
    redundancy = max(components * float(solution.weights.sum()) - 6.0, 1.0)
    squares = (solution.weights[:, None] * solution.residuals / solution.response) ** 2
    omega_squared = max(float(squares.sum()) / redundancy, min_omega**2)
    covariance: FloatArray = omega_squared * solution.inverse
    return covariance


def _reduce(
    solution: GaussNewtonSolution, cluster: IntArray, along: FloatArray, sigma: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, float]:
    """N (2, G), C (2, G, 6), the clusters' offset and tilt (2, G) in px, and omega²."""
    w, residuals = solution.weights, solution.residuals[:, 0] / solution.response
    member = (cluster == np.arange(cluster.max() + 1)[:, None]).astype(np.float64)
    mass = w / sigma**2
    place = along - _divide(member @ (mass * along), member @ mass)[cluster]
    reach = np.max(member * np.abs(place), axis=1)
    place = place / np.maximum(reach, 1.0)[cluster]
    patterns = np.stack([1.0 / sigma, place / sigma])
    N, C, coefficients = [], [], []
    for z in patterns:
        N.append(member @ (w * z * z))
        C.append(_divide(member @ ((w * z)[:, None] * solution.jacobians[:, 0, :]), N[-1][:, None]))
        coefficients.append(_divide(member @ (w * z * residuals), N[-1]))
    fitted = sum(c[cluster] * z for c, z in zip(coefficients, patterns, strict=True))
    redundancy = max(float(w.sum()) - sum(np.count_nonzero(n) for n in N), 1.0)
    omega_squared = max(float(np.sum((w * (residuals - fitted)) ** 2)) / redundancy, _MIN_OMEGA**2)
    return np.stack(N), np.stack(C), np.stack(coefficients), omega_squared


def _divide(numerator: FloatArray, denominator: FloatArray) -> FloatArray:
    """Quotient, zero where the denominator is: a cluster of which every sample was rejected carries nothing."""
    quotient: FloatArray = np.divide(numerator, denominator, out=np.zeros_like(numerator), where=denominator > 0.0)
    return quotient


def _edge_variances(
    N: FloatArray, C: FloatArray, coefficients: FloatArray, H_inverse: FloatArray, omega_squared: float, unseen: float
) -> FloatArray:
    """Variances (2,) of the clusters' offsets and tilts, px², from what the fit left of them.

    A variance without redundancy cannot be seen: then it is taken to be at least `unseen`.
    """
    clusters = N.shape[1]
    mass, design = N.ravel(), C.reshape(-1, 6)
    used = mass > 0.0
    projector = np.diag(used.astype(np.float64)) - design @ H_inverse @ (design * mass[:, None]).T
    # leverage[i, j]: share of coefficient j's variance in the square of residual coefficient i, times its mass.
    leverage = mass[:, None] * projector**2
    kind = np.repeat([[1.0, 0.0], [0.0, 1.0]], clusters, axis=1)
    white = leverage @ _divide(np.ones_like(mass), mass)
    sums = kind @ (mass * coefficients.ravel() ** 2 - omega_squared * white)
    matrix = kind @ leverage @ kind.T
    redundancy = kind @ np.diagonal(projector)
    variances = _non_negative_solution(matrix, sums)
    freedom = np.maximum(redundancy, 3.0)
    seen = variances * freedom / (freedom - 2.0)
    return np.where(redundancy < _MIN_REDUNDANCY, np.maximum(variances, unseen), seen)


def _non_negative_solution(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """The two variances of the moment equations; where one comes out negative it is zero and the other stands alone."""
    solution = np.asarray(np.linalg.lstsq(matrix, right, rcond=1e-9)[0], dtype=np.float64)
    if solution.min() < 0.0:
        kept = int(np.argmax(solution))
        solution = np.zeros(2)
        if matrix[kept, kept] > 0.0:
            solution[kept] = max(right[kept] / matrix[kept, kept], 0.0)
    return solution
