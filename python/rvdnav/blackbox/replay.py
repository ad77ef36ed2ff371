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
from rvdnav.errors import InputError
from rvdnav.files import read_text
from rvdnav.navigator import Navigator
from rvdnav.navigator.memory import Memory
from rvdnav.output import SOLUTIONS
from rvdnav.rig import Rig
from rvdnav.target import Target

_WALL_TIMES = "stage_times_s"


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
    data = _parsed(path, read_text(path))
    check_versions(path, data.get("versions"))
    check_digests(folder)
    origin, memory = _restored(path, data)
    rows = read_frames(folder)
    lines = read_text(folder / SOLUTIONS).splitlines()
    if len(lines) != len(rows):
        raise InputError(f"{folder / SOLUTIONS}: holds {len(lines)} solutions for {len(rows)} frames")
    navigator = Navigator(origin.rig, origin.target, **origin.options)
    navigator.memory = memory
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
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not JSON: {error}") from error
    if not isinstance(data, dict):
        raise InputError(f"{path}: not an object")
    return data


def _restored(path: Path, data: dict[str, Any]) -> tuple[Origin, Memory]:
    values = {}
    for name, kind in (("rig", Rig), ("target", Target), ("options", dict), ("memory", Memory)):
        try:
            values[name] = exact.from_json(data[name])
        except (KeyError, ValueError) as error:
            raise InputError(f"{path}: {name}: {error}") from error
        if not isinstance(values[name], kind):
            raise InputError(f"{path}: {name} is none")
    return Origin(values["rig"], values["target"], values["options"]), values["memory"]


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
