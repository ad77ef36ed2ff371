"""Stereo image sequences: the folder of a recording, its frames in time order, and what was odd about it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import attrs

from rvdnav.errors import InputError
from rvdnav.images import Image, ImageError
from rvdnav.recording import Entry, Moment, check_images, list_images, missing, pair, single
from rvdnav.rig import Rig, load_rig
from rvdnav.target import Target, load_target
from rvdnav.trajectory import Truth, read_tum, write_tum

__all__ = ["Frame", "Image", "Sequence", "Truth", "open_sequence", "read_tum", "write_tum"]

CAMERAS = ("cam0", "cam1")
"""Folders of the left and of the right camera."""
PAIRING_TOLERANCE_NS = 1_000_000


@attrs.frozen
class Frame:
    """The images of one moment; None where a camera has none.

    timestamp_ns: the left image's stamp, or the right one's where there is no left image in the record.
    """

    timestamp_ns: int
    left: Image | None
    right: Image | None


class Sequence:
    """A recorded sequence; iterating it gives its frames in time order, each read from disk when its turn comes.

    path: its folder.  rig, target: from its calibration and target files.  truth: the true poses, or None.
    """

    def __init__(
        self, path: Path, rig: Rig, target: Target, truth: Truth | None, moments: list[Moment], notices: list[str]
    ) -> None:
        self.path = path
        self.rig = rig
        self.target = target
        self.truth = truth
        self._moments = moments
        self._notices = dict.fromkeys(notices)
        self._told: set[str] = set()

    @property
    def notices(self) -> list[str]:
        """What a user should know, each thing once: images missing, damaged, unpaired or converted, so far."""
        return list(self._notices)

    @property
    def timestamps_ns(self) -> tuple[int, ...]:
        """Of every frame, without reading any."""
        return tuple(moment.timestamp_ns for moment in self._moments)

    def __len__(self) -> int:
        return len(self._moments)

    def __iter__(self) -> Iterator[Frame]:
        return (self[index] for index in range(len(self)))

    def __getitem__(self, index: int) -> Frame:
        """The frame at a position in time order.  Raises IndexError beyond the end."""
        moment = self._moments[index]
        return Frame(moment.timestamp_ns, self._read(moment.left), self._read(moment.right))

    def _read(self, entry: Entry | None) -> Image | None:
        if entry is None or not entry.readable:
            return None
        try:
            raster = entry.read()
        except ImageError as error:
            self._notices[missing(entry, error)] = None
            return None
        for told in (raster.conversion, raster.ignored_orientation):
            if told is not None and told not in self._told:
                self._told.add(told)
                self._notices[f"{told}, {entry.name} the first of them"] = None
        return Image(raster.grey8, entry.timestamp_ns)


def open_sequence(path: str | Path, *, pairing_tolerance_ns: int = PAIRING_TOLERANCE_NS) -> Sequence:
    """Open a sequence folder in the EuRoC/ASL layout.

    It holds `cam0/data/<ns>.png` and the same for cam1 (either camera may be absent), each with `data.csv` or else
    taken by file name, or videos in their place (`cam0.mp4`, see `video.FORMATS`), whose stamps count from their
    beginning; `camchain.yaml`, `rig.yaml` (optional), `target.yaml`, and `groundtruth.tum` (optional).  A left and a
    right image are a pair when they are each other's nearest in time and within the tolerance, ns.

    Raises InputError naming the file when the folder is missing or empty, a file is malformed, or an image has not the
    size of the calibration.  An image that is missing, damaged or unpaired is no error but a notice.
    """
    folder = Path(path)
    if not os.path.isdir(folder):
        raise InputError(f"{folder}: {'not a folder' if os.path.exists(folder) else 'no such folder'}")
    notices: list[str] = []
    recorded = [list_images(folder / name, notices) for name in CAMERAS]
    if not any(recorded):
        raise InputError(f"{folder}: not a sequence: holds neither cam0 nor cam1")
    rig = load_rig(folder, notices)
    target = load_target(folder / "target.yaml")
    truth_path = folder / "groundtruth.tum"
    truth = read_tum(truth_path) if os.path.lexists(truth_path) else None
    left, right = (check_images(entries, rig, notices) for entries in recorded)
    if right and not rig.is_stereo:
        raise InputError(f"{folder / 'camchain.yaml'}: cam1 is missing, but there are images of it")
    if not any(entry.readable for entry in left + right):
        raise InputError(f"{folder}: none of the images can be read: {notices[0]}")
    if left and right:
        moments = pair(left, right, pairing_tolerance_ns, notices)
    else:
        moments = single(left, right)
        if rig.is_stereo:
            notices.append(f"there is no {CAMERAS[1] if left else CAMERAS[0]}: every frame has one image")
    return Sequence(folder, rig, target, truth, moments, notices)
