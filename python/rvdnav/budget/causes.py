"""The causes of error, each as what it does to the residuals of the lines.

Every cause is a matrix F (2n, p): the residuals err by F z with independent z of unit variance.  Residuals are the
distances (px) of the projected ends of the edges from their lines, in the order of the lines, two a line.
"""

from __future__ import annotations

import numpy as np

from rvdnav.budget.design import Design
from rvdnav.budget.lines import ExpectedLines, ends_along, shared_corners
from rvdnav.pose import line_residuals
from rvdnav.pose.arrays import BoolArray, FloatArray
from rvdnav.rig import calibration_parameters

NOISE, DISPLACEMENT, SIDES = "pixel noise", "line displacement", "side faces"
CALIBRATION, DIMENSIONS, TIMING = "calibration", "dimensions", "timing"
CAUSES = (NOISE, DISPLACEMENT, SIDES, CALIBRATION, DIMENSIONS, TIMING)
"""They are independent of each other: their variances add up."""

PARAMETER_GROUPS = {
    "focal lengths": ("fx", "fy"),
    "principal points": ("cx", "cy"),
    "distortion": ("k1", "k2", "p1", "p2"),
    "rotation": ("rx", "ry", "rz"),
    "baseline": ("tx", "ty", "tz"),
}
"""Of the calibration's parameters.  A calibration's errors are correlated, so these need not add up to it."""


def residual_errors(design: Design, T_world_target: FloatArray, expected: ExpectedLines) -> dict[str, FloatArray]:
    """F (2n, p) of every cause, by its name."""
    lines, assumed = expected.lines, design.assumptions
    n = len(lines)
    _, J = line_residuals(T_world_target, lines, design.cameras)
    return {
        NOISE: _noise(design, T_world_target, expected),
        # Independent ends have an offset and a tilt of half their variance each.
        DISPLACEMENT: np.sqrt(2.0) * assumed.displacement * np.eye(2 * n),
        SIDES: np.repeat(np.diag(lines.shift_sigma), 2, axis=0),
        CALIBRATION: _calibration(design, T_world_target, expected) @ _root(design),
        DIMENSIONS: assumed.dimensions * _corners(design, expected, J[:, :, :3] @ T_world_target[:3, :3]),
        TIMING: _timing(design, J, lines.camera == 1),
    }


def parameter_errors(
    design: Design, T_world_target: FloatArray, expected: ExpectedLines
) -> tuple[dict[str, FloatArray], dict[str, FloatArray], dict[str, FloatArray]]:
    """F (2n, p) of each parameter of the calibration by itself, of each of PARAMETER_GROUPS by itself, and of the whole
    calibration were that group known exactly."""
    derivatives = _calibration(design, T_world_target, expected)
    P = np.asarray(design.rig.calibration_covariance)
    names = calibration_parameters(len(design.rig.cameras))
    single = {name: derivatives[:, [i]] * np.sqrt(P[i, i]) for i, name in enumerate(names)}
    groups, without = {}, {}
    for group, members in PARAMETER_GROUPS.items():
        chosen = [i for i, name in enumerate(names) if name.partition(".")[2] in members]
        if chosen:
            own = P[np.ix_(chosen, chosen)]
            groups[group] = derivatives[:, chosen] @ psd_root(own)
            rest = P - P[:, chosen] @ np.linalg.pinv(own, hermitian=True) @ P[chosen]
            rest[chosen] = rest[:, chosen] = 0.0
            without[group] = derivatives @ psd_root(rest)
    return single, groups, without


def _noise(design: Design, T_world_target: FloatArray, expected: ExpectedLines) -> FloatArray:
    lines = expected.lines
    along = ends_along(design, T_world_target, lines)
    by_line = np.stack([-np.ones_like(along), along], axis=2)  # of distances by (rho, theta)
    errors = np.zeros((len(lines), 2, len(lines), 2))
    index = np.arange(len(lines))
    errors[index, :, index] = by_line @ np.array([psd_root(cov) for cov in expected.noise])
    return errors.reshape(2 * len(lines), 2 * len(lines))


def _calibration(design: Design, T_world_target: FloatArray, expected: ExpectedLines) -> FloatArray:
    derivatives = design.calibration.residual_derivatives(T_world_target, expected.lines)
    return derivatives.reshape(-1, derivatives.shape[2])


def _root(design: Design) -> FloatArray:
    return psd_root(np.asarray(design.rig.calibration_covariance))


def psd_root(covariance: FloatArray) -> FloatArray:
    """A with A Aᵀ = covariance, which may be singular and of mixed units."""
    sigma = np.sqrt(np.maximum(np.diagonal(covariance), 0.0))
    units = np.where(sigma > 0.0, sigma, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(units, units))
    root: FloatArray = units[:, None] * vectors * np.sqrt(np.maximum(values, 0.0))
    return root


def _corners(design: Design, expected: ExpectedLines, by_point: FloatArray) -> FloatArray:
    """By the coordinates of the target's corners, from by_point (n, 2, 3) of the lines' ends.

    Edges share corners, and an end between two of them moves with both.
    """
    corner = shared_corners(design.model.edge_points)
    ends = corner[expected.lines.edge]
    errors = np.zeros((len(ends), 2, corner.max() + 1, 3))
    index, end = np.arange(len(ends))[:, None], np.arange(2)
    for corner_of_end, share in ((ends[:, :1], 1.0 - expected.part), (ends[:, 1:], expected.part)):
        errors[index, end, corner_of_end] += share[:, :, None] * by_point
    return errors.reshape(2 * len(ends), -1)


def _timing(design: Design, J: FloatArray, later: BoolArray) -> FloatArray:
    """By the time between the exposures times a motion in any direction: six components of it, of equal share."""
    assumed = design.assumptions
    motion = np.repeat([assumed.speed, assumed.turn_rate], 3) / np.sqrt(3.0) * assumed.timing
    errors: FloatArray = np.where(later[:, None, None], J, 0.0) * motion
    return errors.reshape(-1, 6)
