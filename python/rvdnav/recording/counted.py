"""Pictures without times, taken at a steady, stated rate: a number in each name counts them."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Sequence
from pathlib import Path

from rvdnav.errors import InputError
from rvdnav.files import MOST_LINES
from rvdnav.recording.camera_folder import INDEX
from rvdnav.recording.entry import Entry
from rvdnav.recording.sides import SIDES

PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm")
RATES_HZ = (1e-3, 1e5)
_TIME_DIGITS = 12
"""Of a number that is a time: a quarter of an hour in nanoseconds, a Unix time in milliseconds."""
_LONGEST_S = 1e9


def list_counted(folder: Path, places: Sequence[Path | None], rate_hz: float) -> tuple[list[Entry], list[Entry]]:
    """What the left and the right camera recorded, in time order, stamps counted from the first picture of either.

    places: their folders, each with the pictures in it or in its `data`; where there are none, the pictures are in
    `folder` itself, their names beginning with the camera's.  The last number in a name counts; pictures of equal
    numbers belong together, and one that is missing leaves a gap.
    Raises InputError naming the file when one has no number, two have the same, or they have times of their own.
    """
    if not RATES_HZ[0] <= rate_hz <= RATES_HZ[1]:
        raise InputError(f"a frame rate of {rate_hz:g} Hz is not from {RATES_HZ[0]:g} to {RATES_HZ[1]:g}")
    if any(places):
        sides = [{} if place is None else _numbered(_files(place)) for place in places]
    else:
        files = _pictures(folder)
        sides = [_numbered([file for file in files if file.name.lower().startswith(names)]) for names in SIDES]
    numbers = sorted({number for side in sides for number in side})
    if not numbers:
        raise InputError(f"{folder}: holds no pictures of a camera: none in cam0, cam1, left or right, or called so")
    step = math.gcd(*(number - numbers[0] for number in numbers)) or 1
    if (numbers[-1] - numbers[0]) // step > _LONGEST_S * rate_hz:
        raise InputError(f"{folder}: its pictures are numbered from {numbers[0]} to {numbers[-1]}, which is no count")
    left, right = (
        [
            Entry(round((number - numbers[0]) // step * 1e9 / rate_hz), str(file.relative_to(folder)), file)
            for number, file in sorted(side.items())
        ]
        for side in sides
    )
    return left, right


def _files(place: Path) -> list[Path]:
    if not os.path.isdir(place):
        raise InputError(f"{place}: has times of its own; a frame rate is for pictures without")
    if os.path.lexists(place / INDEX):
        raise InputError(f"{place / INDEX}: has the pictures' times; a frame rate is for pictures without")
    return _pictures(place / "data" if os.path.isdir(place / "data") else place)


def _pictures(folder: Path) -> list[Path]:
    try:
        names = sorted(os.listdir(folder))
    except OSError as error:
        raise InputError(f"{folder}: cannot be read: {error.strerror}") from error
    pictures = [folder / name for name in names if name.lower().endswith(PICTURES)]
    if len(pictures) > 2 * MOST_LINES:
        raise InputError(f"{folder}: more than {2 * MOST_LINES} pictures")
    return pictures


def _numbered(files: list[Path]) -> dict[int, Path]:
    numbered: dict[int, Path] = {}
    for file in files:
        found = re.findall("[0-9]+", re.sub("^(cam|CAM)[01]", "", file.stem))
        if not found:
            raise InputError(f"{file}: has no number in its name that would count it")
        if len(found[-1]) >= _TIME_DIGITS:
            raise InputError(f"{file}: is named by its time; a frame rate is for pictures without")
        number = int(found[-1])
        if number in numbered:
            raise InputError(f"{file}: has the number of {numbered[number].name}")
        numbered[number] = file
    return numbered
