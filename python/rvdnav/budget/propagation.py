"""A budget at one pose: linear propagation through the estimator that the navigator uses."""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.budget.causes import parameter_errors, residual_errors
from rvdnav.budget.design import Design
from rvdnav.budget.lines import ExpectedLines, ends_along, expected_lines
from rvdnav.navigator.geometry import line_covariance
from rvdnav.pose import LineMeasurements, RefinedPose, line_residuals, refine_pose_lines
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.refine_lines import MAX_DISPLACEMENT, MIN_DISPLACEMENT, consistent_sigma

# Where the search for the displacement begins, px, and how it goes on.
_START_SIGMA = 0.15
_ROUNDS = 4
_MAX_SCATTER = 0.5
_HERMITE_POINTS = np.sqrt(3.0) * np.array([-1.0, 0.0, 1.0])
_HERMITE_SHARES = np.array([1.0, 4.0, 1.0]) / 6.0
# Offset and tilt of a line from the distances of its ends.
_OFFSET_TILT = np.array([[0.5, 0.5], [-0.5, 0.5]])


@attrs.frozen(eq=False)
class PoseBudget:
    """Covariances (6, 6) of the pose, order (position, rotation) in W.

    causes: of every cause, by name; they add up to total.  groups, parameters: of some of the calibration's parameters
    by themselves.  without: of the whole calibration, were the group known exactly.
    displacement (2,), px: standard deviation of offset and tilt that the estimator finds in the lines, on average.
    lines: how many are measured.
    """

    T_world_target: FloatArray
    causes: dict[str, FloatArray]
    groups: dict[str, FloatArray]
    without: dict[str, FloatArray]
    parameters: dict[str, FloatArray]
    displacement: FloatArray
    lines: int

    @property
    def total(self) -> FloatArray:
        """Covariance (6, 6) by all causes together."""
        total: FloatArray = np.sum(list(self.causes.values()), axis=0)
        return total


def pose_budget(design: Design, T_world_target: FloatArray) -> PoseBudget:
    """The budget at a pose (4, 4).  Raises PoseError where the lines in view do not determine it."""
    expected = expected_lines(design, T_world_target)
    causes = residual_errors(design, T_world_target, expected)
    parameters, groups, without = parameter_errors(design, T_world_target, expected)
    weighting = _Weighting.of(design, T_world_target, expected)
    displacement, scatter = weighting.expected(np.hstack(list(causes.values())))
    gains, shares = weighting.gains_around(displacement, scatter)

    def covariances(errors: dict[str, FloatArray]) -> dict[str, FloatArray]:
        moved = {name: gains @ F for name, F in errors.items()}
        return {name: np.einsum("g,gip,gjp->ij", shares, D, D) for name, D in moved.items()}

    return PoseBudget(
        T_world_target,
        covariances(causes),
        covariances(groups),
        covariances(without),
        covariances(parameters),
        displacement,
        len(expected.lines),
    )


@attrs.frozen(eq=False)
class _Weighting:
    """How the estimator weights the lines: by the displacement of offsets and tilts that it finds in their residuals.

    That is where the weighted squares of either equal their degrees of freedom (`refine_pose_edges`).  Here the squares
    have the values, and scatter as much from frame to frame, as all errors together let expect after the fit.
    """

    design: Design
    T_world_target: FloatArray
    lines: LineMeasurements
    along: FloatArray
    known: FloatArray
    """(2, n) variances of offsets and tilts that the lines state, px²."""
    derivatives: FloatArray
    """(n, 2, 6) of the ends' distances by the pose."""

    @classmethod
    def of(cls, design: Design, T_world_target: FloatArray, expected: ExpectedLines) -> _Weighting:
        lines = expected.lines
        _, derivatives = line_residuals(T_world_target, lines, design.cameras)
        along = ends_along(design, T_world_target, lines)
        by_line = np.stack([-np.ones_like(along), along], axis=2)  # of the ends' distances by (rho, theta)
        known = np.einsum("ck,nkl,nlm,nom,co->cn", _OFFSET_TILT, by_line, lines.cov, by_line, _OFFSET_TILT)
        known[0] += lines.shift_sigma**2
        return cls(design, T_world_target, lines, along, known, derivatives)

    def refined(self, displacement: FloatArray) -> RefinedPose:
        """The exact lines solved with a displacement (2,)."""
        weighted = _with_displacement(self.lines, self.along, displacement)
        return refine_pose_lines(self.T_world_target, weighted, self.design.cameras, near=True)

    def expected(self, errors: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The displacement (2,) that residuals which err by errors (2n, p) let expect, px, and the scatter (2,) of its
        logarithm."""
        displacement = np.array([_START_SIGMA, _START_SIGMA])
        moved = np.einsum("ck,nkp->cnp", _OFFSET_TILT, self.derivatives)
        J = self.derivatives.reshape(-1, 6)
        for _ in range(_ROUNDS):
            pose = self.refined(displacement)
            left = (errors - J @ (pose.gain.reshape(6, -1) @ errors)).reshape(len(self.lines), 2, -1)
            parts = np.einsum("ck,nkp->cnp", _OFFSET_TILT, left)
            leverage = np.einsum("cni,ij,cnj->cn", moved, pose.covariance, moved)
            total = self.known + displacement[:, None] ** 2
            freedom = np.maximum(len(self.lines) - (leverage / total).sum(axis=1), 1.0)
            squares = np.square(parts).sum(axis=2)
            displacement = np.array(list(map(consistent_sigma, squares, self.known, freedom)))
        total = self.known + displacement[:, None] ** 2
        covariance = np.einsum("cnp,cmp->cnm", parts, parts) / total[:, None]
        # Of a sum of squares of correlated normal variables, and how the displacement answers to it.
        deviation = np.sqrt(2.0 * np.einsum("cnm,cmn->c", covariance, covariance))
        slope = 2.0 * displacement**2 * (squares / total**2).sum(axis=1)
        return displacement, np.minimum(deviation / np.maximum(slope, 1e-300), _MAX_SCATTER)

    def gains_around(self, displacement: FloatArray, scatter: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gains (9, 6, 2n) of the estimator over the displacement's distribution, and their shares (9,) of it.

        Three points of Gauss and Hermite in either.
        """
        gains, shares = [], []
        for i, j in np.ndindex(3, 3):
            at = displacement * np.exp(scatter * _HERMITE_POINTS[[i, j]])
            gains.append(self.refined(np.clip(at, MIN_DISPLACEMENT, MAX_DISPLACEMENT)).gain.reshape(6, -1))
            shares.append(_HERMITE_SHARES[i] * _HERMITE_SHARES[j])
        return np.array(gains), np.array(shares)


def _with_displacement(lines: LineMeasurements, along: FloatArray, displacement: FloatArray) -> LineMeasurements:
    """The lines with a displacement (2,) beyond the least one as a part of what they state."""
    offset, tilt = np.maximum(displacement**2 - MIN_DISPLACEMENT**2, 0.0)
    middle, half = along.mean(axis=1), 0.5 * (along[:, 1] - along[:, 0])
    added = line_covariance(np.zeros(len(lines)), tilt / half**2, middle)
    return attrs.evolve(lines, cov=lines.cov + added, shift_sigma=np.sqrt(lines.shift_sigma**2 + offset))
