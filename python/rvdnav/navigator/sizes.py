"""What the frames so far tell of the size of a bracket: an information filter over its six sizes."""

from __future__ import annotations

from functools import cached_property

import attrs
import numpy as np

from rvdnav.pose.arrays import FloatArray
from rvdnav.solution import LearnedDimensions
from rvdnav.trapezoid import DIMENSIONS, Trapezoid

# Part of a frame's variance that is the same in all frames: light on the side faces, lens remains, lasting offsets.
_COMMON = 0.3
# By what the two edges that bound a size are displaced towards each other by light and blur, px.
_EDGE_SIGMA_PX = 0.05
# What no number of frames tells, m and as a part of the size: the calibration's share.
_FLOOR_M = 1e-5
_FLOOR_PART = 1e-4
# Known well enough for all that needs the size: standard deviations as parts of the long base, of bases and height and
# of the bars' widths, on which a pose depends less; and frames behind it.
_KNOWN_PART = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0]) / 300.0
_KNOWN_FRAMES = 3
# A frame whose sizes lie farther from those of all others, in squared standard deviations, teaches nothing.
_MAX_SQUARED_DISTANCE = 30.0


@attrs.frozen(eq=False)
class Sizes:
    """The information of frames about the sizes of a bracket, in the order of `DIMENSIONS`.

    information (6, 6), 1/m²; vector (6,): information times sizes.  common (6, 6): sum of each frame's information
    times the root of its covariance, by which errors common to all frames add up.  frames: how many.
    """

    information: FloatArray
    vector: FloatArray
    common: FloatArray
    frames: int

    @classmethod
    def of(cls, sizes: FloatArray, covariance: FloatArray, pixel: float) -> Sizes:
        """From one frame's sizes (6,) and their covariance (6, 6), m²; pixel: what one px measures at the target, m."""
        covariance = covariance + (_EDGE_SIGMA_PX * pixel) ** 2 * np.eye(len(sizes))
        inverse = np.linalg.inv(covariance)
        information: FloatArray = np.asarray(0.5 * (inverse + inverse.T), np.float64)
        return cls(information, information @ sizes, information @ np.linalg.cholesky(covariance), 1)

    def combined(self, other: Sizes) -> Sizes:
        """Both together."""
        return Sizes(
            self.information + other.information,
            self.vector + other.vector,
            self.common + other.common,
            self.frames + other.frames,
        )

    @cached_property
    def mean(self) -> FloatArray:
        """The sizes (6,), m."""
        return np.asarray(np.linalg.solve(self.information, self.vector), np.float64)

    @cached_property
    def covariance(self) -> FloatArray:
        """Of the mean (6, 6), m²: what averages out, what doesn't, and the floor."""
        inverse = np.linalg.inv(self.information)
        lasting = inverse @ self.common
        floor = _FLOOR_M**2 + (_FLOOR_PART * self.mean) ** 2
        covariance = inverse + _COMMON * lasting @ lasting.T + np.diag(floor)
        return np.asarray(0.5 * (covariance + covariance.T), np.float64)

    @property
    def shape(self) -> Trapezoid:
        """The bracket's mean shape."""
        return Trapezoid.of(self.mean)

    @property
    def known(self) -> bool:
        """Whether the target may be taken for one of known size."""
        sigmas = np.sqrt(np.diag(self.covariance))
        return self.frames >= _KNOWN_FRAMES and bool((sigmas <= _KNOWN_PART * self.mean[0]).all())

    def admits(self, other: Sizes) -> bool:
        """Whether other sizes can be of the same bracket."""
        error = other.mean - self.mean
        return bool(error @ np.linalg.solve(self.covariance + other.covariance, error) <= _MAX_SQUARED_DISTANCE)

    def report(self) -> LearnedDimensions:
        """For the solution."""
        sigmas = np.sqrt(np.diag(self.covariance))
        return LearnedDimensions(
            dict(zip(DIMENSIONS, self.mean.tolist(), strict=True)),
            dict(zip(DIMENSIONS, sigmas.tolist(), strict=True)),
            self.frames,
            self.known,
        )
