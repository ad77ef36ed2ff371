"""A black box gone through again, every solution compared with the recorded one to the last bit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import attrs

from rvdnav.blackbox import exact
from rvdnav.blackbox.delivery import read_frames
from rvdnav.blackbox.digests import check_digests
from rvdnav.blackbox.folder import MEMORY, Origin
from rvdnav.blackbox.versions import check_versions, other_surroundings
from rvdnav.errors import CoreError, InputError
from rvdnav.files import read_lines, read_text
from rvdnav.jsonio import parse_object
from rvdnav.navigator import Navigator
from rvdnav.navigator.memory import Memory
from rvdnav.output import SOLUTIONS
from rvdnav.rig import Rig
from rvdnav.target import Target

_WALL_TIMES = "stage_times_s"
_LARGEST_MEMORY = 16 << 20


@attrs.frozen
class Difference:
    """Where a replay first gave something else: the frame's number, from 0, and stamp, and the solution's field."""

    index: int
    timestamp_ns: int
    field: str
    recorded: str
    replayed: str


@attrs.frozen
class Replay:
    """What came of a replay: the frames compared, the first difference or None, and what may account for it."""

    frames: int
    difference: Difference | None
    notes: tuple[str, ...] = ()


def replay(folder: str | Path) -> Replay:
    """Go through a black box again, up to the first difference.

    Everything but the wall times is compared.  Raises InputError naming the file when the folder is no black box, was
    recorded by another version, or is not as it was written.
    """
    folder = Path(folder)
    path = folder / MEMORY
    data = _parsed(path, read_text(path, _LARGEST_MEMORY))
    check_versions(path, data.get("versions"))
    check_digests(folder)
    origin, memory = _restored(path, data)
    rows = read_frames(folder)
    lines = [line for _, line in read_lines(folder / SOLUTIONS)]
    if len(lines) != len(rows):
        raise InputError(f"{folder / SOLUTIONS}: holds {len(lines)} solutions for {len(rows)} frames")
    navigator = _navigator(path, origin, memory)
    for index, (row, line) in enumerate(zip(rows, lines, strict=True)):
        recorded = _parsed(folder / SOLUTIONS, line)
        replayed = json.loads(json.dumps(navigator.process(row.read()).to_json()))
        for solution in (recorded, replayed):
            solution.pop(_WALL_TIMES, None)
        found = _first_difference(recorded, replayed)
        if found is not None:
            difference = Difference(index, row.timestamp_ns, *found)
            return Replay(index + 1, difference, tuple(other_surroundings(data["versions"])))
    return Replay(len(rows), None)


def _parsed(path: Path, text: str) -> dict[str, Any]:
    try:
        return parse_object(text)
    except ValueError as error:
        raise InputError(f"{path}: {error}") from error


def _restored(path: Path, data: dict[str, Any]) -> tuple[Origin, Memory]:
    values: dict[str, Any] = {}
    for name, kind in (("rig", Rig), ("target", Target), ("options", dict), ("memory", Memory)):
        try:
            values[name] = exact.restored(data[name], kind)
        except (KeyError, ValueError) as error:
            raise InputError(f"{path}: {name}: {error}") from error
    return Origin(values["rig"], values["target"], values["options"]), values["memory"]


def _navigator(path: Path, origin: Origin, memory: Memory) -> Navigator:
    """As it was when the record begins."""
    try:
        navigator = Navigator(origin.rig, origin.target, **origin.options)
    except (CoreError, InputError, OverflowError, TypeError, ValueError) as error:
        raise InputError(f"{path}: options: {error}") from error
    try:
        navigator.memory = memory
    except ValueError as error:
        raise InputError(f"{path}: memory: {error}") from error
    return navigator


def _first_difference(recorded: Any, replayed: Any, field: str = "") -> tuple[str, str, str] | None:
    """Where two JSON values differ first, and how; numbers are compared by their digits, so that -0.0 is not 0.0."""
    if isinstance(recorded, dict) and isinstance(replayed, dict):
        for key in {**recorded, **replayed}:
            name = f"{field}.{key}" if field else key
            found = _first_difference(recorded.get(key, "-"), replayed.get(key, "-"), name)
            if found is not None:
                return found
        return None
    if isinstance(recorded, list) and isinstance(replayed, list) and len(recorded) == len(replayed):
        for index, (a, b) in enumerate(zip(recorded, replayed, strict=True)):
            found = _first_difference(a, b, f"{field}[{index}]")
            if found is not None:
                return found
        return None
    texts = json.dumps(recorded), json.dumps(replayed)
    return None if texts[0] == texts[1] else (field, *texts)
