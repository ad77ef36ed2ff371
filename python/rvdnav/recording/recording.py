"""The layouts of recordings: which one a folder has, and what its cameras recorded."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path

import attrs

from rvdnav.errors import InputError
from rvdnav.recording.camera_folder import list_images
from rvdnav.recording.counted import list_counted
from rvdnav.recording.entry import Entry
from rvdnav.recording.sides import SIDES, find_place
from rvdnav.rig import SENSOR, CameraChain, read_sensors


@attrs.frozen
class Recording:
    """What the cameras recorded, in time order, and what the recording itself says of them.

    folder: where the other files about it lie.  chain: reads its own calibration; None where it has none.
    """

    folder: Path
    left: list[Entry]
    right: list[Entry]
    chain: Callable[[], CameraChain] | None = None


def is_recording(path: Path) -> bool:
    """Whether there is a folder or video of a camera at a path.  Raises InputError where either of two may be one."""
    return os.path.isdir(path) and any(_places(path)[1])


def read_recording(path: Path, rate_hz: float | None, notices: list[str]) -> Recording:
    """The recording at a path: a folder in one of the layouts of `open_sequence`.

    rate_hz: of pictures without times.  What a user should know is told to `notices`.
    Raises InputError naming the file when there is none, or it is malformed.
    """
    if not os.path.isdir(path):
        raise InputError(f"{path}: {'not a folder' if os.path.exists(path) else 'no such folder'}")
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
