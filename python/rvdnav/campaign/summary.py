"""What a campaign says: errors against range, availability, wrong poses with a confidence bound."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import attrs
import numpy as np

from rvdnav.evaluation import RANGE_EDGES_M
from rvdnav.extras import needs_extra
from rvdnav.pose.arrays import FloatArray
from rvdnav.solution import Reason
from rvdnav.summary import counted

with needs_extra("campaign", "campaigns"):
    import pyarrow as pa
    from scipy.stats import beta

CONFIDENCE = 0.95


@attrs.frozen
class Group:
    """The frames of one fault, one source, one range bin, or all.

    frames, published: numbers.  judged: published poses whose true one is known, from which all that follows comes.
    wrong: those off by more than 20 mm or 2 degrees (1 + range / 1 m).  wrong_bound: upper bound of their rate at
    CONFIDENCE, as if frames were independent.  position_m, attitude_rad: median, 95th percentile and largest error
    (3,), NaN without any.
    """

    name: str
    trials: int
    frames: int
    published: int
    judged: int
    wrong: int
    wrong_bound: float
    trials_wrong: int
    mean_nees_ratio: float
    position_m: FloatArray
    attitude_rad: FloatArray

    @property
    def availability(self) -> float:
        """Part of the frames with a published pose."""
        return self.published / self.frames if self.frames else float("nan")


@attrs.frozen
class Summary:
    """All frames together, and by fault, by source and by true range."""

    overall: Group
    by_fault: tuple[Group, ...]
    by_source: tuple[Group, ...]
    by_range: tuple[Group, ...]
    reasons: tuple[tuple[Reason, int], ...]
    """Why frames were not published, and how many for each reason; a frame may have several."""
    trials_wrong_bound: float
    """Upper bound at CONFIDENCE of the part of trials with any wrong pose; trials are independent, frames are not."""


def upper_bound(events: int, trials: int) -> float:
    """Upper Clopper-Pearson bound at CONFIDENCE (one-sided) of a rate: events in trials; 1 without any trial.

    C. J. Clopper, E. S. Pearson, "The use of confidence or fiducial limits illustrated in the case of the binomial",
    Biometrika 26 (1934).
    """
    if events >= trials:
        return 1.0
    return float(beta.ppf(CONFIDENCE, events + 1, trials - events))


def summarise(rows: pa.Table) -> Summary:
    """The summary of a campaign's rows (see `store.SCHEMA`)."""
    columns = {name: np.array(rows.column(name).to_pylist(), dtype=object) for name in rows.column_names}
    ranges = np.array([np.nan if value is None else value for value in columns["range_m"]], dtype=np.float64)
    everything = np.ones(len(ranges), np.bool_)
    overall = _group("all", columns, everything)
    return Summary(
        overall=overall,
        by_fault=_by(columns, "fault"),
        by_source=_by(columns, "source"),
        by_range=tuple(
            _group(_bin_name(low, high), columns, (ranges >= low) & (ranges < high))
            for low, high in pairwise(RANGE_EDGES_M)
        ),
        reasons=tuple(_reasons(columns)),
        trials_wrong_bound=upper_bound(overall.trials_wrong, overall.trials),
    )


def _reasons(columns: dict[str, Any]) -> list[tuple[Reason, int]]:
    refused = columns["reasons"][~columns["published"].astype(np.bool_)]
    return counted(Reason[name] for names in refused for name in names.split())


def _bin_name(low: float, high: float) -> str:
    return f"from {low:g} m" if not np.isfinite(high) else f"{low:g}-{high:g} m" if low else f"below {high:g} m"


def _by(columns: dict[str, Any], name: str) -> tuple[Group, ...]:
    return tuple(_group(value, columns, columns[name] == value) for value in dict.fromkeys(columns[name]))


def _group(name: str, columns: dict[str, Any], chosen: Any) -> Group:
    published = columns["published"][chosen].astype(np.bool_)
    wrong = np.array([value is True for value in columns["wrong"][chosen]], np.bool_)
    trials = columns["trial"][chosen]
    position, attitude, nees = (
        _numbers(columns[key][chosen]) for key in ("position_error_m", "attitude_error_rad", "nees")
    )
    return Group(
        name=name,
        trials=len(set(trials)),
        frames=int(chosen.sum()),
        published=int(published.sum()),
        judged=len(position),
        wrong=int(wrong.sum()),
        wrong_bound=upper_bound(int(wrong.sum()), len(position)),
        trials_wrong=len(set(trials[wrong])),
        mean_nees_ratio=float(nees.mean() / 6.0) if nees.size else float("nan"),
        position_m=_quantiles(position),
        attitude_rad=_quantiles(attitude),
    )


def _numbers(values: Sequence[float | None]) -> FloatArray:
    return np.array([value for value in values if value is not None], dtype=np.float64)


def _quantiles(errors: FloatArray) -> FloatArray:
    if not errors.size:
        return np.full(3, np.nan)
    quantiles: FloatArray = np.percentile(errors, [50.0, 95.0, 100.0])
    return quantiles
