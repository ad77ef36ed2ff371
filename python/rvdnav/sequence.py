"""Stereo image sequences: the folder of a recording, its frames in time order, and what was odd about it."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from pathlib import Path

import attrs

from rvdnav.errors import InputError
from rvdnav.images import Image, ImageError
from rvdnav.recording import Entry, Moment, Recording, check_images, missing, pair, read_recording, single
from rvdnav.rig import CAMCHAIN, RIG, Rig, load_rig, place_rig
from rvdnav.target import Target, load_target
from rvdnav.trajectory import Truth, read_tum, write_tum

__all__ = ["Frame", "Image", "Sequence", "Truth", "open_sequence", "read_tum", "write_tum"]

CAMERAS = ("cam0", "cam1")
"""Folders of the left and of the right camera."""
TARGET = "target.yaml"
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


def open_sequence(
    path: str | Path,
    *,
    pairing_tolerance_ns: int = PAIRING_TOLERANCE_NS,
    rate_hz: float | None = None,
    topics: Iterable[str] | None = None,
    rig: str | Path | None = None,
    target: str | Path | None = None,
) -> Sequence:
    """Open a recorded sequence: a folder in one of the layouts of docs/sequences.md, or a ROS 2 bag.

    A left and a right image are a pair when they are each other's nearest in time and within the tolerance, ns.
    rate_hz: the frame rate of pictures whose names count them, in place of times.  topics: of a bag's images, the left
    one first, where it is not clear.  rig, target: the rig's folder (or its `camchain.yaml`) and the target's file,
    where they are not `camchain.yaml` and `target.yaml` of the folder.

    Raises InputError naming the file when the folder is missing or empty, a file is malformed, or an image has not the
    size of the calibration.  An image that is missing, damaged or unpaired is no error but a notice.
    """
    notices: list[str] = []
    recording = read_recording(Path(path), rate_hz, None if topics is None else tuple(topics), notices)
    folder = recording.folder
    cameras = _load_rig(recording, None if rig is None else Path(rig), notices)
    known_target = load_target(folder / TARGET if target is None else Path(target))
    truth_path = folder / "groundtruth.tum"
    truth = read_tum(truth_path) if os.path.lexists(truth_path) else None
    left, right = (check_images(entries, cameras, notices) for entries in (recording.left, recording.right))
    if right and not cameras.is_stereo:
        raise InputError(f"{folder / 'camchain.yaml'}: cam1 is missing, but there are images of it")
    if not any(entry.readable for entry in left + right):
        raise InputError(f"{folder}: none of the images can be read: {notices[0]}")
    if left and right:
        moments = pair(left, right, pairing_tolerance_ns, notices)
    else:
        moments = single(left, right)
        if cameras.is_stereo:
            notices.append(f"there is no {CAMERAS[1] if left else CAMERAS[0]}: every frame has one image")
    return Sequence(Path(path), cameras, known_target, truth, moments, notices)


def _load_rig(recording: Recording, elsewhere: Path | None, notices: list[str]) -> Rig:
    if elsewhere is not None:
        if not os.path.isdir(elsewhere) and elsewhere.name not in (CAMCHAIN, RIG):
            raise InputError(f"{elsewhere}: neither a folder nor a {CAMCHAIN}")
        return load_rig(elsewhere if os.path.isdir(elsewhere) else elsewhere.parent, notices)
    if recording.chain is None or os.path.lexists(recording.folder / CAMCHAIN):
        return load_rig(recording.folder, notices)
    return place_rig(recording.chain(), recording.folder, notices)
