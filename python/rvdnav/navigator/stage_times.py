"""Wall times of a frame's stages: name -> seconds, to which every stage adds what it took."""

from __future__ import annotations

import time

from rvdnav.core import FrameResult


def now() -> float:
    """A time to count from, s."""
    return time.perf_counter()


def lap(times: dict[str, float], stage: str, start: float) -> float:
    """Add to a stage's time what has passed since the start; the time now, for the next stage to start at."""
    end = now()
    times[stage] = times.get(stage, 0.0) + end - start
    return end


def add_frame_times(times: dict[str, float], frame: FrameResult) -> None:
    """Add those of a frame call: of each stage the slower of the two views, which run at once, and the join."""
    for stage, joined in frame.stage_ns.items():
        slowest = max((view.stage_ns[stage] for view in frame.views if view is not None), default=0)
        times[stage] = times.get(stage, 0.0) + (slowest + joined) * 1e-9
