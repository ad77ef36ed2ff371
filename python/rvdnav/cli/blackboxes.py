"""Where the black boxes of a run stand among its results."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rvdnav.solution import Solution, State

BLACK_BOXES = "blackbox"
"""Their folder in that of the results."""


def black_boxes(directory: Path, solutions: Iterable[Solution]) -> dict[int, str]:
    """Timestamp, ns, of each frame that lost the target -> its black box, relative to the folder of the results."""
    folders = {s.timestamp_ns: f"{BLACK_BOXES}/{s.timestamp_ns}" for s in solutions if s.state is State.LOST}
    return {timestamp_ns: folder for timestamp_ns, folder in folders.items() if (directory / folder).is_dir()}
