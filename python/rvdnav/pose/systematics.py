"""Errors that the lines of a frame share: of the target's points, of the calibration, of the image's steps.

They are parameters z beside the pose T: to first order the residuals are r(T) + G z.  Of each group of them its
standard deviation is known before, as a unit; the lines tell the rest, and whether the whole group errs by more or less
than was said (D. J. C. MacKay, "Bayesian interpolation", 1992: the evidence for a scale).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from attrs import evolve, field, frozen

from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray, float_array
from rvdnav.pose.gauss_newton import GaussNewtonSolution

# Scales of a group, of what was stated of it: below the least it counts as exact, above the largest as wrong.
LEAST_SCALE = 0.1
LARGEST_SCALE = 5.0


@frozen(eq=False)
class Group:
    """Parameters whose standard deviations were stated together: how many, and how many independent errors the
    statement is worth against those that the lines show (infinite: it is not asked); the largest scale of it; and
    whether the statement may be wrong by that much."""

    size: int
    weight: float
    largest: float = LARGEST_SCALE
    doubtful: bool = False


def _derivative(values: Any) -> FloatArray:
    return float_array(values, None, 2, None)


@frozen(eq=False)
class Systematics:
    """What is known of parameters z (p,), each with unit standard deviation as stated.

    derivative (n, 2, p), px: of the lines' residuals.  groups: in the order of the parameters.  scales (groups,): of
    the stated standard deviations.  information (p, p), vector (p,): what earlier frames told, the vector as
    information times mean.
    """

    derivative: FloatArray = field(converter=_derivative)
    groups: tuple[Group, ...]
    scales: FloatArray
    information: FloatArray
    vector: FloatArray

    @classmethod
    def none(cls, lines: int) -> Systematics:
        """No parameters at all."""
        return cls(np.zeros((lines, 2, 0)), (), np.zeros(0), np.zeros((0, 0)), np.zeros(0))

    @classmethod
    def of(cls, derivative: FloatArray, *groups: Group) -> Systematics:
        """As stated, before any frame."""
        size = derivative.shape[2]
        return cls(derivative, groups, np.ones(len(groups)), np.zeros((size, size)), np.zeros(size))

    def only(self, chosen: Any) -> Systematics:
        """Of the chosen lines alone."""
        return evolve(self, derivative=self.derivative[chosen])

    def __len__(self) -> int:
        return len(self.vector)

    @property
    def doubtful(self) -> BoolArray:
        """(groups,) those that have parameters and whose statement may be wrong by the largest scale."""
        return np.array([group.doubtful and group.size > 0 for group in self.groups], np.bool_)

    @property
    def widest(self) -> Systematics:
        """With the largest scales of the doubtful groups."""
        largest = np.array([group.largest for group in self.groups])
        return evolve(self, scales=np.where(self.doubtful, largest, self.scales))

    @property
    def members(self) -> IntArray:
        """(p,) the group that each parameter belongs to."""
        return np.repeat(np.arange(len(self.groups)), [group.size for group in self.groups])

    @property
    def prior_information(self) -> FloatArray:
        """(p, p) of what was stated and what earlier frames told together."""
        information: FloatArray = np.diag(1.0 / self.scales[self.members] ** 2) + self.information
        return information

    @property
    def mean(self) -> FloatArray:
        """(p,) expected by these."""
        return np.asarray(np.linalg.solve(self.prior_information, self.vector), np.float64)

    def rescaled(self, z: FloatArray, covariance: FloatArray) -> Systematics:
        """With the scales at which the groups' squares are those of their well-determined parameters.

        z (p,), covariance (p, p): of an estimate with these scales.
        """
        scales = self.scales.copy()
        for number, group in enumerate(self.groups):
            if not np.isfinite(group.weight):
                continue
            own = self.members == number
            determined = group.size - float(np.trace(covariance[np.ix_(own, own)])) / scales[number] ** 2
            square = (group.weight + float(z[own] @ z[own])) / (group.weight + max(determined, 0.0))
            scales[number] = np.clip(np.sqrt(square), LEAST_SCALE, group.largest)
        return evolve(self, scales=scales)


@frozen(eq=False)
class JointInformation:
    """What a frame's lines tell of pose and parameters: information (6 + p, 6 + p) and gradient (6 + p,) at the
    estimate of the parameters z (p,), without any prior."""

    information: FloatArray
    gradient: FloatArray
    z: FloatArray

    @classmethod
    def of(cls, solution: GaussNewtonSolution[Any], z: FloatArray, variance: float) -> JointInformation:
        """variance: of unit weight."""
        J = solution.jacobians.reshape(-1, solution.jacobians.shape[2])
        weighted = J * np.repeat(solution.weights, 2)[:, None] / variance
        return cls(weighted.T @ J, weighted.T @ solution.residuals.ravel(), z)

    def of_parameters(self, wanted: BoolArray, prior: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Information (k, k) and vector (k,), information times mean, of the wanted parameters (p,) bool alone.

        prior (p,): inverse variances of the others, whatever they and the pose are.
        """
        chosen = np.concatenate([np.zeros(6, np.bool_), wanted])
        rest = ~chosen
        own = np.concatenate([np.zeros(6), prior])[rest]
        A = self.information[np.ix_(rest, rest)] + np.diag(own)
        B = self.information[np.ix_(rest, chosen)]
        z = np.concatenate([np.zeros(6), self.z])
        pull = self.gradient[rest] + own * z[rest]
        across = np.linalg.solve(A, np.column_stack([B, pull]))
        information = self.information[np.ix_(chosen, chosen)] - B.T @ across[:, :-1]
        information = 0.5 * (information + information.T)
        vector = information @ z[chosen] - (self.gradient[chosen] - B.T @ across[:, -1])
        return information, vector
