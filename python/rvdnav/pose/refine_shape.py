"""Refinement of a pose together with the target's sizes, over lines that were fitted to its edges in both views.

Two views from known places fix the scale, so a target whose shape is known but for some sizes measures itself.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from attrs import evolve, frozen

from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.cameras import RectifiedCameras
from rvdnav.pose.gauss_newton import GaussNewtonSolution, minimise
from rvdnav.pose.refine_lines import (
    SCALE_FLOOR,
    START_SIGMA,
    VARIANCE_ROUNDS,
    Displacement,
    LineMeasurements,
    line_residuals,
    offset_tilt_covariance,
    shown_displacement,
    whitening_of,
)
from rvdnav.pose.refined import unit_weight
from rvdnav.pose.so3 import make_T, perturb, project_to_so3

Shape = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
"""From sizes (p,), m: the ends (m, 2, 3) of the edges in C, m, and their derivatives (m, 2, 3, p) by the sizes."""


@frozen(eq=False)
class RefinedShape:
    """A pose and sizes refined together.

    T_world_target (4, 4).  sizes (p,), m.  covariance (6 + p, 6 + p): of (position, rotation, sizes), otherwise as that
    of `RefinedPose`.  residuals (n, 2), px; weights (n,); sigma0 as of `RefinedPose`.
    """

    T_world_target: FloatArray
    sizes: FloatArray
    covariance: FloatArray
    residuals: FloatArray
    weights: FloatArray
    sigma0: float
    converged: bool


def refine_shape(
    T_world_target: FloatArray, sizes: FloatArray, shape: Shape, lines: LineMeasurements, cameras: RectifiedCameras
) -> RefinedShape:
    """The pose and the sizes that fit the lines best, from T_world_target (4, 4) and sizes (p,) on.

    As `refine_pose_edges`, with the sizes among the unknowns; the lines' own endpoints are not used.
    Raises PoseError if the lines do not determine pose and sizes or the target is not in front of the cameras.
    """
    estimate, displacement = (T_world_target, sizes), Displacement(START_SIGMA, START_SIGMA)
    for near in (*(k > 0 for k in range(VARIANCE_ROUNDS)), True):
        solution = _solve(estimate, shape, lines, cameras, displacement, near=near)
        estimate = solution.estimate
        sized = _sized(lines, shape, estimate[1])
        distances, _ = line_residuals(estimate[0], sized, cameras)
        displacement = shown_displacement(estimate[0], distances, solution, sized, cameras)
    T, sizes = estimate
    omega_squared, sigma0 = unit_weight(solution)
    return RefinedShape(
        T_world_target=make_T(project_to_so3(T[:3, :3]), T[:3, 3]),
        sizes=sizes,
        covariance=omega_squared * solution.inverse,
        residuals=line_residuals(T, sized, cameras)[0],
        weights=solution.weights,
        sigma0=sigma0,
        converged=solution.converged,
    )


def size_derivatives(
    T_world_target: FloatArray, sizes: FloatArray, shape: Shape, lines: LineMeasurements, cameras: RectifiedCameras
) -> FloatArray:
    """Derivatives (n, 2, p), px/m, of the lines' residuals at a pose (4, 4) with respect to the sizes (p,).

    Raises PoseError if an endpoint is not in front of its camera.
    """
    points, by_size = shape(sizes)
    _, by_pose = line_residuals(T_world_target, evolve(lines, endpoints_C=points[lines.edge]), cameras)
    return _by_size(T_world_target, by_pose, by_size[lines.edge])


def _by_size(T: FloatArray, by_pose: FloatArray, by_size: FloatArray) -> FloatArray:
    """From derivatives of residuals by the pose (n, 2, 6) and of their endpoints by the sizes (n, 2, 3, p)."""
    derivatives: FloatArray = ((by_pose[..., :3] @ T[:3, :3])[:, :, None, :] @ by_size)[:, :, 0]
    return derivatives


def _sized(lines: LineMeasurements, shape: Shape, sizes: FloatArray) -> LineMeasurements:
    return evolve(lines, endpoints_C=shape(sizes)[0][lines.edge])


def _solve(
    start: tuple[FloatArray, FloatArray],
    shape: Shape,
    lines: LineMeasurements,
    cameras: RectifiedCameras,
    displacement: Displacement,
    *,
    near: bool,
) -> GaussNewtonSolution[tuple[FloatArray, FloatArray]]:
    known = offset_tilt_covariance(start[0], _sized(lines, shape, start[1]), cameras)
    whitening = whitening_of(known, displacement)

    def evaluate(estimate: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
        T, sizes = estimate
        points, by_size = shape(sizes)
        distances, by_pose = line_residuals(T, evolve(lines, endpoints_C=points[lines.edge]), cameras)
        derivatives = np.concatenate([by_pose, _by_size(T, by_pose, by_size[lines.edge])], axis=2)
        return np.einsum("nij,nj->ni", whitening, distances), whitening @ derivatives

    return minimise(start, evaluate, _move, loss="tukey", k=None, scale_floor=SCALE_FLOOR, near=near)


def _move(estimate: tuple[FloatArray, FloatArray], step: FloatArray) -> tuple[FloatArray, FloatArray]:
    T, sizes = estimate
    return perturb(T, step[:6]), sizes + step[6:]
