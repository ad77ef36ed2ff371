"""Where the pairs of calibration images come from: a folder, a list, or a film of each camera."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

import attrs
import cv2
import numpy as np

from rvdnav.calibration.storage import read_storage
from rvdnav.errors import InputError
from rvdnav.images import ImageError, PixelArray, read_image
from rvdnav.recording import Entry, list_images, pair
from rvdnav.sequence import PAIRING_TOLERANCE_NS

_PICTURES = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm"}
_FILMS = {".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v"}
_LISTS = {".xml", ".yaml", ".yml"}
_SIDES = (("cam0", "left"), ("cam1", "right"))
_FILM_INTERVAL_S = 0.5
_FALLBACK_FPS = 25.0
_SAME_RATE = 0.01
_TIME_DIGITS = 12
"""Of a name that is a time rather than a number: a quarter of an hour in nanoseconds, a Unix time in milliseconds."""
_Files = tuple[str, Path | None, Path | None]
"""The name of a pair, and the files of its left and right image."""


@attrs.frozen(eq=False)
class ImagePair:
    """The images of one view; a text in place of one says why it is not there."""

    name: str
    images: tuple[PixelArray | str, PixelArray | str]


def read_pairs(path: Path, notices: list[str] | None = None) -> Iterator[ImagePair]:
    """The pairs of a folder or an OpenCV image list, each read when its turn comes.

    A folder holds `cam0` and `cam1` (or left and right) with images in them or in their `data`: of equal names, or
    named by their time or listed with it in `data.csv`, and then paired by it as in `open_sequence`; or
    images called left* and right* (cam0*, cam1*); or a film of each camera, called so, of which two frames a second are
    taken.  A list names the left and the right image of each pair in turn.  What a user should know of the images is
    added to `notices`, each thing once, as they are read.
    Raises InputError naming the file when there is none of these.
    """
    notices = [] if notices is None else notices
    if os.path.isfile(path) and path.suffix.lower() in _LISTS:
        return _pictures(_listed(path), notices)
    if not os.path.isdir(path):
        raise InputError(f"{path}: {'not a folder nor an image list' if os.path.exists(path) else 'no such folder'}")
    folders = [_subfolder(path, names) for names in _SIDES]
    if folders[0] is not None and folders[1] is not None:
        return _pictures(_recorded(path, folders[0], folders[1], notices), notices)
    if folders[0] is not None or folders[1] is not None:
        missing = " or ".join(_SIDES[0 if folders[0] is None else 1])
        raise InputError(f"{path}: has a folder of one camera alone, but none called {missing}")
    films = [_film(path, names) for names in _SIDES]
    if films[0] is not None and films[1] is not None:
        return _frames(films[0], films[1])
    sides = [_merged(path, [_named(path, name) for name in names]) for names in _SIDES]
    if not any(sides):
        raise InputError(f"{path}: holds neither cam0 and cam1, nor images or films called left* and right*")
    return _pictures(_paired(path, sides), notices)


def _subfolder(path: Path, names: tuple[str, ...]) -> Path | None:
    for name in names:
        folder = path / name
        if folder.is_dir():
            return folder / "data" if (folder / "data").is_dir() else folder
    return None


def _recorded(path: Path, left: Path, right: Path, notices: list[str]) -> list[_Files]:
    """The pairs of two folders: by time where that is on record, else by name."""
    folders = (left, right)
    sides = [_named(folder, "") for folder in folders]
    if all(folder.name == "data" and (folder.parent / "data.csv").exists() for folder in folders):
        entries = [list_images(folder.parent, notices) for folder in folders]
    elif all(sides) and all(_is_time(name) for names in sides for name in names):
        found = [[Entry(int(name), file.name, file) for name, file in names.items()] for names in sides]
        entries = [sorted(side, key=lambda entry: entry.timestamp_ns) for side in found]
    else:
        return _paired(path, sides)
    moments = pair(entries[0], entries[1], PAIRING_TOLERANCE_NS, [])
    if not any(moment.left and moment.right for moment in moments):
        tolerance = PAIRING_TOLERANCE_NS / 1e6
        raise InputError(f"{path}: no image of the left camera has one of the right camera within {tolerance:g} ms")
    files = [[None if entry is None else entry.path for entry in (m.left, m.right)] for m in moments]
    return [((left or right or path).stem, left, right) for left, right in files]


def _is_time(name: str) -> bool:
    return name.isascii() and name.isdecimal() and len(name) >= _TIME_DIGITS


def _named(folder: Path, prefix: str) -> dict[str, Path]:
    """Pictures whose name begins with the prefix, by the rest of it."""
    found = {}
    for file in sorted(folder.iterdir()):
        name = file.stem.lower()
        if file.suffix.lower() in _PICTURES and name.startswith(prefix):
            found[name[len(prefix) :].strip("_- ")] = file
    return found


def _merged(folder: Path, found: list[dict[str, Path]]) -> dict[str, Path]:
    used = [names for names in found if names]
    if len(used) > 1:
        raise InputError(f"{folder}: holds both cam0 or cam1 and left or right images; which are meant?")
    return used[0] if used else {}


def _paired(path: Path, sides: list[dict[str, Path]]) -> list[_Files]:
    names = sorted(set(sides[0]) | set(sides[1]))
    if not set(sides[0]) & set(sides[1]):
        raise InputError(f"{path}: no image of the left camera has one of the right camera of the same name")
    return [(name, sides[0].get(name), sides[1].get(name)) for name in names]


def _listed(path: Path) -> list[_Files]:
    storage = read_storage(path)
    names = next(iter(storage.values.values()), None)
    if (
        not isinstance(names, list)
        or not names
        or len(names) % 2
        or not all(isinstance(name, str) and name for name in names)
    ):
        raise InputError(f"{path}: does not list images in pairs of left and right")
    files = [path.parent / name for name in names]
    return [(left.stem, left, right) for left, right in zip(files[::2], files[1::2], strict=True)]


def _pictures(files: list[_Files], notices: list[str]) -> Iterator[ImagePair]:
    for name, left, right in files:
        yield ImagePair(name, (_read(left, "left", notices), _read(right, "right", notices)))


def _read(path: Path | None, side: str, notices: list[str]) -> PixelArray | str:
    if path is None:
        return f"there is no image of the {side} camera"
    try:
        raster = read_image(path)
    except ImageError as error:
        return f"{path.name} {error}"
    told = raster.ignored_orientation
    if told is not None and not any(notice.startswith(told) for notice in notices):
        notices.append(f"{told}, {path.name} the first of them")
    return raster.grey8


def _film(path: Path, names: tuple[str, ...]) -> Path | None:
    for file in sorted(path.iterdir()):
        if file.suffix.lower() in _FILMS and re.match("|".join(names), file.stem.lower()):
            return file
    return None


def _frames(left: Path, right: Path) -> Iterator[ImagePair]:
    captures = [cv2.VideoCapture(str(file)) for file in (left, right)]
    try:
        for file, capture in zip((left, right), captures, strict=True):
            capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 0)  # the pixels as the sensor gave them
            if not capture.isOpened():
                raise InputError(f"{file}: cannot be read as a film")
        rates = [capture.get(cv2.CAP_PROP_FPS) for capture in captures]
        known = [rate for rate in rates if 0.0 < rate < 1000.0]
        if len(known) == 2 and abs(known[0] - known[1]) > _SAME_RATE * max(known):
            raise InputError(
                f"{right}: has {known[1]:g} frames/s but {left.name} has {known[0]:g}: "
                "their frames do not belong together one by one"
            )
        step = max(1, round(_FILM_INTERVAL_S * (known or [_FALLBACK_FPS])[0]))
        index = 0
        while all(capture.grab() for capture in captures):
            if index % step == 0:
                yield ImagePair(f"frame {index}", (_retrieved(captures[0]), _retrieved(captures[1])))
            index += 1
    finally:
        for capture in captures:
            capture.release()


def _retrieved(capture: cv2.VideoCapture) -> PixelArray | str:
    done, pixels = capture.retrieve()
    if not done or pixels is None:
        return "it cannot be decoded"
    grey = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY) if pixels.ndim == 3 else pixels
    return np.ascontiguousarray(grey, dtype=np.uint8)
