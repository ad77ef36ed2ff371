"""Refinement of a pose over edge samples of both views.

A sample is a place where an edge of the target was measured in a rectified image: from the projection of a known point
p_C of the edge the grey values were searched along the unit normal n, and the edge was found at q.  Its residual is

    r = n · (q - projection(R p_C + t))   [px],

so only the component across the edge counts.
"""

from __future__ import annotations

import numpy as np
from attrs import field, frozen
from numpy.typing import ArrayLike

from rvdnav.pose.arrays import FloatArray, IntArray, float_array
from rvdnav.pose.cameras import RectifiedCameras, project_along
from rvdnav.pose.covariance import clustered_covariance
from rvdnav.pose.errors import PoseError
from rvdnav.pose.gauss_newton import GaussNewtonSolution, minimise
from rvdnav.pose.loss import Loss

# The robust scale is never below this many stated sigmas, so that very clean frames don't reject good samples.
_SCALE_FLOOR = 0.5


def _index(values: ArrayLike) -> IntArray:
    return np.asarray(values, dtype=np.int64)


def _points(values: ArrayLike) -> FloatArray:
    return float_array(values, None, 3)


def _image_vectors(values: ArrayLike) -> FloatArray:
    return float_array(values, None, 2)


def _numbers(values: ArrayLike) -> FloatArray:
    return float_array(values, None)


@frozen(eq=False)
class EdgeSamples:
    """Measured places on the target's edges; arrays of one length n.

    camera (n,): 0 left, 1 right.  edge (n,): number of the edge.  p_C (n, 3): the point of the edge, m, in C.
    q (n, 2): where the edge was found, rectified px from the principal point.  n (n, 2): unit normal of the edge in the
    image, to the same side for all samples of an edge in a camera.  sigma (n,): standard deviation along n, px.
    Raises ValueError for lengths that differ, a number that is not finite or a sigma that is not positive.
    """

    camera: IntArray = field(converter=_index)
    edge: IntArray = field(converter=_index)
    p_C: FloatArray = field(converter=_points)
    q: FloatArray = field(converter=_image_vectors)
    n: FloatArray = field(converter=_image_vectors)
    sigma: FloatArray = field(converter=_numbers)

    def __attrs_post_init__(self) -> None:
        arrays = (self.camera, self.edge, self.p_C, self.q, self.n, self.sigma)
        if len({len(array) for array in arrays}) != 1:
            raise ValueError("the arrays of edge samples differ in length")
        if not (self.sigma > 0.0).all():
            raise ValueError("an edge sample's sigma must be positive")

    def __len__(self) -> int:
        return len(self.camera)


@frozen(eq=False)
class RefinedPose:
    """A refined pose and how far to trust it.

    T_world_target (4, 4).  covariance (6, 6): order (position, rotation) in W, p = p̂ + dp, R = exp([dtheta]x) R̂; m²,
    m·rad, rad²; positive definite.  information (6, 6): the weighted normal matrix for the stated sigmas, without any
    a-posteriori scale.  residuals: (n,) for samples, (n, 2) for lines' endpoints, px.  weights (n,) in [0, 1].
    sigma0: a-posteriori standard deviation of unit weight, sqrt(sum w r² / (sum w - 6)), of whitened residuals.
    edge_rms: RMS of all residuals of an edge, px, by (camera, edge); rejected ones count, the weights tell of them.
    """

    T_world_target: FloatArray
    covariance: FloatArray
    information: FloatArray
    residuals: FloatArray
    weights: FloatArray
    sigma0: float
    iterations: int
    converged: bool
    edge_rms: dict[tuple[int, int], float]


def edge_residuals(
    T_world_target: FloatArray, samples: EdgeSamples, cameras: RectifiedCameras
) -> tuple[FloatArray, FloatArray]:
    """Residuals (n,) px of the samples at a pose (4, 4), and their derivatives (n, 6) with respect to (dp, dtheta).

    Raises PoseError if a sample's point is not in front of its camera.
    """
    projected, derivative = project_along(cameras, samples.camera, T_world_target, samples.p_C, samples.n)
    return np.einsum("ni,ni->n", samples.n, samples.q) - projected, -derivative


def refine_pose(
    T_world_target: FloatArray,
    samples: EdgeSamples,
    cameras: RectifiedCameras,
    *,
    loss: Loss = "tukey",
    k: float | None = None,
    max_iterations: int = 20,
) -> RefinedPose:
    """The pose that fits the edge samples best, from T_world_target (4, 4) on.

    loss, k: the robust loss and its bound in robust standard deviations (4.685 for Tukey's, 1.345 for Huber's if not
    given).  The covariance is that of `rvdnav.pose.covariance`, with the samples of each edge in each camera as one
    cluster.
    Raises PoseError if the samples do not determine the pose (too few, or all on edges that leave a motion open) or if
    the target is not in front of the cameras.
    """
    if len(samples) < 6:
        raise PoseError(f"{len(samples)} edge samples do not determine the pose")

    def evaluate(T: FloatArray) -> tuple[FloatArray, FloatArray]:
        residuals, derivatives = edge_residuals(T, samples, cameras)
        return (residuals / samples.sigma)[:, None], (derivatives / samples.sigma[:, None])[:, None, :]

    T = float_array(T_world_target, 4, 4)
    solution = minimise(T, evaluate, loss=loss, k=k, scale_floor=_SCALE_FLOOR, max_iterations=max_iterations)
    _, first, cluster = np.unique(
        samples.camera * (samples.edge.max() + 1) + samples.edge, return_index=True, return_inverse=True
    )
    along = samples.q[:, 1] * samples.n[:, 0] - samples.q[:, 0] * samples.n[:, 1]
    residuals = solution.residuals[:, 0] * samples.sigma
    rms = np.sqrt(np.bincount(cluster, residuals**2) / np.bincount(cluster))
    keys = zip(samples.camera[first].tolist(), samples.edge[first].tolist(), strict=True)
    return refined_pose(
        solution,
        clustered_covariance(solution, cluster, along, samples.sigma),
        residuals,
        dict(zip(keys, rms.tolist(), strict=True)),
    )


def refined_pose(
    solution: GaussNewtonSolution,
    covariance: FloatArray,
    residuals: FloatArray,
    edge_rms: dict[tuple[int, int], float],
) -> RefinedPose:
    """The result that the solver's minimum stands for; residuals in px."""
    w = solution.weights
    redundancy = max(solution.residuals.shape[1] * float(w.sum()) - 6.0, 1.0)
    return RefinedPose(
        T_world_target=solution.T,
        covariance=covariance,
        information=solution.normal_matrix,
        residuals=residuals,
        weights=w,
        sigma0=float(np.sqrt(np.sum(w[:, None] * solution.residuals**2) / redundancy)),
        iterations=solution.iterations,
        converged=solution.converged,
        edge_rms=edge_rms,
    )
