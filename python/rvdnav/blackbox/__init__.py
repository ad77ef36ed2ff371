"""The black box: the last frames before the target was lost, and their replay to the same bits."""

from rvdnav.blackbox.recorder import DEFAULT_FRAMES, Recorder
from rvdnav.blackbox.replay import Difference, Replay, replay

__all__ = ["DEFAULT_FRAMES", "Difference", "Recorder", "Replay", "replay"]
