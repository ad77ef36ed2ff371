"""Faults of the delivery: which images arrive, when, and under which camera's name.  No pixel is changed."""

from __future__ import annotations

from collections.abc import Callable

import attrs

LEFT, RIGHT = 0, 1


@attrs.frozen
class Source:
    """Where pixels come from: the recorded frame's number and the camera, 0 left and 1 right."""

    frame: int
    camera: int


@attrs.frozen
class Delivery:
    """A frame as it arrives: the number of the recorded frame whose stamps it bears, and what it shows."""

    index: int
    left: Source
    right: Source


Strikes = Callable[[int], bool]
"""Whether a fault is active at a frame number."""


def as_recorded(frames: int) -> list[Delivery]:
    """Every frame once, in time order."""
    return [Delivery(index, Source(index, LEFT), Source(index, RIGHT)) for index in range(frames)]


def dropped(deliveries: list[Delivery], strikes: Strikes) -> list[Delivery]:
    """The frames never arrive."""
    return [delivery for delivery in deliveries if not strikes(delivery.index)]


def duplicated(deliveries: list[Delivery], strikes: Strikes) -> list[Delivery]:
    """The images that arrived last arrive again under the new stamp; the first frame has none before it and stays."""
    result: list[Delivery] = []
    for delivery in deliveries:
        if result and strikes(delivery.index):
            delivery = attrs.evolve(delivery, left=result[-1].left, right=result[-1].right)
        result.append(delivery)
    return result


def late(deliveries: list[Delivery], strikes: Strikes) -> list[Delivery]:
    """The frames arrive, with their own stamps, after the next frame that is on time."""
    result: list[Delivery] = []
    held: list[Delivery] = []
    for delivery in deliveries:
        if strikes(delivery.index):
            held.append(delivery)
            continue
        result += [delivery, *held]
        held = []
    return result + held


def left_behind(deliveries: list[Delivery], strikes: Strikes) -> list[Delivery]:
    """The left camera shows the moment of the frame before, under the new stamp; the first frame stays."""
    return [
        attrs.evolve(now, left=before.left) if strikes(now.index) else now
        for before, now in zip(deliveries[:1] + deliveries, deliveries, strict=False)
    ]


def right_behind(deliveries: list[Delivery], strikes: Strikes) -> list[Delivery]:
    """The right camera shows the moment of the frame before, under the new stamp; the first frame stays."""
    return [
        attrs.evolve(now, right=before.right) if strikes(now.index) else now
        for before, now in zip(deliveries[:1] + deliveries, deliveries, strict=False)
    ]


def swapped(deliveries: list[Delivery], strikes: Strikes) -> list[Delivery]:
    """The left camera's image arrives as the right one's and the other way round."""
    return [attrs.evolve(d, left=d.right, right=d.left) if strikes(d.index) else d for d in deliveries]
