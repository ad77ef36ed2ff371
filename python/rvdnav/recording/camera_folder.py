"""What one camera recorded: pictures in its folder, by their index or by names that are times, or a video."""

from __future__ import annotations

import os
from pathlib import Path

import attrs

from rvdnav.conventions import NANOSECONDS, parse_timestamp_ns, timestamp_unit
from rvdnav.errors import InputError
from rvdnav.files import MOST_LINES, plain_name, read_rows
from rvdnav.recording.entry import Entry
from rvdnav.video import FORMATS, open_video

INDEX = "data.csv"


def list_images(place: Path, notices: list[str]) -> list[Entry]:
    """What one camera recorded, in time order: in its folder, or in its video.

    A unit of its stamps other than nanoseconds (see `timestamp_unit`) is told to `notices`.
    Raises InputError naming the file when it holds no images, or they don't say when they were taken.
    """
    if place.suffix in FORMATS:
        return _video_frames(place)
    entries = _read_index(place) if os.path.lexists(place / INDEX) else _read_names(place)
    if not entries:
        raise InputError(
            f"{place}: holds no images: no row in {INDEX}, or no data/<timestamp in ns>.png without it; pictures whose "
            "names are no times need a frame rate"
        )
    entries = sorted(entries, key=lambda entry: entry.timestamp_ns)
    try:
        unit = timestamp_unit([entry.timestamp_ns for entry in entries])
    except ValueError as error:
        raise InputError(f"{place}: {error}; names that count need a frame rate") from error
    if unit is NANOSECONDS:
        return entries
    notices.append(f"{place.name}: the timestamps are taken for {unit.name} of Unix time")
    return [attrs.evolve(entry, timestamp_ns=entry.timestamp_ns * unit.ns) for entry in entries]


def _video_frames(path: Path) -> list[Entry]:
    video = open_video(path)
    return [Entry(stamp, f"{path.name} at {stamp / 1e9:.3f} s", path, container=video) for stamp in video.stamps_ns]


def _read_index(camera: Path) -> list[Entry]:
    path = camera / INDEX
    entries: dict[int, Entry] = {}
    for number, line in read_rows(path):
        words = [word.strip() for word in line.split(",")]
        try:
            if len(words) != 2 or not words[1]:
                raise ValueError("not a row of timestamp [ns],filename")
            entry = _entry(camera, words[0], plain_name(words[1]))
            if entry.timestamp_ns in entries:
                raise ValueError(f"timestamp {words[0]} is given twice")
        except ValueError as error:
            raise InputError(f"{path}: line {number}: {error}") from error
        entries[entry.timestamp_ns] = entry
    return list(entries.values())


def _read_names(camera: Path) -> list[Entry]:
    entries: dict[int, Entry] = {}
    try:
        for name in sorted(os.listdir(camera / "data")):
            stem, ending = os.path.splitext(name)
            if ending != ".png" or not (stem.isascii() and stem.isdecimal()):
                continue
            entry = _entry(camera, stem, name)
            if entry.timestamp_ns in entries:
                raise ValueError(f"{entries[entry.timestamp_ns].path.name} and {name} have the same timestamp")
            if len(entries) == MOST_LINES:
                raise ValueError(f"more than {MOST_LINES} images")
            entries[entry.timestamp_ns] = entry
    except ValueError as error:
        raise InputError(f"{camera / 'data'}: {error}") from error
    except FileNotFoundError:
        return []
    except OSError as error:
        raise InputError(f"{camera / 'data'}: cannot be read: {error.strerror}") from error
    return list(entries.values())


def _entry(camera: Path, timestamp: str, filename: str) -> Entry:
    return Entry(parse_timestamp_ns(timestamp), f"{camera.name}/data/{filename}", camera / "data" / filename)
