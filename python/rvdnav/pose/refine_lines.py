"""Refinement of a pose over fitted lines: the coarse step where no edge samples exist yet.

The residuals of a line are the signed distances (px) of the projections of its edge's two endpoints a_C and b_C to the
measured line rho = x cos(theta) + y sin(theta), in rectified px from the principal point.
"""

from __future__ import annotations

import numpy as np
from attrs import Factory, field, frozen
from numpy.typing import ArrayLike

from rvdnav.pose.arrays import FloatArray, IntArray, float_array
from rvdnav.pose.cameras import RectifiedCameras, project_along
from rvdnav.pose.covariance import white_covariance
from rvdnav.pose.errors import PoseError
from rvdnav.pose.gauss_newton import minimise
from rvdnav.pose.loss import Loss
from rvdnav.pose.refine import RefinedPose, refined_pose

# Least independent part of an endpoint distance's standard deviation, px; an edge seen end-on has nothing else in its
# tilt.
_ENDPOINT_SIGMA = 0.02
# Largest one that is still noise rather than a wrong model, px.
_MAX_ENDPOINT_SIGMA = 1.0
_VARIANCE_ROUNDS = 2
_BISECTIONS = 12
# Lines are few and share six parameters with the pose, so their scatter alone would make a scale that is too small.
_SCALE_FLOOR = 1.0


def _index(values: ArrayLike) -> IntArray:
    return np.asarray(values, dtype=np.int64)


def _endpoints(values: ArrayLike) -> FloatArray:
    return float_array(values, None, 2, 3)


def _numbers(values: ArrayLike) -> FloatArray:
    return float_array(values, None)


def _covariances(values: ArrayLike) -> FloatArray:
    return float_array(values, None, 2, 2)


@frozen(eq=False)
class LineMeasurements:
    """Lines that were fitted to the images of known edges; arrays of one length n.

    camera (n,): 0 left, 1 right.  edge (n,): number of the edge.  endpoints_C (n, 2, 3): its endpoints, m, in C.
    rho (n,): px; theta (n,): rad, the line in rectified px from the principal point.  cov (n, 2, 2): covariance of
    (rho, theta), px², px·rad, rad².  shift_sigma (n,), px: standard deviation of a displacement of the whole line that
    its fit knows nothing of; 0 if not given.  Raises ValueError for lengths that differ or a number that is not finite.
    """

    camera: IntArray = field(converter=_index)
    edge: IntArray = field(converter=_index)
    endpoints_C: FloatArray = field(converter=_endpoints)
    rho: FloatArray = field(converter=_numbers)
    theta: FloatArray = field(converter=_numbers)
    cov: FloatArray = field(converter=_covariances)
    shift_sigma: FloatArray = field(
        default=Factory(lambda self: np.zeros(len(self.rho)), takes_self=True), converter=_numbers
    )

    def __attrs_post_init__(self) -> None:
        arrays = (self.camera, self.edge, self.endpoints_C, self.rho, self.theta, self.cov, self.shift_sigma)
        if len({len(array) for array in arrays}) != 1:
            raise ValueError("the arrays of line measurements differ in length")

    def __len__(self) -> int:
        return len(self.camera)


def line_residuals(
    T_world_target: FloatArray, lines: LineMeasurements, cameras: RectifiedCameras
) -> tuple[FloatArray, FloatArray]:
    """Distances (n, 2) px of the projected endpoints to their lines, with derivatives (n, 2, 6) to (dp, dtheta).

    Raises PoseError if an endpoint is not in front of its camera.
    """
    normals = np.repeat(np.column_stack([np.cos(lines.theta), np.sin(lines.theta)]), 2, axis=0)
    points = lines.endpoints_C.reshape(-1, 3)
    projected, derivative = project_along(cameras, np.repeat(lines.camera, 2), T_world_target, points, normals)
    return projected.reshape(-1, 2) - lines.rho[:, None], derivative.reshape(-1, 2, 6)


def refine_pose_lines(
    T_world_target: FloatArray,
    lines: LineMeasurements,
    cameras: RectifiedCameras,
    *,
    loss: Loss = "tukey",
    k: float | None = None,
    max_iterations: int = 20,
    endpoint_sigma: float = _ENDPOINT_SIGMA,
    near: bool = False,
) -> RefinedPose:
    """The pose that fits the lines best, from T_world_target (4, 4) on; a line is trusted or rejected as a whole.

    endpoint_sigma, px: standard deviation of what displaces each endpoint by itself, beside the lines' covariances.
    near: the start is known to be near the minimum, so outliers are told by it at once.
    The distances are whitened by all these, taken where the endpoints lie at the start.  The covariance of
    the result is omega² H⁻¹ with omega from the residuals, but at least 1: a line's own covariance knows only its fit.
    Raises PoseError if the lines do not determine the pose or the target is not in front of the cameras.
    """
    if len(lines) < 3:
        raise PoseError(f"{len(lines)} lines do not determine the pose")
    T = float_array(T_world_target, 4, 4)
    whitening = _whitening(T, lines, cameras, endpoint_sigma)

    def evaluate(T: FloatArray) -> tuple[FloatArray, FloatArray]:
        distances, derivatives = line_residuals(T, lines, cameras)
        return np.einsum("nij,nj->ni", whitening, distances), whitening @ derivatives

    solution = minimise(T, evaluate, loss=loss, k=k, scale_floor=_SCALE_FLOOR, max_iterations=max_iterations, near=near)
    distances, _ = line_residuals(solution.T, lines, cameras)
    keys = zip(lines.camera.tolist(), lines.edge.tolist(), strict=True)
    rms = np.sqrt(np.mean(distances**2, axis=1))
    return refined_pose(
        solution, white_covariance(solution, min_omega=1.0), distances, dict(zip(keys, rms.tolist(), strict=True))
    )


def refine_pose_edges(T_world_target: FloatArray, lines: LineMeasurements, cameras: RectifiedCameras) -> RefinedPose:
    """As `refine_pose_lines`, with the endpoint_sigma that the lines themselves show.

    Lens remains, aliasing and the model's own errors displace edges by more than their fits know.  Their variance is
    the one at which the weighted squares of the residuals come to their degrees of freedom, so weights and covariance
    follow the frame (R. C. Paule and J. Mandel, "Consensus values and weighting factors", 1982).
    """
    endpoint_sigma = 4.0 * _ENDPOINT_SIGMA
    T, near = T_world_target, False
    for _ in range(_VARIANCE_ROUNDS):
        pose = refine_pose_lines(T, lines, cameras, endpoint_sigma=endpoint_sigma, near=near)
        T, near = pose.T_world_target, True
        endpoint_sigma = _consistent_sigma(pose, lines, cameras)
    return refine_pose_lines(T, lines, cameras, endpoint_sigma=endpoint_sigma, near=near)


def _consistent_sigma(pose: RefinedPose, lines: LineMeasurements, cameras: RectifiedCameras) -> float:
    """The endpoint_sigma at which the residuals' weighted squares equal their degrees of freedom."""
    freedom = max(2.0 * float(pose.weights.sum()) - 6.0, 1.0)

    def excess(sigma: float) -> float:
        white = np.einsum("nij,nj->ni", _whitening(pose.T_world_target, lines, cameras, sigma), pose.residuals)
        return float(np.sum(pose.weights[:, None] * white**2)) / freedom - 1.0

    low, high = _ENDPOINT_SIGMA, _MAX_ENDPOINT_SIGMA
    if excess(low) <= 0.0:
        return low
    for _ in range(_BISECTIONS):
        middle = float(np.sqrt(low * high))
        low, high = (middle, high) if excess(middle) > 0.0 else (low, middle)
    return high


def _whitening(T: FloatArray, lines: LineMeasurements, cameras: RectifiedCameras, endpoint_sigma: float) -> FloatArray:
    """Matrices (n, 2, 2) that turn a line's two distances into independent ones of unit variance."""
    points_W = lines.endpoints_C.reshape(-1, 3) @ T[:3, :3].T + T[:3, 3]
    xy = cameras.project(np.repeat(lines.camera, 2), points_W).reshape(-1, 2, 2)
    along = xy[:, :, 1] * np.cos(lines.theta)[:, None] - xy[:, :, 0] * np.sin(lines.theta)[:, None]
    # distance = x cos(theta) + y sin(theta) - rho, so its derivatives are -1 by rho and `along` by theta.
    G = np.stack([-np.ones_like(along), along], axis=2)
    covariance = G @ lines.cov @ G.transpose(0, 2, 1) + endpoint_sigma**2 * np.eye(2)
    covariance = covariance + (lines.shift_sigma**2)[:, None, None]
    whitening: FloatArray = np.linalg.inv(np.linalg.cholesky(covariance))
    return whitening
