"""What a frame call gives, copied out of the core's structures."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.core.library import constants

_STAGES = [name for value, name in sorted(constants("RVDNAV_STAGE_").items())]
_LIMITS = constants("RVDNAV_LIMIT_")


@attrs.frozen(eq=False)
class ViewResult:
    """One view: LINE records of the eight edges, and the apexes P1..P4, Q1..Q4 in rectified pixels."""

    lines: NDArray[np.void]
    """(8,) LINE records."""
    line_found: NDArray[np.bool_]
    """(8,)"""
    apexes: NDArray[np.float64]
    """(8, 2) rectified pixels, meaningful where ``apex_found``."""
    apex_found: NDArray[np.bool_]
    """(8,)"""
    edge_count: int
    peak_count: int
    segment_count: int
    bar_count: int
    mean_grey: float
    saturated: float
    """Fraction of saturated pixels."""
    limits: frozenset[str]
    """Work limits that were hit: "edgels", "peaks", "segments", "bars", "hypotheses", "rho"."""
    stage_ns: dict[str, int]
    """Time of each stage."""


@attrs.frozen(eq=False)
class Bracket:
    """The bracket as acquired without a prior."""

    found: bool
    ambiguous: bool
    score: float
    """Supported fraction of the bracket's edges over both views, 0..1."""
    runner_up: float
    """Score of the best clearly different pose."""
    T_world_target: NDArray[np.float64]
    """(4, 4), meaningful where ``found``."""
    hypotheses: int
    """Number tested."""


@attrs.frozen(eq=False)
class FrameResult:
    """A frame: its views (None where there was no image), the acquired bracket, points in space."""

    views: tuple[ViewResult | None, ViewResult | None]
    bracket: Bracket | None
    """None when windows were given."""
    apexes_W: NDArray[np.float64]
    """(8, 3) metres, meaningful where ``apex_found``."""
    apex_found: NDArray[np.bool_]
    """(8,)"""
    matches: NDArray[np.void]
    """MATCH records of the correlated points."""
    limits: frozenset[str]
    stage_ns: dict[str, int]
    """Time of each stage of the join alone."""


def frame_result(
    record: Any, has_view: tuple[bool, bool], acquired: bool, T_world_core: NDArray[np.float64]
) -> FrameResult:
    """From one FRAME_RESULT record, with T_world_core (4, 4) from the core's world to W."""
    return FrameResult(
        views=(
            _view_result(record["view"][0]) if has_view[0] else None,
            _view_result(record["view"][1]) if has_view[1] else None,
        ),
        bracket=_bracket(record["bracket"], T_world_core) if acquired else None,
        apexes_W=record["apexes_W"].copy(),
        apex_found=_mask(record["apex_mask"], 8),
        matches=record["matches"][: record["match_count"]].copy(),
        limits=_limit_names(record["limits"]),
        stage_ns=_stage_times(record["stage_ns"]),
    )


def _view_result(record: Any) -> ViewResult:
    return ViewResult(
        lines=record["lines"].copy(),
        line_found=_mask(record["line_mask"], 8),
        apexes=record["apexes"].copy(),
        apex_found=_mask(record["apex_mask"], 8),
        edge_count=int(record["edge_count"]),
        peak_count=int(record["peak_count"]),
        segment_count=int(record["segment_count"]),
        bar_count=int(record["bar_count"]),
        mean_grey=float(record["mean_grey"]),
        saturated=float(record["saturated_permille"]) / 1000.0,
        limits=_limit_names(record["limits"]),
        stage_ns=_stage_times(record["stage_ns"]),
    )


def _bracket(record: Any, T_world_core: NDArray[np.float64]) -> Bracket:
    T = np.eye(4)
    T[:3, :3] = record["R_W_C"].reshape(3, 3)
    T[:3, 3] = record["p_W"]
    return Bracket(
        found=bool(record["found"]),
        ambiguous=bool(record["ambiguous"]),
        score=float(record["score"]),
        runner_up=float(record["runner_up"]),
        T_world_target=T_world_core @ T,
        hypotheses=int(record["hypotheses"]),
    )


def _mask(bits: Any, count: int) -> NDArray[np.bool_]:
    return (int(bits) >> np.arange(count) & 1).astype(np.bool_)


def _limit_names(bits: Any) -> frozenset[str]:
    return frozenset(name for bit, name in _LIMITS.items() if int(bits) & bit)


def _stage_times(stage_ns: NDArray[np.uint64]) -> dict[str, int]:
    return {name: int(ns) for name, ns in zip(_STAGES, stage_ns, strict=True)}
