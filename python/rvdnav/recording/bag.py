"""A ROS 2 bag as a recording."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from rvdnav.conventions import format_timestamp_s
from rvdnav.recording.entry import Entry
from rvdnav.recording.recording import Recording
from rvdnav.ros.bag import Images, open_bag
from rvdnav.ros.camera_info import read_camera_infos


def read_bag(path: Path, topics: Sequence[str] | None, notices: list[str]) -> Recording:
    """The recording in a bag; the files about it lie in its folder.  Raises InputError as `open_bag` does."""
    bag = open_bag(path, topics, notices)
    left, right = (_entries(path, images) for images in (bag.left, bag.right))
    folder = path if os.path.isdir(path) else path.parent
    return Recording(folder, left, right, partial(read_camera_infos, path, bag))


def _entries(path: Path, images: Images | None) -> list[Entry]:
    if images is None:
        return []
    return [
        Entry(stamp, f"{images.topic} at {format_timestamp_s(stamp)} s", path, container=images)
        for stamp in images.messages
    ]
