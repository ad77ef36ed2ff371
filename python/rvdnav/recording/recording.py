"""What a recording holds, whatever its layout."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import attrs

from rvdnav.recording.entry import Entry
from rvdnav.rig import CameraChain


@attrs.frozen
class Recording:
    """What the cameras recorded, in time order, and what the recording itself says of them.

    folder: where the other files about it lie.  chain: reads its own calibration; None where it has none.
    """

    folder: Path
    left: list[Entry]
    right: list[Entry]
    chain: Callable[[], CameraChain] | None = None
