"""Where the pairs of calibration images come from: a folder, a list, or a film of each camera."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import attrs
import cv2
import numpy as np
from numpy.typing import ArrayLike

from rvdnav.calibration.storage import read_storage
from rvdnav.errors import InputError
from rvdnav.images import ImageError, PixelArray, read_image

_PICTURES = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm"}
_FILMS = {".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v"}
_LISTS = {".xml", ".yaml", ".yml"}
_SIDES = (("cam0", "left"), ("cam1", "right"))
_FILM_INTERVAL_S = 0.5
_FALLBACK_FPS = 25.0


@attrs.frozen(eq=False)
class ImagePair:
    """The images of one view; a text in place of one says why it is not there."""

    name: str
    images: tuple[PixelArray | str, PixelArray | str]


def read_pairs(path: Path, notices: list[str] | None = None) -> Iterator[ImagePair]:
    """The pairs of a folder or an OpenCV image list, each read when its turn comes.

    A folder holds `cam0` and `cam1` (or left and right) with images of equal names, in them or in their `data`; or
    images called left* and right* (cam0*, cam1*); or a film of each camera, called so, of which two frames a second are
    taken.  A list names the left and the right image of each pair in turn.  What a user should know of the images is
    added to `notices`, each thing once, as they are read.
    Raises InputError naming the file when there is none of these.
    """
    notices = [] if notices is None else notices
    if path.is_file() and path.suffix.lower() in _LISTS:
        return _pictures(_listed(path), notices)
    if not path.is_dir():
        raise InputError(f"{path}: {'not a folder nor an image list' if path.exists() else 'no such folder'}")
    folders = [_subfolder(path, names) for names in _SIDES]
    if folders[0] is not None and folders[1] is not None:
        return _pictures(_paired(path, [_named(folder, "") for folder in folders if folder is not None]), notices)
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


def _paired(path: Path, sides: list[dict[str, Path]]) -> list[tuple[str, Path | None, Path | None]]:
    names = sorted(set(sides[0]) | set(sides[1]))
    if not set(sides[0]) & set(sides[1]):
        raise InputError(f"{path}: no image of the left camera has one of the right camera of the same name")
    return [(name, sides[0].get(name), sides[1].get(name)) for name in names]


def _listed(path: Path) -> list[tuple[str, Path | None, Path | None]]:
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


def _pictures(files: list[tuple[str, Path | None, Path | None]], notices: list[str]) -> Iterator[ImagePair]:
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
        fps = captures[0].get(cv2.CAP_PROP_FPS)
        step = max(1, round(_FILM_INTERVAL_S * (fps if 0.0 < fps < 1000.0 else _FALLBACK_FPS)))
        index = 0
        while all(capture.grab() for capture in captures):
            if index % step == 0:
                images = [capture.retrieve()[1] for capture in captures]
                yield ImagePair(f"frame {index}", (_grey(images[0]), _grey(images[1])))
            index += 1
    finally:
        for capture in captures:
            capture.release()


def _grey(pixels: ArrayLike) -> PixelArray:
    colours = np.asarray(pixels, dtype=np.uint8)
    grey = cv2.cvtColor(colours, cv2.COLOR_BGR2GRAY) if colours.ndim == 3 else colours
    return np.ascontiguousarray(grey, dtype=np.uint8)
