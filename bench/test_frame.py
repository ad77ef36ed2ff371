"""The whole process call on stereo frames; at least 8 frames/s, for acquisition and for tracking."""

from __future__ import annotations

from typing import Any

import pytest
from rvdnav import Frame, Navigator, Sequence

FRAMES_PER_SECOND = 8.0


def assert_fast_enough(benchmark: Any) -> None:
    if benchmark.enabled:
        assert benchmark.stats.stats.median <= 1.0 / FRAMES_PER_SECOND


@pytest.mark.benchmark(group="frame")
def test_acquisition(benchmark: Any, sequence: Sequence, frames: list[Frame]) -> None:
    """Every frame by a fresh navigator, that is without a prior."""
    remaining = iter(frames)
    published = []

    def fresh() -> tuple[tuple[Navigator, Frame], dict[str, Any]]:
        return (Navigator(sequence.rig, sequence.target), next(remaining)), {}

    def acquire(navigator: Navigator, frame: Frame) -> None:
        published.append(navigator.process(frame).published)

    benchmark.pedantic(acquire, setup=fresh, rounds=len(frames), iterations=1)
    assert sum(published) >= 0.8 * len(published)  # giving up early would be fast, too
    assert_fast_enough(benchmark)


@pytest.mark.benchmark(group="frame")
def test_tracking(benchmark: Any, sequence: Sequence, frames: list[Frame]) -> None:
    """Every frame after the first by one navigator, that is with a prediction."""
    navigator = Navigator(sequence.rig, sequence.target)
    navigator.process(frames[0])
    remaining = iter(frames[1:])
    published = []

    def track(frame: Frame) -> None:
        published.append(navigator.process(frame).published)

    benchmark.pedantic(track, setup=lambda: ((next(remaining),), {}), rounds=len(frames) - 1, iterations=1)
    assert sum(published) >= 0.8 * len(published)
    assert_fast_enough(benchmark)
