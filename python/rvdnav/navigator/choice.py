"""Which of several attempts at the same images is to be believed."""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.navigator.attempt import Attempt
from rvdnav.pose import difference
from rvdnav.solution import Reason

# Coverage by which one pose is better than another; how far apart they must be, in standard deviations, to be two.
_AS_WELL_COVERED = 0.08
_APART_SIGMAS = 5.0
_UNREFUTED = frozenset({Reason.COVARIANCE, Reason.AMBIGUOUS, Reason.NOT_CONVERGED})


def best_attempt(attempts: list[Attempt]) -> Attempt:
    """Of attempts from different poses, at least one, the likeliest first: the passed one that the images cover most.

    Ambiguous if another pose is covered as well, refused for one that is covered better but can't be published.  The
    first if none passed.
    """
    standing = [attempt for attempt in attempts if attempt.reasons <= _UNREFUTED]
    passed = [attempt for attempt in standing if attempt.passed]
    if not passed:
        return attempts[0]
    best, chosen = (max(some, key=lambda attempt: attempt.coverage) for some in (standing, passed))
    if best.coverage - chosen.coverage > _AS_WELL_COVERED:
        return best
    for other in standing:
        if chosen.coverage - other.coverage < _AS_WELL_COVERED and _apart(chosen, other):
            return attrs.evolve(chosen, reasons=frozenset({Reason.AMBIGUOUS}))
    return chosen


def _apart(a: Attempt, b: Attempt) -> bool:
    """Whether two measurements are of different poses."""
    if a.measurement is None or b.measurement is None:
        return False
    error = difference(a.measurement.pose.T_world_target, b.measurement.pose.T_world_target)
    covariance = a.measurement.pose.covariance + b.measurement.pose.covariance
    return float(error @ np.linalg.solve(covariance, error)) > _APART_SIGMAS**2
