"""Figures of a run that need no truth: claimed uncertainty and wall times."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from rvdnav.solution import TOTAL, LearnedDimensions, Reason, Solution

_NO_IMAGE = frozenset(
    {
        Reason.LEFT_MISSING,
        Reason.RIGHT_MISSING,
        Reason.LEFT_UNUSABLE,
        Reason.RIGHT_UNUSABLE,
        Reason.DUPLICATE,
        Reason.TIME_ORDER,
    }
)


def median_sigmas(solutions: Sequence[Solution]) -> tuple[float, float] | None:
    """Median over the published frames of the claimed standard deviation of position (m) and attitude (rad).

    Each is the root of its 3x3 block's trace, comparable with the norm of the error.  None with nothing published.
    """
    covariances = [s.covariance for s in solutions if s.published and s.covariance is not None]
    if not covariances:
        return None
    variances = np.array([(np.trace(c[:3, :3]), np.trace(c[3:, 3:])) for c in covariances])
    position, attitude = np.median(np.sqrt(variances), axis=0)
    return float(position), float(attitude)


def stage_medians(solutions: Sequence[Solution]) -> dict[str, float]:
    """Median seconds of each stage over the frames that ran it, in the order of first appearance, without the total."""
    times: dict[str, list[float]] = {}
    for solution in solutions:
        for stage, seconds in solution.stage_times.items():
            if stage != TOTAL:
                times.setdefault(stage, []).append(seconds)
    return {stage: float(np.median(seconds)) for stage, seconds in times.items()}


def worked_on(solution: Solution) -> bool:
    """Whether a frame had an image that could show a target: those that had none say nothing of the speed."""
    return solution.published or not solution.reasons <= _NO_IMAGE


def median_frame_time(solutions: Sequence[Solution]) -> float | None:
    """Median seconds of the whole process call over the frames that were worked on; None where none carries it."""
    totals = [s.stage_times[TOTAL] for s in solutions if TOTAL in s.stage_times and worked_on(s)]
    return float(np.median(totals)) if totals else None


def unpublished_reasons(solutions: Sequence[Solution]) -> list[tuple[Reason, int]]:
    """Why frames were not published, and how many for each reason, the most first; a frame may have several."""
    counts = Counter(reason for s in solutions if not s.published for reason in s.reasons)
    return sorted(counts.items(), key=lambda item: (-item[1], item[0].name))


def learned_dimensions(solutions: Sequence[Solution]) -> LearnedDimensions | None:
    """What was known in the end of the size of a target of unknown dimensions."""
    return next((s.dimensions for s in reversed(solutions) if s.dimensions is not None), None)


def dimension_rows(dimensions: LearnedDimensions) -> list[tuple[str, str, str]]:
    """Name, size and standard deviation, mm, as texts."""
    return [
        (name.replace("_", " "), f"{1e3 * size:.2f}", f"{1e3 * dimensions.sigmas_m[name]:.2f}")
        for name, size in dimensions.sizes_m.items()
    ]
