"""The images of two cameras in a ROS 2 bag.

The bag is read in a process of its own (`rvdnav.ros.reader`), its memory and the time of its answers bounded: a file
that crashes it is refused, or costs frames where it did so later.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from rvdnav.child_process import ChildError, ChildProcess
from rvdnav.errors import InputError
from rvdnav.extras import needs_extra
from rvdnav.files import reading
from rvdnav.images import ImageError, Raster, decode_image
from rvdnav.ros.encodings import ENCODINGS, decode_pixels
from rvdnav.ros.topics import choose_topics, info_topic

METADATA = "metadata.yaml"
FORMATS = (".mcap", ".db3")
"""Of a bag's files: MCAP and SQLite 3."""


@attrs.frozen(eq=False)
class Message:
    """An image message: its number in the topic, stamp, ns, size, px, encoding (None: a compressed one), and what is
    wrong with it already."""

    number: int
    stamp_ns: int
    width: int
    height: int
    encoding: str | None
    fault: str | None = None


@attrs.frozen(eq=False)
class Images:
    """The images of one topic, by their stamps, ns; they are best asked for in their order.

    camera_infos: the first message of the camera's calibration and those that differ from it, field by field.
    """

    topic: str
    messages: dict[int, Message] = attrs.field(repr=False)
    camera_infos: list[dict[str, Any]] = attrs.field(repr=False)
    _side: int
    _bag: Bag = attrs.field(repr=False)

    def size(self, timestamp_ns: int) -> tuple[int, int]:
        """Width and height, px.  Raises ImageError when the message holds no image."""
        message = self.messages[timestamp_ns]
        if message.fault is not None:
            raise ImageError(message.fault)
        return message.width, message.height

    def read(self, timestamp_ns: int) -> Raster:
        """The image.  Raises ImageError when there is none."""
        message = self.messages[timestamp_ns]
        pixels, data = self._bag.pixels(self._side, message.number)
        if message.encoding is None:
            return decode_image(data)
        return decode_pixels(data, message.encoding, (message.width, message.height), **pixels)


class Bag:
    """A bag that is open.

    left, right: the cameras' images; None where there is no topic of one.  transforms: what /tf_static says, each
    (frame, child, xyz, quaternion xyzw).
    """

    def __init__(self, path: Path, wanted: Sequence[str] | None, notices: list[str]) -> None:
        self._path = path
        self._reader = ChildProcess("rvdnav.ros.reader", str(path))
        self.transforms: list[tuple[str, str, list[float], list[float]]] = []
        topics = self._answer()["topics"]
        try:
            chosen = choose_topics(topics, wanted)
        except ValueError as error:
            raise InputError(f"{path}: {error}") from error
        named = [topic for topic in chosen if topic is not None]
        messages, infos = self._list(named, topics)
        sides = iter(range(len(named)))
        self.left, self.right = (
            None if topic is None else self._images(topic, messages, infos, next(sides), notices) for topic in chosen
        )

    def _list(
        self, named: list[str], topics: Mapping[str, str]
    ) -> tuple[list[list[dict[str, Any]]], list[list[dict[str, Any]]]]:
        """What the reader tells of the messages: for each of the topics its images and its camera's calibrations."""
        messages: list[list[dict[str, Any]]] = [[] for _ in named]
        infos: list[list[dict[str, Any]]] = [[] for _ in named]
        record = self._answer({"images": named, "infos": [info_topic(topics, topic) for topic in named]})
        while record:
            if "image" in record:
                messages[record["image"]].append(record)
            elif "info" in record:
                infos[record["info"]].append(record["camera"])
            else:
                frame, child, xyz, xyzw = record["transform"]
                self.transforms.append((frame, child, xyz, xyzw))
            record = self._answer()
        return messages, infos

    def _images(
        self,
        topic: str,
        messages: list[list[dict[str, Any]]],
        infos: list[list[dict[str, Any]]],
        side: int,
        notices: list[str],
    ) -> Images:
        records = messages[side]
        if not records:
            raise InputError(f"{self._path}: {topic} has no messages")
        for encoding in sorted({record["encoding"] for record in records} - {None, *ENCODINGS}):
            raise InputError(
                f"{self._path}: {topic} has images in {encoding!r}; what is read is {', '.join(ENCODINGS)}"
            )
        clock = "stamp"
        if not any(record["stamp"] for record in records):
            clock = "logged"
            notices.append(f"{topic}: the messages have no stamps, the times when they were logged are taken")
        found: dict[int, Message] = {}
        for number, record in enumerate(records):
            size = (record["width"], record["height"])
            message = Message(number, record[clock], *size, record["encoding"], record.get("fault"))
            if found.setdefault(message.stamp_ns, message) is not message:
                notices.append(f"{topic}: two messages have the stamp {message.stamp_ns} ns, the first is taken")
        return Images(topic, dict(sorted(found.items())), infos[side], side, self)

    def pixels(self, side: int, number: int) -> tuple[dict[str, Any], bytes]:
        """How the data of a message lie, and they.  Raises ImageError when it cannot be read any more."""
        try:
            self._ask({"image": side, "number": number})
            record = json.loads(self._reader.read_line())
            if "fault" in record:
                raise ImageError(f"cannot be read: {record['fault']}")
            return record, self._reader.read(record.pop("size"))
        except ChildError as error:
            raise ImageError(f"cannot be read: the reader {error}") from error

    def _ask(self, record: dict[str, Any]) -> None:
        self._reader.write(json.dumps(record).encode() + b"\n")

    def _answer(self, asked: dict[str, Any] | None = None) -> dict[str, Any]:
        try:
            if asked is not None:
                self._ask(asked)
            record: dict[str, Any] = json.loads(self._reader.read_line())
        except ChildError as error:
            raise InputError(f"{self._path}: cannot be read as a ROS 2 bag: the reader {error}") from error
        if "fault" in record and "image" not in record:
            raise InputError(f"{self._path}: cannot be read as a ROS 2 bag: {record['fault']}")
        return record


def is_bag(path: Path) -> bool:
    """Whether a path is that of a ROS 2 bag: a folder with its metadata.yaml, or an MCAP or SQLite 3 file."""
    return os.path.lexists(path / METADATA) or (not os.path.isdir(path) and path.suffix in FORMATS)


def open_bag(path: Path, topics: Sequence[str] | None, notices: list[str]) -> Bag:
    """Open a ROS 2 bag and go through it once.

    topics: of the images, the left one first; without them they are found (`choose_topics`).  What a user should know
    is told to `notices`.  Raises InputError naming the bag when it is missing or malformed, or has no such images.
    """
    with needs_extra("ros", str(path)):
        import rosbags.rosbag2  # noqa: F401 - only whether it is there; the reader's process uses it
    if any(path.glob("*.zstd")):
        raise InputError(f"{path}: its files are compressed as a whole; unpack them by unzstd and ros2 bag reindex")
    files = [path / METADATA, *sorted(path.glob("*"))] if os.path.isdir(path) else [path]
    for file in files:
        if file == files[0] or file.suffix in FORMATS:
            with reading(file):  # a plain file
                pass
    return Bag(path, topics, notices)
