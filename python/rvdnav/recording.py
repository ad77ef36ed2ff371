"""What a sequence folder records: the images that each camera lists, their sizes, and which belong together."""

from __future__ import annotations

import bisect
import os
from pathlib import Path

import attrs

from rvdnav.conventions import NANOSECONDS, parse_timestamp_ns, timestamp_unit
from rvdnav.errors import InputError
from rvdnav.files import MOST_LINES, plain_name, read_rows
from rvdnav.images import ImageError, Raster, image_size, read_image
from rvdnav.rig import Rig
from rvdnav.video import FORMATS, Video, open_video


@attrs.frozen
class Entry:
    """An image that the record lists, its name for the user, its file or the video that it is a frame of, and whether
    the file begins like an image."""

    timestamp_ns: int
    name: str
    path: Path
    readable: bool = True
    video: Video | None = None

    def size(self) -> tuple[int, int]:
        """Width and height, px, as the file says.  Raises ImageError when it doesn't."""
        return image_size(self.path) if self.video is None else (self.video.width, self.video.height)

    def read(self) -> Raster:
        """The image.  Raises ImageError when there is none."""
        return read_image(self.path) if self.video is None else Raster(self.video.frame(self.timestamp_ns))


@attrs.frozen
class Moment:
    """The images of one frame, at least one of them."""

    timestamp_ns: int
    left: Entry | None
    right: Entry | None


def list_images(camera: Path, notices: list[str]) -> list[Entry]:
    """What one camera recorded, in time order: in its folder, or in a video beside it of its name; nothing when neither
    is there.

    A unit of its stamps other than nanoseconds (see `timestamp_unit`) is told to `notices`.
    """
    videos = [camera.with_suffix(suffix) for suffix in FORMATS if camera.with_suffix(suffix).exists()]
    if len(videos) > 1 or (videos and camera.is_dir()):
        other = camera if camera.is_dir() else videos[1]
        raise InputError(f"{videos[0]}: there is {other.name} too, and either may be this camera's")
    if videos:
        return _video_frames(videos[0])
    if not camera.is_dir():
        return []
    entries = _read_index(camera) if os.path.lexists(camera / "data.csv") else _read_names(camera)
    if not entries:
        raise InputError(f"{camera}: holds no images: no row in data.csv, or no data/<timestamp in ns>.png without it")
    entries = sorted(entries, key=lambda entry: entry.timestamp_ns)
    try:
        unit = timestamp_unit([entry.timestamp_ns for entry in entries])
    except ValueError as error:
        raise InputError(f"{camera}: {error}") from error
    if unit is NANOSECONDS:
        return entries
    notices.append(f"{camera.name}: the timestamps are taken for {unit.name} of Unix time")
    return [attrs.evolve(entry, timestamp_ns=entry.timestamp_ns * unit.ns) for entry in entries]


def _video_frames(path: Path) -> list[Entry]:
    video = open_video(path)
    return [Entry(stamp, f"{path.name} at {stamp / 1e9:.3f} s", path, video=video) for stamp in video.stamps_ns]


def _read_index(camera: Path) -> list[Entry]:
    path = camera / "data.csv"
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


def check_images(entries: list[Entry], rig: Rig, notices: list[str]) -> list[Entry]:
    """The entries, marked where the file is no image; raises InputError naming an image of the wrong size."""
    checked = []
    for entry in entries:
        try:
            size = entry.size()
        except ImageError as error:
            notices.append(missing(entry, error))
            checked.append(attrs.evolve(entry, readable=False))
            continue
        if size != (rig.width, rig.height):
            raise InputError(
                f"{entry.path}: is {size[0]}x{size[1]} but the calibration is for {rig.width}x{rig.height}"
            )
        checked.append(entry)
    return checked


def missing(entry: Entry, error: ImageError) -> str:
    """The notice of an image that there is not."""
    return f"{entry.name} {error}: the frame goes on without it"


def pair(left: list[Entry], right: list[Entry], tolerance_ns: int, notices: list[str]) -> list[Moment]:
    """Moments in time order: mutual nearest neighbours within the tolerance, and those that are left over."""
    left_stamps, right_stamps = ([entry.timestamp_ns for entry in entries] for entries in (left, right))
    pairs: dict[int, int] = {}
    for i, timestamp_ns in enumerate(left_stamps):
        j = _nearest(right_stamps, timestamp_ns)
        if abs(right_stamps[j] - timestamp_ns) <= tolerance_ns and _nearest(left_stamps, right_stamps[j]) == i:
            pairs[i] = j
    paired = set(pairs.values())
    alone = (
        [entry for i, entry in enumerate(left) if i not in pairs],
        [entry for j, entry in enumerate(right) if j not in paired],
    )
    for entry in alone[0] + alone[1]:
        notices.append(f"{entry.name} has no partner within {tolerance_ns / 1e6:g} ms: its frame has one image")
    moments = [Moment(left_stamps[i], left[i], right[j]) for i, j in pairs.items()] + single(*alone)
    return sorted(moments, key=lambda moment: moment.timestamp_ns)


def single(left: list[Entry], right: list[Entry]) -> list[Moment]:
    """Moments of images that have no partner."""
    return [Moment(entry.timestamp_ns, entry, None) for entry in left] + [
        Moment(entry.timestamp_ns, None, entry) for entry in right
    ]


def _nearest(stamps: list[int], timestamp_ns: int) -> int:
    """Index of the stamp nearest to a time, the earlier of two; stamps are sorted and at least one."""
    after = bisect.bisect_left(stamps, timestamp_ns)
    near = [i for i in (after - 1, after) if 0 <= i < len(stamps)]
    return min(near, key=lambda i: abs(stamps[i] - timestamp_ns))
