"""Figures of a run that need no truth: claimed uncertainty, what was learnt, and wall times."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from rvdnav.corrections import Corrections
from rvdnav.rig import Rig
from rvdnav.solution import TOTAL, LearnedDimensions, Reason, Solution
from rvdnav.target import Target

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

_TOLERANCES = (Reason.TARGET_TOLERANCE, Reason.CALIBRATION)


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
    return counted(reason for s in solutions if not s.published for reason in s.reasons)


def counted(reasons: Iterable[Reason]) -> list[tuple[Reason, int]]:
    """How often each reason occurs, the most frequent first."""
    return sorted(Counter(reasons).items(), key=lambda item: (-item[1], item[0].name))


def run_record(solutions: Sequence[Solution]) -> dict[str, Any]:
    """What a run gave, as an object for ``json.dumps``: counts, claimed standard deviations (m, rad), seconds."""
    sigmas = median_sigmas(solutions)
    return {
        "frames": len(solutions),
        "published": sum(s.published for s in solutions),
        "states": dict(Counter(s.state.name for s in solutions)),
        "unpublished": {reason.name: count for reason, count in unpublished_reasons(solutions)},
        "median_sigma_position_m": None if sigmas is None else sigmas[0],
        "median_sigma_attitude_rad": None if sigmas is None else sigmas[1],
        "median_frame_s": median_frame_time(solutions),
    }


def learned_dimensions(solutions: Sequence[Solution]) -> LearnedDimensions | None:
    """What was known in the end of the size of a target of unknown dimensions."""
    return next((s.dimensions for s in reversed(solutions) if s.dimensions is not None), None)


def dimension_rows(dimensions: LearnedDimensions) -> list[tuple[str, str, str]]:
    """Name, size and standard deviation, mm, as texts."""
    return [
        (name.replace("_", " "), f"{1e3 * size:.2f}", f"{1e3 * dimensions.sigmas_m[name]:.2f}")
        for name, size in dimensions.sizes_m.items()
    ]


# Unit and factor to it, by the first letter of a calibration's parameter.
_UNITS = {"f": (" px", 1.0), "c": (" px", 1.0), "r": ("°", float(np.degrees(1.0))), "t": (" mm", 1e3)}


def last_corrections(solutions: Sequence[Solution]) -> Corrections | None:
    """Those of the last published frame; None where there is none or nothing to correct."""
    return next((s.corrections for s in reversed(solutions) if s.corrections is not None), None)


def correction_rows(corrections: Corrections) -> list[tuple[str, str, str, str]]:
    """Name, correction, its ± σ and what was stated as ± σ, with units; a point's three coordinates together."""
    rows = []
    for name, own in corrections.calibration.items():
        unit, factor = _UNITS.get(name.partition(".")[2][0], ("", 1.0))
        stated, value, sigma = (factor * number for number in (own.stated, own.value, own.sigma))
        rows.append((name, _signed(value, sigma) + unit, f"± {sigma:.2g}{unit}", f"± {stated:.2g}{unit}"))
    for name, point in corrections.points.items():
        values = ", ".join(_signed(1e3 * v, 1e3 * s) for v, s in zip(point.value, point.sigma, strict=True))
        sigmas = ", ".join(f"{1e3 * sigma:.2g}" for sigma in point.sigma)
        rows.append((name, f"{values} mm", f"± {sigmas} mm", f"± {1e3 * point.stated:.2g} mm"))
    return rows


def _signed(value: float, sigma: float) -> str:
    """With as many decimals as two digits of its standard deviation have."""
    decimals = max(1 - int(np.floor(np.log10(sigma))), 0)
    return f"{value:+.{decimals}f}".replace("-", "−")


def correction_text(corrections: Corrections) -> str:
    """The largest corrections, by what was stated, on one line."""
    by_size = sorted(corrections.calibration, key=lambda name: -corrections.calibration[name].in_stated)
    chosen = {*by_size[:2], *sorted(corrections.points, key=lambda name: -corrections.points[name].in_stated)[:1]}
    parts = [
        f"{name} {value} {sigma} (stated {stated})"
        for name, value, sigma, stated in correction_rows(corrections)
        if name in chosen
    ]
    frames = "1 frame" if corrections.frames == 1 else f"{corrections.frames} frames"
    return f"largest corrections by {frames}: " + "; ".join(parts)


def tolerance_alarms(solutions: Sequence[Solution]) -> list[tuple[Reason, int]]:
    """In how many frames what was stated of target and calibration seemed too good; nothing for those without any."""
    counts = [(reason, sum(reason in s.reasons for s in solutions)) for reason in _TOLERANCES]
    return [(reason, count) for reason, count in counts if count]


def points_knowledge(target: Target) -> str:
    """To what a target's points are taken for known, and whether its file says so."""
    if not target.dimensions_known:
        return "points not at all (dimensions: unknown)"
    sigmas = [1e3 * target.point_sigma(name) for name in target.points]
    span = f"{min(sigmas):g}" if min(sigmas) == max(sigmas) else f"{min(sigmas):g} to {max(sigmas):g}"
    if target.tolerance is None:
        return f"points to {span} mm (tolerance not stated: as with calipers)"
    return f"points to {span} mm" if any(sigmas) else "points exactly"


def calibration_knowledge(rig: Rig) -> str:
    """To what a rig's calibration is taken for known, and whether its files say so."""
    if rig.calibration_covariance is None:
        return "calibration as made by hand (covariance not stated)"
    return f"calibration {'to the covariance of rig.yaml' if rig.calibration_covariance.any() else 'exactly'}"
