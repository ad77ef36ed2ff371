"""Which topics of a bag are the left and the right camera's, by their types and names."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

IMAGE = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"
CAMERA_INFO = "sensor_msgs/msg/CameraInfo"
TRANSFORMS = "tf2_msgs/msg/TFMessage"
_PREFERRED = ("image_raw", "image", "image_mono", "image_color", "image_rect", "image_rect_raw", "image_rect_color")
_DEPTH = "compressedDepth"


def choose_topics(topics: Mapping[str, str], wanted: Sequence[str] | None) -> tuple[str | None, str | None]:
    """The image topics of the left and the right camera among a bag's topics and their types; None where one has none.

    wanted: the left one and, if there are two cameras, the right one.  Without them two are a pair whose names differ
    by left and right, or by numbers that follow each other; of a camera's several topics raw pixels come before
    compressed ones, and images as they were taken before rectified ones.
    Raises ValueError where a wanted one is no image topic, or it is not clear which are meant.
    """
    images = sorted(name for name, kind in topics.items() if _is_image(name, kind))
    there = f"the bag's image topics are {', '.join(images)}" if images else "the bag has no image topics"
    if wanted is not None:
        if len(wanted) not in (1, 2) or len(set(wanted)) != len(wanted):
            raise ValueError("the topics of one camera or of two are named, the left one first")
        for name in wanted:
            if name not in images:
                raise ValueError(f"{name} is no image topic; {there}")
        return wanted[0], wanted[1] if len(wanted) == 2 else None
    pairs = [(left, right) for left in images for right in images if _is_pair(left, right)]
    if len({(namespace(left), namespace(right)) for left, right in pairs}) == 1:
        return min(pairs, key=lambda pair: _rank(pair[0]))
    if images and not pairs and len({namespace(name) for name in images}) == 1:
        only = min(images, key=_rank)
        return (None, only) if "right" in _words(only) else (only, None)
    raise ValueError(f"{there}; name the left and the right one" if images else there)


def namespace(topic: str) -> str:
    """What all topics of a camera begin with."""
    return topic.removesuffix("/compressed").rpartition("/")[0]


def info_topic(topics: Mapping[str, str], image: str | None) -> str | None:
    """The topic with the calibration of the camera of an image topic; None where there is none."""
    name = None if image is None else f"{namespace(image)}/camera_info"
    return name if name is not None and topics.get(name) == CAMERA_INFO else None


def is_rectified(image: str) -> bool:
    """Whether a topic has images without distortion, as image_proc names them."""
    return image.removesuffix("/compressed").rpartition("/")[2].startswith("image_rect")


def _is_image(name: str, kind: str) -> bool:
    return kind == IMAGE or (kind == COMPRESSED_IMAGE and not name.endswith(_DEPTH))


def _words(topic: str) -> list[str]:
    return re.findall("[a-z]+|[0-9]+|[^a-z0-9]+", topic.lower())


def _is_pair(left: str, right: str) -> bool:
    words = _words(left), _words(right)
    differing = [(a, b) for a, b in zip(*words, strict=False) if a != b]
    return len(words[0]) == len(words[1]) and bool(differing) and all(_follows(a, b) for a, b in differing)


def _follows(a: str, b: str) -> bool:
    return (a, b) == ("left", "right") or (a.isdecimal() and b.isdecimal() and int(a) + 1 == int(b))


def _rank(topic: str) -> tuple[bool, int, str]:
    name = topic.removesuffix("/compressed").rpartition("/")[2]
    place = _PREFERRED.index(name) if name in _PREFERRED else len(_PREFERRED)
    return is_rectified(topic), place, topic
