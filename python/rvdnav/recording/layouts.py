"""The layouts of recordings: which one a folder has, and what its cameras recorded."""

from __future__ import annotations

import os
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from rvdnav.errors import InputError
from rvdnav.recording.bag import read_bag
from rvdnav.recording.camera_folder import list_images
from rvdnav.recording.counted import list_counted
from rvdnav.recording.recording import Recording
from rvdnav.recording.sides import SIDES, find_place
from rvdnav.rig import SENSOR, read_sensors
from rvdnav.ros.bag import is_bag


def is_recording(path: Path) -> bool:
    """Whether a path is that of a bag, or there is a folder or video of a camera.

    Raises InputError where either of two may be a camera's.
    """
    return is_bag(path) or (os.path.isdir(path) and any(_places(path)[1]))


def read_recording(path: Path, rate_hz: float | None, topics: Sequence[str] | None, notices: list[str]) -> Recording:
    """The recording at a path: a folder in one of the layouts of docs/sequences.md, or a bag.

    rate_hz: of pictures without times.  topics: of a bag's images, the left one first.  What a user should know is told
    to `notices`.  Raises InputError naming the file when there is none, or it is malformed.
    """
    if is_bag(path):
        if rate_hz is not None:
            raise InputError(f"{path}: has times of its own; a frame rate is for pictures without")
        return read_bag(path, topics, notices)
    if path.suffix == ".bag":
        raise InputError(f"{path}: a bag of ROS 1 is not read; rosbags-convert makes one of ROS 2 of it")
    if not os.path.isdir(path):
        raise InputError(f"{path}: {'not a folder' if os.path.exists(path) else 'no such folder'}")
    if topics is not None:
        raise InputError(f"{path}: not a bag; there are no topics in it")
    images, places = _places(path)
    if rate_hz is not None:
        left, right = list_counted(images, places, rate_hz)
        return Recording(path, left, right)
    if not any(places):
        raise InputError(f"{path}: not a sequence: holds neither cam0 nor cam1")
    left, right = ([] if place is None else list_images(place, notices) for place in places)
    sensors = [place / SENSOR for place in places if place is not None]
    described = all(os.path.lexists(sensor) for sensor in sensors)
    return Recording(path, left, right, partial(read_sensors, sensors) if described else None)


def _places(path: Path) -> tuple[Path, list[Path | None]]:
    """Where the images of a folder are, and there each camera's folder or video."""
    images = path / "mav0" if os.path.isdir(path / "mav0") else path
    return images, [find_place(images, names) for names in SIDES]
