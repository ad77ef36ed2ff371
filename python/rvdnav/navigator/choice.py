"""Which of several attempts at the same images is to be believed."""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.navigator.attempt import Attempt
from rvdnav.navigator.gates import most_shown, too_uncertain
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.pose import difference
from rvdnav.solution import Reason

# Coverage by which one pose is better than another; how far apart they must be, in standard deviations, to be two.
_AS_WELL_COVERED = 0.08
_APART_SIGMAS = 5.0
_UNREFUTED = frozenset({Reason.COVARIANCE, Reason.AMBIGUOUS, Reason.NOT_CONVERGED})
# Part of all profiles that poses close to each other must show together, of which none shows enough by itself.
_SHOWN_TOGETHER = 0.8


def best_attempt(attempts: list[Attempt], settings: NavigatorSettings) -> Attempt:
    """Of attempts from different poses, at least one, the likeliest first: the passed one that the images cover most.

    Where others are covered as well it is what lies among them, with a covariance that holds them all; ambiguous if
    that leaves the pose too uncertain.  Refused for one that is covered better but can't be published.  If none passed,
    what poses close to each other show together; failing that the first.
    """
    standing = [attempt for attempt in attempts if attempt.reasons <= _UNREFUTED]
    passed = [attempt for attempt in standing if attempt.passed]
    if not passed:
        return _joined(attempts, settings) or attempts[0]
    best, chosen = (max(some, key=lambda attempt: attempt.coverage) for some in (standing, passed))
    if best.coverage - chosen.coverage > _AS_WELL_COVERED:
        return best
    as_well = [a for a in standing if chosen.coverage - a.coverage < _AS_WELL_COVERED and _apart(chosen, a)]
    return _among(chosen, as_well, settings) or attrs.evolve(chosen, reasons=frozenset({Reason.AMBIGUOUS}))


def _joined(attempts: list[Attempt], settings: NavigatorSettings) -> Attempt | None:
    """What lies among poses that show too little each and enough together.

    A real solid is never quite its model: a lid that bulges leaves one pose that fits the edges on its one side, and
    another one close by for those on the other.  Poses that mistake prints for edges show the same few edges, or lie
    far apart.
    """
    partial = [a for a in attempts if a.reasons == {Reason.TOO_FEW_LINES} and a.coverage >= settings.min_coverage]
    partial.sort(key=lambda attempt: -attempt.coverage)
    if len(partial) < 2:
        return None
    first, *others = partial
    joined = _among(first, others, settings)
    if joined is None:
        return None
    profiles = [a.measurement.attempted for a in partial if a.measurement is not None]
    coverage = np.max([a.measurement.coverage for a in partial if a.measurement is not None], axis=0)
    attempted = np.max(profiles, axis=0)
    together = float((coverage * attempted).sum()) / max(int(attempted.sum()), 1)
    if together < _SHOWN_TOGETHER or not most_shown(coverage, attempted, settings):
        return None
    return joined


def _among(chosen: Attempt, others: list[Attempt], settings: NavigatorSettings) -> Attempt | None:
    """The attempt with what lies among its pose and the others'; None if that is too uncertain."""
    if chosen.measurement is None:
        return None
    measurements = [other.measurement for other in others if other.measurement is not None]
    among = chosen.measurement.among(measurements)
    distance = float(np.linalg.norm(among.pose.T_world_target[:3, 3]))
    if too_uncertain(among.pose.covariance, distance, settings):
        return None
    return attrs.evolve(chosen, reasons=frozenset(), measurement=among)


def _apart(a: Attempt, b: Attempt) -> bool:
    """Whether two measurements are of different poses."""
    if a.measurement is None or b.measurement is None:
        return False
    error = difference(a.measurement.pose.T_world_target, b.measurement.pose.T_world_target)
    covariance = a.measurement.pose.covariance + b.measurement.pose.covariance
    return float(error @ np.linalg.solve(covariance, error)) > _APART_SIGMAS**2
