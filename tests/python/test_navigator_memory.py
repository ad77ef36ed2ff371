"""A navigator's memory is all that it carries: handed on through text before every frame, nothing changes."""

from __future__ import annotations

import json
from collections.abc import Iterator

import pytest
from drawn_scene import START_NS, STEP_NS, Look, bracket_target, draw_images, example_rig, frame_of, pose
from drawn_solid import box_target, draw_solid, surfaces
from rvdnav import Frame, Navigator, Solution
from rvdnav.blackbox import exact
from rvdnav.solution import Reason, State

RIG = example_rig()
SMALL = bracket_target(0.09, 0.055, 0.07, 0.01)
BOX = box_target()


def undecided() -> Iterator[Frame]:
    """A small bracket in the left view alone, whose tilt only the nearer frames tell."""
    for number in range(8):
        T = pose(1.2 - 0.09 * number, 0.0, 0.05, 1.5, -12.0, 0.0)
        left, _ = draw_images(RIG, SMALL, T, seed=number, look=Look(clutter=False))
        yield frame_of((left, None), START_NS + number * STEP_NS)


def interrupted() -> Iterator[Frame]:
    """A box with a frame too late, one without images, one shown twice and, after a gap, one more."""
    first, second, third = (
        draw_solid(RIG, surfaces(BOX), pose(0.75 - 0.01 * number, 0.0, 0.04), timestamp_ns=0, seed=number)
        for number in range(3)
    )
    for number, frame in ((0, first), (2, second), (1, third), (3, None), (4, second), (5, third), (40, first)):
        images = (None, None) if frame is None else (frame.left.pixels, frame.right.pixels)
        yield frame_of(images, START_NS + number * STEP_NS)


def test_a_lost_initial_pose_is_forgotten() -> None:
    """After the loss everything goes on as if none had been given, the evidence between two poses included."""
    told, untold = Navigator(RIG, SMALL, initial_pose=pose(0.9, 0.1, 0.0)), Navigator(RIG, SMALL)
    for seconds in (-6, -3):
        frame = Frame(START_NS + seconds * 1_000_000_000, None, None)
        states = [navigator.process(frame).state for navigator in (told, untold)]
    assert states == [State.LOST, State.SEARCHING]
    for frame in undecided():
        first, second = told.process(frame), untold.process(frame)
        assert first == second
    assert first.published


def navigators() -> dict[str, Navigator]:
    return {"undecided": Navigator(RIG, SMALL), "interrupted": Navigator(RIG, BOX, initial_pose=pose(0.75, 0.0, 0.04))}


@pytest.mark.parametrize(("name", "frames"), [("undecided", undecided), ("interrupted", interrupted)])
def test_the_memory_alone_leads_to_the_same_bits(name: str, frames) -> None:
    navigator = navigators()[name]
    solutions: list[Solution] = []
    for frame in frames():
        another = navigators()[name]
        another.memory = exact.from_json(json.loads(json.dumps(exact.to_json(navigator.memory))))
        solutions.append(navigator.process(frame))
        assert another.process(frame) == solutions[-1]
    reasons = set().union(*(solution.reasons for solution in solutions))
    if name == "undecided":
        assert Reason.AMBIGUOUS in reasons
        assert solutions[-1].published
    else:
        assert {Reason.TIME_ORDER, Reason.LEFT_MISSING, Reason.DUPLICATE} <= reasons
        assert {State.TRACKING, State.COASTING} <= {solution.state for solution in solutions}
