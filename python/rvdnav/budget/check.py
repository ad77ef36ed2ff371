"""A budget beside the Monte Carlo simulation of the same design."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np

from rvdnav.budget.design import Design
from rvdnav.budget.monte_carlo import simulated_errors
from rvdnav.budget.propagation import pose_budget
from rvdnav.pose.arrays import FloatArray

SAMPLES = 2000
"""Of a check: a standard deviation is then known to 1.6 %."""
AGREEMENT = 0.1


@attrs.frozen(eq=False)
class Check:
    """At a range, m, and angle, rad: standard deviations (6,) by linear propagation and as drawn, order (position,
    rotation) in W, m and rad."""

    distance: float
    angle: float
    linear: FloatArray
    drawn: FloatArray

    @property
    def ratios(self) -> FloatArray:
        """(6,) drawn by linear."""
        return self.drawn / self.linear

    @property
    def agrees(self) -> bool:
        """Whether all six are within 10 %."""
        return bool((np.abs(self.ratios - 1.0) <= AGREEMENT).all())


def check(
    design: Design,
    distance: float,
    angle: float,
    *,
    samples: int = SAMPLES,
    seed: int = 1,
    done: Callable[[], None] = lambda: None,
) -> Check:
    """Compare at one pose, turned about y_W where it is turned.  Raises PoseError where the pose is not determined."""
    T = design.pose_at(distance, angle, 0.0)
    linear = np.sqrt(np.diagonal(pose_budget(design, T).total))
    errors = simulated_errors(design, T, samples, seed, done)
    return Check(distance, angle, linear, np.sqrt(np.mean(errors**2, axis=0)))
