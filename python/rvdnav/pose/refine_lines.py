"""Refinement of a pose over lines that were fitted to the images of the target's edges.

The residuals of a line are the signed distances (px) of the projections of its edge's two endpoints a_C and b_C to the
measured line rho = x cos(theta) + y sin(theta), in rectified px from the principal point.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from attrs import Factory, field, frozen
from numpy.typing import ArrayLike

from rvdnav.pose.arrays import FloatArray, IntArray, float_array
from rvdnav.pose.cameras import DirectedPoints, RectifiedCameras
from rvdnav.pose.errors import PoseError
from rvdnav.pose.gauss_newton import GaussNewtonSolution, Prior, minimise
from rvdnav.pose.loss import Loss
from rvdnav.pose.refined import RefinedPose, refined_pose
from rvdnav.pose.so3 import perturb
from rvdnav.pose.systematics import Systematics

# Least standard deviation of what displaces an endpoint by itself, px; an edge seen end-on has only this in its tilt.
ENDPOINT_SIGMA = 0.02
MIN_DISPLACEMENT = ENDPOINT_SIGMA / math.sqrt(2.0)
"""The same as offset and as tilt: the least that the lines are taken to show, px."""
MAX_DISPLACEMENT = 0.7
"""The largest that is still noise rather than a wrong model, px."""
# Where the search for them begins: large, so that edges displaced alike are not taken for outliers of a few that agree.
START_SIGMA = 0.15
VARIANCE_ROUNDS = 2
# Where the scale of what the lines share is sought too, that begins as large as it can be and the displacement small:
# what many lines have in common is otherwise taken for a displacement of each, which explains it as well, and stays.
# Both are taken anew at most so often, until none changes by more than this part.
_START_BESIDE_SHARED = 0.05
_MOST_VARIANCE_ROUNDS = 12
_SETTLED = 0.05
_BISECTIONS = 12
# The robust scale is never below this many stated sigmas: so few lines can agree closely by chance.
SCALE_FLOOR = 1.0


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


@frozen
class Displacement:
    """Standard deviations, px, of what displaces lines beyond their covariances: offset of a whole line, tilt of its
    ends in opposite directions."""

    offset: float
    tilt: float


def line_residuals(
    T_world_target: FloatArray, lines: LineMeasurements, cameras: RectifiedCameras
) -> tuple[FloatArray, FloatArray]:
    """Distances (n, 2) px of the projected endpoints to their lines, with derivatives (n, 2, 6) to (dp, dtheta).

    Raises PoseError if an endpoint is not in front of its camera.
    """
    return _residuals(T_world_target, lines, directed_endpoints(lines, cameras))


def refine_pose_lines(
    T_world_target: FloatArray,
    lines: LineMeasurements,
    cameras: RectifiedCameras,
    *,
    loss: Loss = "tukey",
    k: float | None = None,
    endpoint_sigma: float = ENDPOINT_SIGMA,
    near: bool = False,
    systematics: Systematics | None = None,
) -> RefinedPose:
    """The pose that fits the lines best, from T_world_target (4, 4) on; a line is trusted or rejected as a whole.

    systematics: errors that the lines share, estimated with the pose; the covariance holds what is left of them.

    loss, k: the robust loss and its bound in robust standard deviations (4.685 for Tukey's, 1.345 for Huber's if not
    given).  endpoint_sigma, px: standard deviation of what displaces each endpoint by itself, beside the lines'
    covariances; the distances are whitened by all these, taken where the endpoints lie at the start.
    near: the start is known to be near the minimum, so outliers are told by it at once.
    Raises PoseError if the lines do not determine the pose or the target is not in front of the cameras.
    """
    # Ends that move independently of each other move their mean and half their difference alike.
    displacement = Displacement(endpoint_sigma / math.sqrt(2.0), endpoint_sigma / math.sqrt(2.0))
    systematics = Systematics.none(len(lines)) if systematics is None else systematics
    start = (float_array(T_world_target, 4, 4), systematics.mean)
    solution, whitening = _solve(start, lines, cameras, displacement, systematics, near=near, loss=loss, k=k)
    return _refined(solution, lines, cameras, systematics, whitening, displacement)


def refine_pose_edges(
    T_world_target: FloatArray,
    lines: LineMeasurements,
    cameras: RectifiedCameras,
    systematics: Systematics | None = None,
) -> RefinedPose:
    """As `refine_pose_lines`, with the displacement that the lines themselves show, and the scales of the systematics'
    groups that they do.

    Lens remains, aliasing, light and the model's own errors displace edges by more than their fits know.  The variances
    of offsets and of tilts are those at which the weighted squares of either come to their degrees of freedom, so
    weights and covariance follow the frame (R. C. Paule and J. Mandel, "Consensus values and weighting factors", 1982;
    here for two components, whose degrees of freedom are the lines less the leverage of the pose on them).
    """
    systematics = Systematics.none(len(lines)) if systematics is None else systematics
    start, rounds = START_SIGMA, VARIANCE_ROUNDS
    if systematics.doubtful.any():
        start, rounds = _START_BESIDE_SHARED, _MOST_VARIANCE_ROUNDS
        systematics = systematics.widest
    displacement = Displacement(start, start)
    estimate, near = (float_array(T_world_target, 4, 4), systematics.mean), False
    for _ in range(rounds):
        solution, _ = _solve(estimate, lines, cameras, displacement, systematics, near=near)
        estimate, near = solution.estimate, True
        distances = _distances(solution.estimate, lines, cameras, systematics)
        before = (displacement.offset, displacement.tilt, *systematics.scales)
        displacement = shown_displacement(estimate[0], distances, solution, lines, cameras)
        systematics = systematics.rescaled(estimate[1], solution.inverse[6:, 6:])
        if np.allclose((displacement.offset, displacement.tilt, *systematics.scales), before, rtol=_SETTLED, atol=0.0):
            break
    solution, whitening = _solve(estimate, lines, cameras, displacement, systematics, near=near)
    return _refined(solution, lines, cameras, systematics, whitening, displacement)


_Joint = tuple[FloatArray, FloatArray]
"""A pose (4, 4) and the parameters beside it (p,)."""


def _solve(
    start: _Joint,
    lines: LineMeasurements,
    cameras: RectifiedCameras,
    displacement: Displacement,
    systematics: Systematics,
    *,
    near: bool,
    loss: Loss = "tukey",
    k: float | None = None,
) -> tuple[GaussNewtonSolution[_Joint], FloatArray]:
    """The minimum, and the whitening (n, 2, 2) of the distances."""
    if len(lines) < 3:
        raise PoseError(f"{len(lines)} lines do not determine the pose")
    endpoints = directed_endpoints(lines, cameras)
    whitening = whitening_of(offset_tilt_covariance(start[0], lines, cameras), displacement)
    G = systematics.derivative
    mean = systematics.mean

    def evaluate(estimate: _Joint) -> tuple[FloatArray, FloatArray]:
        distances, derivatives = _residuals(estimate[0], lines, endpoints)
        if len(systematics) > 0:
            distances, derivatives = distances + G @ estimate[1], np.concatenate([derivatives, G], axis=2)
        return np.einsum("nij,nj->ni", whitening, distances), whitening @ derivatives

    prior = Prior[_Joint](lambda estimate: estimate[1] - mean, systematics.prior_information)
    return (
        minimise(start, evaluate, _move, loss=loss, k=k, scale_floor=SCALE_FLOOR, near=near, prior=prior),
        whitening,
    )


def _move(estimate: _Joint, step: FloatArray) -> _Joint:
    return perturb(estimate[0], step[:6]), estimate[1] + step[6:]


def _distances(
    estimate: _Joint, lines: LineMeasurements, cameras: RectifiedCameras, systematics: Systematics
) -> FloatArray:
    distances, _ = line_residuals(estimate[0], lines, cameras)
    total: FloatArray = distances + systematics.derivative @ estimate[1]
    return total


def _refined(
    solution: GaussNewtonSolution[_Joint],
    lines: LineMeasurements,
    cameras: RectifiedCameras,
    systematics: Systematics,
    whitening: FloatArray,
    displacement: Displacement,
) -> RefinedPose:
    distances = _distances(solution.estimate, lines, cameras, systematics)
    return refined_pose(solution, distances, whitening, systematics, displacement.offset)


def directed_endpoints(lines: LineMeasurements, cameras: RectifiedCameras) -> DirectedPoints:
    normals = np.column_stack([np.cos(lines.theta), np.sin(lines.theta)])
    points = lines.endpoints_C.reshape(-1, 3)
    return DirectedPoints.of(cameras, np.repeat(lines.camera, 2), points, np.repeat(normals, 2, axis=0))


def _residuals(T: FloatArray, lines: LineMeasurements, endpoints: DirectedPoints) -> tuple[FloatArray, FloatArray]:
    projected, derivatives = endpoints.project(T)
    return projected.reshape(-1, 2) - lines.rho[:, None], derivatives.reshape(-1, 2, 6)


def offset_tilt_covariance(T: FloatArray, lines: LineMeasurements, cameras: RectifiedCameras) -> FloatArray:
    """Variance of each line's offset, covariance of both, variance of its tilt (3, n), px², as far as they are known.

    The offset is the mean of its endpoints' distances, the tilt half of their difference.
    """
    points_W = lines.endpoints_C.reshape(-1, 3) @ T[:3, :3].T + T[:3, 3]
    xy = cameras.project(np.repeat(lines.camera, 2), points_W).reshape(-1, 2, 2)
    along = xy[:, :, 1] * np.cos(lines.theta)[:, None] - xy[:, :, 0] * np.sin(lines.theta)[:, None]
    # distance = x cos(theta) + y sin(theta) - rho: its derivatives are -1 by rho and `along` by theta.
    middle, half = 0.5 * (along[:, 0] + along[:, 1]), 0.5 * (along[:, 1] - along[:, 0])
    by_rho, mixed, by_theta = lines.cov[:, 0, 0], lines.cov[:, 0, 1], lines.cov[:, 1, 1]
    offset = by_rho - 2.0 * middle * mixed + middle**2 * by_theta + lines.shift_sigma**2
    return np.stack([offset, half * (middle * by_theta - mixed), half**2 * by_theta])


def whitening_of(known: FloatArray, displacement: Displacement) -> FloatArray:
    """Matrices (n, 2, 2) that turn a line's two distances into independent ones of unit variance: its offset, and what
    its tilt has beyond what the offset tells of it."""
    offset_variance = known[0] + displacement.offset**2
    slope = known[1] / offset_variance
    tilt_sigma = np.sqrt(known[2] + displacement.tilt**2 - slope * known[1])
    by_offset = 0.5 / np.sqrt(offset_variance)
    by_first, by_second = -0.5 * (1.0 + slope) / tilt_sigma, 0.5 * (1.0 - slope) / tilt_sigma
    return np.stack([by_offset, by_offset, by_first, by_second], axis=1).reshape(-1, 2, 2)


def shown_displacement(
    T: FloatArray,
    distances: FloatArray,
    solution: GaussNewtonSolution[Any],
    lines: LineMeasurements,
    cameras: RectifiedCameras,
) -> Displacement:
    """The displacement at which the weighted squares of offsets and of tilts equal their degrees of freedom.

    T (4, 4), distances (n, 2), px: the pose that the solution found over these lines, and what it leaves of them.
    """
    w, J = solution.weights, solution.jacobians
    leverage = np.einsum("n,nki,ij,nkj->k", w, J, solution.inverse, J, optimize=True)
    freedom = np.maximum(float(w.sum()) - leverage, 1.0)
    offset, tilt = 0.5 * (distances[:, 0] + distances[:, 1]), 0.5 * (distances[:, 1] - distances[:, 0])
    known_offset, mixed, known_tilt = offset_tilt_covariance(T, lines, cameras)
    offset_sigma = consistent_sigma(w * offset**2, known_offset, float(freedom[0]))
    slope = mixed / (known_offset + offset_sigma**2)
    tilt_sigma = consistent_sigma(w * (tilt - slope * offset) ** 2, known_tilt - slope * mixed, float(freedom[1]))
    return Displacement(offset_sigma, tilt_sigma)


def consistent_sigma(squares: FloatArray, known: FloatArray, freedom: float) -> float:
    """The sigma at which the sum of squares / (known + sigma²) is the freedom, within its bounds."""

    def excess(sigma: float) -> float:
        return float(np.sum(squares / (known + sigma**2))) - freedom

    low, high = MIN_DISPLACEMENT, MAX_DISPLACEMENT
    if excess(low) <= 0.0:
        return low
    for _ in range(_BISECTIONS):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if excess(middle) > 0.0 else (low, middle)
    return high
