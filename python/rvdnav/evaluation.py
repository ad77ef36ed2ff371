"""Errors of a run against the true poses, and how honest its covariances are.

Position error = ||p - p_true||; attitude error = rotation angle of R R_true^T; range = ||p_true||.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, Protocol

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.errors import InputError
from rvdnav.pose.arrays import BoolArray, FloatArray
from rvdnav.pose.so3 import log
from rvdnav.solution import Solution

RANGE_EDGES_M = (0.0, 0.5, 0.8, 1.1, np.inf)
"""Limits of the range bins, each [lower, upper)."""
PAPER_POSITION_M = 0.020
PAPER_ATTITUDE_RAD = float(np.radians(2.0))


class TruePoses(Protocol):
    """Where the true pose of a frame comes from."""

    def at(self, timestamp_ns: int, /) -> FloatArray | None:
        """T_world_target at that time, None where it is unknown."""


@attrs.frozen
class Quantiles:
    """Median, 95th percentile and largest of a set of errors."""

    median: float
    p95: float
    max: float


@attrs.frozen
class RangeRow:
    """The frames whose true range lies in [lower_m, upper_m)."""

    lower_m: float
    upper_m: float
    frames: int
    published: int
    position_m: Quantiles | None
    attitude_rad: Quantiles | None
    """None where nothing was published."""

    @property
    def name(self) -> str:
        """For tables: ``0.5-0.8 m``."""
        if not np.isfinite(self.upper_m):
            return "all" if self.lower_m == 0 else f">= {self.lower_m:g} m"
        return f"< {self.upper_m:g} m" if self.lower_m == 0 else f"{self.lower_m:g}-{self.upper_m:g} m"


@attrs.frozen(eq=False)
class Evaluation:
    """Errors of the published frames that have a true pose (n of them), and what follows from them."""

    run_frames: int
    """All frames of the run."""
    frames: int
    """Frames with a true pose, published or not."""
    timestamps_ns: NDArray[np.int64]
    """(n,)"""
    ranges_m: FloatArray
    """(n,) true range."""
    position_m: FloatArray
    """(n,)"""
    attitude_rad: FloatArray
    """(n,)"""
    components: FloatArray
    """(n, 6) measured minus true in W: position (m), rotation vector of R R_true^T (rad)."""
    sigmas: FloatArray
    """(n, 6) standard deviations claimed for ``components``."""
    nees: FloatArray
    """(n,) normalised estimation error squared; its expectation is 6 for honest covariances."""
    rows: tuple[RangeRow, ...]
    """One for each range bin."""
    overall: RangeRow

    @property
    def published(self) -> int:
        """Published frames with a true pose: n."""
        return int(self.position_m.size)

    @property
    def published_fraction(self) -> float:
        """Of the frames with a true pose."""
        return self.published / self.frames if self.frames else 0.0

    @property
    def mean_nees_ratio(self) -> float:
        """Mean NEES / 6: 1 for honest covariances, above for optimistic ones; NaN with nothing published."""
        return float(self.nees.mean() / 6.0) if self.nees.size else float("nan")

    @property
    def within_3_sigma(self) -> FloatArray:
        """(6,) fraction of the published frames whose error is within 3 sigma, by component."""
        if not self.published:
            return np.full(6, np.nan)
        return np.asarray((np.abs(self.components) <= 3.0 * self.sigmas).mean(axis=0), dtype=np.float64)

    @property
    def within_paper_limits(self) -> float:
        """Fraction of the published frames within 20 mm and 2 degrees; NaN with nothing published."""
        if not self.published:
            return float("nan")
        good = (self.position_m <= PAPER_POSITION_M) & (self.attitude_rad <= PAPER_ATTITUDE_RAD)
        return float(good.mean())

    @property
    def wrong(self) -> BoolArray:
        """(n,) off by more than 20 mm or 2 degrees * (1 + range / 1 m)."""
        return is_wrong(self.position_m, self.attitude_rad, self.ranges_m)

    def to_json(self) -> dict[str, Any]:
        """As an object for ``json.dumps``: counts, errors (m, rad) over all and by range; null where there is none."""
        judged = bool(self.published)
        return {
            "frames": self.frames,
            "published": self.published,
            "wrong": int(self.wrong.sum()),
            "mean_nees_ratio": self.mean_nees_ratio if judged else None,
            "within_3_sigma": self.within_3_sigma.tolist() if judged else None,
            "within_paper_limits": self.within_paper_limits if judged else None,
            "ranges": {row.name: attrs.asdict(row) | {"upper_m": _finite(row.upper_m)} for row in self.rows},
            "overall": attrs.asdict(self.overall) | {"upper_m": None},
        }


def _finite(value: float) -> float | None:
    return value if np.isfinite(value) else None


def is_wrong(position_m: FloatArray, attitude_rad: FloatArray, ranges_m: FloatArray) -> BoolArray:
    """(n,) which poses are wrong, from their errors and true ranges (n,): off by more than 20 mm or 2 degrees *
    (1 + range / 1 m)."""
    limit = PAPER_ATTITUDE_RAD * (1.0 + ranges_m)
    return np.asarray((position_m > PAPER_POSITION_M) | (attitude_rad > limit), dtype=np.bool_)


def pose_error(T_world_target: FloatArray, T_world_true: FloatArray) -> FloatArray:
    """(6,) measured minus true: position in W (m), rotation vector of R R_true^T (rad).

    It is the negative of the perturbation (dp, dtheta) that takes the measured pose to the true one in the covariance's
    convention, so its covariance is the same.
    """
    rotation = log(T_world_target[:3, :3] @ T_world_true[:3, :3].T)
    return np.concatenate([T_world_target[:3, 3] - T_world_true[:3, 3], rotation])


def evaluate(solutions: Sequence[Solution], truth: TruePoses) -> Evaluation:
    """Judge the published raw poses of a run.  Raises InputError when no frame of the run has a true pose."""
    pairs = [(solution, truth.at(solution.timestamp_ns)) for solution in solutions]
    known = [(solution, pose) for solution, pose in pairs if pose is not None]
    if not known:
        raise InputError("no frame of the run has a true pose: is it the same sequence?")
    all_ranges = np.array([np.linalg.norm(pose[:3, 3]) for _, pose in known])
    published = np.array([solution.published for solution, _ in known])

    judged = [(s.timestamp_ns, s.T_world_target, s.covariance, pose) for s, pose in known]
    timestamps, components, covariances = [], [], []
    for timestamp_ns, measured, covariance, pose in judged:
        if measured is not None and covariance is not None:
            timestamps.append(timestamp_ns)
            components.append(pose_error(measured, pose))
            covariances.append(covariance)
    errors = np.array(components).reshape(-1, 6)
    covariance_stack = np.array(covariances).reshape(-1, 6, 6)
    position = np.linalg.norm(errors[:, :3], axis=1)
    attitude = np.linalg.norm(errors[:, 3:], axis=1)
    rows = [_row(lower, upper, all_ranges, published, position, attitude) for lower, upper in pairwise(RANGE_EDGES_M)]
    return Evaluation(
        run_frames=len(pairs),
        frames=len(known),
        timestamps_ns=np.array(timestamps, dtype=np.int64),
        ranges_m=all_ranges[published],
        position_m=position,
        attitude_rad=attitude,
        components=errors,
        sigmas=np.sqrt(np.einsum("nii->ni", covariance_stack)),
        nees=np.einsum("ni,ni->n", errors, np.linalg.solve(covariance_stack, errors[:, :, None])[:, :, 0]),
        rows=tuple(rows),
        overall=_row(0.0, np.inf, all_ranges, published, position, attitude),
    )


def _row(
    lower: float, upper: float, ranges: FloatArray, published: BoolArray, position: FloatArray, attitude: FloatArray
) -> RangeRow:
    inside = (ranges >= lower) & (ranges < upper)
    chosen = inside[published]
    return RangeRow(
        lower_m=lower,
        upper_m=upper,
        frames=int(inside.sum()),
        published=int(chosen.sum()),
        position_m=_quantiles(position[chosen]),
        attitude_rad=_quantiles(attitude[chosen]),
    )


def _quantiles(errors: FloatArray) -> Quantiles | None:
    if not errors.size:
        return None
    median, p95 = np.percentile(errors, [50.0, 95.0])
    return Quantiles(median=float(median), p95=float(p95), max=float(errors.max()))
