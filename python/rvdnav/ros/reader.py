"""The program that reads a bag for `rvdnav.ros.bag`, in a process of its own.

    python -m rvdnav.ros.reader BAG

It speaks lines of JSON.  First it writes {"topics": {name: type}}.  Then it reads {"images": [topic, …], "infos":
[topic or null, …]} and writes an object a message, in the bag's order: {"image": n of the topic, "stamp", "logged",
"width", "height", "encoding", "fault"}, {"info": n, "camera"} for the first one and for one that differs from it,
{"transform": [parent, child, xyz, quaternion xyzw]}, and {} after the last.  Then it answers each {"image": n,
"number": of its messages, 0 the first} by {"size", "step", "big_endian"} and as many bytes of the image.  Whenever
something fails it writes {"fault"} in place of the rest.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from rvdnav.child_process import limit_resources
from rvdnav.errors import one_line
from rvdnav.files import MOST_LINES
from rvdnav.image_header import ImageError, parse_header
from rvdnav.ros.topics import IMAGE, TRANSFORMS

_STATIC = "/tf_static"
_MOST_TRANSFORMS = 10_000
_NANOSECONDS = 1_000_000_000


class _Images:
    """The messages of one topic; they are best asked for in their order."""

    def __init__(self, bag: _Bag, topic: str) -> None:
        self._bag = bag
        self._topic = topic
        self._keys: list[tuple[int, int]] = []
        self._next = -1
        self._messages: Iterator[tuple[tuple[int, int], Any]] = iter(())

    def note(self, key: tuple[int, int]) -> None:
        """The next message in the bag's order, by its stamp and the time when it was logged, ns."""
        self._keys.append(key)
        if len(self._keys) > MOST_LINES:
            raise ValueError(f"{self._topic} has more than {MOST_LINES} messages")

    def message(self, number: int) -> Any:
        key = self._keys[number]
        if number != self._next:
            self._messages = self._bag.keyed(self._topic, key[1])
        self._next = number + 1
        return next(message for found, message in self._messages if found == key)


class _Bag:
    def __init__(self, reader: Reader) -> None:
        self._reader = reader
        self._types = get_typestore(Stores.ROS2_HUMBLE)  # not the bag's own definitions, of which code would be made
        self.topics = {c.topic: c.msgtype for c in reader.connections}

    def messages(self, topics: list[str], start: int | None = None) -> Iterator[tuple[str, int, Any]]:
        """Topic, time of logging, ns, and contents of every message of these, logged from `start` on."""
        wanted = [connection for connection in self._reader.connections if connection.topic in topics]
        if not wanted:  # or all would come
            return
        for connection, logged, data in self._reader.messages(wanted, start=start):
            yield connection.topic, logged, self._types.deserialize_cdr(data, connection.msgtype)

    def keyed(self, topic: str, start: int) -> Iterator[tuple[tuple[int, int], Any]]:
        return (((_stamp(message), logged), message) for _, logged, message in self.messages([topic], start))


def _main(path: Path, requests: BinaryIO, answers: BinaryIO) -> None:
    limit_resources()

    def answer(record: dict[str, Any], data: bytes = b"") -> None:
        answers.write(json.dumps(record).encode() + b"\n" + data)
        answers.flush()

    # Whatever is wrong with a bag, in whatever layer it shows: the one place where it is caught.
    try:
        with Reader(path) as reader:
            bag = _Bag(reader)
            answer({"topics": bag.topics})
            wanted = json.loads(requests.readline() or b"null")
            if wanted is None:
                return
            sides = [_Images(bag, topic) for topic in wanted["images"]]
            for record in _listed(bag, wanted["images"], wanted["infos"], sides):
                answer(record)
            answer({})
            while line := requests.readline():
                asked = json.loads(line)
                answer(*_pixels(sides[asked["image"]].message(asked["number"])))
    except MemoryError:
        answer({"fault": "a part of it is too large"})
    except Exception as error:
        answer({"fault": one_line(f"{type(error).__name__}: {error}")})


def _listed(bag: _Bag, images: list[str], infos: list[str | None], sides: list[_Images]) -> Iterator[dict[str, Any]]:
    first: dict[str, str] = {}
    transforms = 0
    static = [_STATIC] if bag.topics.get(_STATIC) == TRANSFORMS else []
    for topic, logged, message in bag.messages([*images, *filter(None, infos), *static]):
        if topic in images:
            number = images.index(topic)
            sides[number].note((_stamp(message), logged))
            yield {"image": number, "stamp": _stamp(message), "logged": logged, **_format(message)}
        elif topic == _STATIC:
            for transform in message.transforms:
                transforms += 1
                if transforms > _MOST_TRANSFORMS:
                    raise ValueError(f"{_STATIC} has more than {_MOST_TRANSFORMS} transforms")
                yield {"transform": _transform(transform)}
        else:
            camera = _camera(message)
            text = json.dumps(camera)  # in which NaN is like NaN
            if topic not in first or first[topic] != text:
                first.setdefault(topic, text)
                yield {"info": infos.index(topic), "camera": camera}


def _stamp(message: Any) -> int:
    stamp = message.header.stamp
    if stamp.sec < 0 or stamp.nanosec >= _NANOSECONDS:
        raise ValueError(f"a stamp of {stamp.sec} s and {stamp.nanosec} ns")
    return int(stamp.sec) * _NANOSECONDS + int(stamp.nanosec)


def _format(message: Any) -> dict[str, Any]:
    if message.__msgtype__ == IMAGE:
        return {"width": message.width, "height": message.height, "encoding": message.encoding}
    try:
        header = parse_header(message.data.tobytes())
    except ImageError as error:
        return {"width": 0, "height": 0, "encoding": None, "fault": str(error)}
    return {"width": header.width, "height": header.height, "encoding": None}


def _camera(message: Any) -> dict[str, Any]:
    roi = message.roi
    return {
        "frame": message.header.frame_id,
        "size": [message.width, message.height],
        "model": message.distortion_model,
        **{name: getattr(message, name).tolist() for name in "dkrp"},
        "binning": [message.binning_x, message.binning_y],
        "region": [roi.x_offset, roi.y_offset, roi.width, roi.height],
    }


def _transform(stamped: Any) -> list[Any]:
    shift, turn = stamped.transform.translation, stamped.transform.rotation
    names = [stamped.header.frame_id.lstrip("/"), stamped.child_frame_id.lstrip("/")]
    return [*names, [shift.x, shift.y, shift.z], [turn.x, turn.y, turn.z, turn.w]]


def _pixels(message: Any) -> tuple[dict[str, Any], bytes]:
    data = message.data.tobytes()
    raw = message.__msgtype__ == IMAGE
    step, big_endian = (message.step, bool(message.is_bigendian)) if raw else (0, False)
    return {"size": len(data), "step": step, "big_endian": big_endian}, data


if __name__ == "__main__":
    _main(Path(sys.argv[1]), sys.stdin.buffer, sys.stdout.buffer)
