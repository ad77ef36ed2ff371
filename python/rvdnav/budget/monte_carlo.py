"""The check of a budget: all errors drawn at random, and the pose solved by the navigator's estimator.

Nothing is linear here: the target's true edges are imaged by the true cameras, displaced, and taken back by the wrong
calibration; straight lines are fitted through them and the pose is refined over those.
"""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from rvdnav.budget.causes import psd_root
from rvdnav.budget.design import Design
from rvdnav.budget.lines import ExpectedLines, ends_along, expected_lines, shared_corners
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.pose import LineMeasurements, difference, perturb, refine_pose_edges
from rvdnav.pose.arrays import FloatArray, IntArray
from rvdnav.rig import Rig

_POINTS_PER_LINE = 9


@attrs.frozen(eq=False)
class Errors:
    """One draw of everything that is wrong.

    calibration (8,) or (22,): the rig's parameters minus the true ones.  corners (m, 2, 3), m: of the true edges, minus
    the file's.  motion (6,): of the target between the exposures, order (position, rotation), m, rad.
    across (n, k), px: of the points that are measured along each line.
    """

    calibration: FloatArray
    corners: FloatArray
    motion: FloatArray
    across: FloatArray


@attrs.frozen(eq=False)
class ErrorSource:
    """The distribution of all errors at a pose."""

    design: Design
    expected: ExpectedLines
    corner: IntArray
    """(m, 2) number of the corner that each end of the target's edges is."""
    calibration_root: FloatArray
    noise_roots: FloatArray
    """(n, 2, 2) of the covariances of (rho, theta)."""
    place: FloatArray
    """(n, k), px, of the measured points along each line."""
    leverage: FloatArray
    """(n, k) of the same points: -1 and 1 at the edge's ends, for a tilt about its middle."""

    @classmethod
    def at(cls, design: Design, T_world_target: FloatArray, expected: ExpectedLines) -> ErrorSource:
        """At a pose (4, 4) and the lines that are measured there."""
        along = ends_along(design, T_world_target, expected.lines)
        part = _fractions(expected)
        return cls(
            design=design,
            expected=expected,
            corner=shared_corners(design.model.edge_points),
            calibration_root=psd_root(np.asarray(design.rig.calibration_covariance)),
            noise_roots=np.array([psd_root(cov) for cov in expected.noise]),
            place=along[:, :1] + part * (along[:, 1:] - along[:, :1]),
            leverage=2.0 * part - 1.0,
        )

    def draw(self, rng: np.random.Generator) -> Errors:
        """One draw."""
        assumed, lines = self.design.assumptions, self.expected.lines
        corners = assumed.dimensions * rng.standard_normal((self.corner.max() + 1, 3))
        directions = rng.standard_normal((2, 3))
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        seconds = assumed.timing * rng.standard_normal()
        fit = np.einsum("nij,nj->ni", self.noise_roots, rng.standard_normal((len(lines), 2)))
        offset, tilt = assumed.displacement * rng.standard_normal((2, len(lines), 1))
        shift = lines.shift_sigma[:, None] * rng.standard_normal((len(lines), 1))
        return Errors(
            calibration=self.calibration_root @ rng.standard_normal(len(self.calibration_root)),
            corners=corners[self.corner],
            motion=seconds * np.concatenate([assumed.speed * directions[0], assumed.turn_rate * directions[1]]),
            across=fit[:, :1] - self.place * fit[:, 1:] + offset + self.leverage * tilt + shift,
        )


def simulated_errors(
    design: Design, T_world_target: FloatArray, samples: int, seed: int, done: Callable[[], None] = lambda: None
) -> FloatArray:
    """Errors (samples, 6) of the pose, order (position, rotation) in W; done is called after each.

    Raises PoseError where the lines in view do not determine the pose.
    """
    rng = np.random.default_rng(seed)
    expected = expected_lines(design, T_world_target)
    source = ErrorSource.at(design, T_world_target, expected)
    errors = np.empty((samples, 6))
    for row in errors:
        row[:] = pose_error(design, T_world_target, expected, source.draw(rng))
        done()
    return errors


def pose_error(design: Design, T_world_target: FloatArray, expected: ExpectedLines, errors: Errors) -> FloatArray:
    """Error (6,) of the pose that the estimator gives, relative to the true one, order (position, rotation) in W."""
    believed = design.rig.perturbed(errors.calibration)
    lines = measured_lines(design, T_world_target, expected, errors, believed)
    refined = refine_pose_edges(T_world_target, lines, rectified_cameras(believed))
    return difference(refined.T_world_target, T_world_target)


def measured_lines(
    design: Design, T_world_target: FloatArray, expected: ExpectedLines, errors: Errors, believed: Rig
) -> LineMeasurements:
    """The lines as one finds them who believes in another rig than the true one."""
    lines = expected.lines
    true_edges_C = (design.model.edge_points + errors.corners)[lines.edge]
    part = expected.part[:, :, None]
    true_ends_C = (1.0 - part) * true_edges_C[:, :1] + part * true_edges_C[:, 1:]
    rho, theta = np.empty(len(lines)), np.empty(len(lines))
    for i in design.views:
        chosen = lines.camera == i
        T = T_world_target if i == 0 else perturb(T_world_target, errors.motion)
        ends_W = true_ends_C[chosen].reshape(-1, 3) @ T[:3, :3].T + T[:3, 3]
        ends = design.rig.project_rect(i, ends_W).reshape(-1, 2, 2)
        normal = np.column_stack([np.cos(lines.theta[chosen]), np.sin(lines.theta[chosen])])
        tangent = np.column_stack([-normal[:, 1], normal[:, 0]])
        along = _fractions(expected)[chosen][:, :, None]
        points = ends[:, None, 0] + along * (ends[:, None, 1] - ends[:, None, 0])
        points += errors.across[chosen][:, :, None] * normal[:, None]
        seen = believed.raw_to_rect(i, design.rig.rect_to_raw(i, points))
        across = np.einsum("nki,ni->nk", seen, normal)
        along = np.einsum("nki,ni->nk", seen, tangent)
        centred = along - along.mean(axis=1, keepdims=True)
        slope = (centred * across).sum(axis=1) / np.square(centred).sum(axis=1)
        offset = across.mean(axis=1) - slope * along.mean(axis=1)
        theta[chosen] = lines.theta[chosen] - np.arctan(slope)
        rho[chosen] = offset * np.cos(np.arctan(slope))
    return attrs.evolve(lines, rho=rho, theta=theta)


def _fractions(expected: ExpectedLines) -> FloatArray:
    """Places (n, k) along the measured part of each edge's image, 0 at its first end and 1 at the other."""
    within = (np.arange(_POINTS_PER_LINE) + 0.5) / _POINTS_PER_LINE
    return expected.span[:, :1] + within * (expected.span[:, 1:] - expected.span[:, :1])
