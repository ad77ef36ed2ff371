"""The folder of a black box: a sequence folder, with what else is needed to go through it again to the same bits."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import attrs

from rvdnav.blackbox import exact
from rvdnav.blackbox.delivery import FRAMES, frames_text
from rvdnav.blackbox.digests import write_digests
from rvdnav.blackbox.versions import versions
from rvdnav.errors import InputError
from rvdnav.images import Image, png_bytes
from rvdnav.navigator.memory import Memory
from rvdnav.output import staged_directory, write_solutions
from rvdnav.rig import Rig, save_rig
from rvdnav.sequence import CAMERAS, Frame
from rvdnav.solution import Solution
from rvdnav.target import Target
from rvdnav.target_writer import save_target

MEMORY = "memory.json"


@attrs.frozen(eq=False)
class Origin:
    """What a navigator was made of."""

    rig: Rig
    target: Target
    options: dict[str, Any]


@attrs.frozen(eq=False)
class Moment:
    """One frame as it was delivered, the navigator's memory before it, and what came of it."""

    memory: Memory
    frame: Frame
    solution: Solution


def write_black_box(folder: Path, origin: Origin, moments: Sequence[Moment]) -> None:
    """Write at least one moment, the oldest first, into a folder, which appears as a whole; an older black box goes.

    Raises InputError when it cannot be written, or when something other than a black box is there already.
    """
    folder = folder.resolve()
    if folder.exists() and not (folder / MEMORY).is_file():
        raise InputError(f"{folder}: is there already and no black box")
    with staged_directory(folder.parent) as staging:
        box = staging / folder.name
        box.mkdir()
        save_rig(origin.rig, box)
        save_target(origin.target, box / "target.yaml")
        (box / MEMORY).write_text(_memory_text(origin, moments[0].memory), encoding="utf-8")
        _write_frames(box, [moment.frame for moment in moments])
        write_solutions(box, [moment.solution for moment in moments])
        write_digests(box)


def _memory_text(origin: Origin, memory: Memory) -> str:
    data = {
        "versions": versions(),
        "options": exact.to_json(origin.options),
        "memory": exact.to_json(memory),
        "rig": exact.to_json(origin.rig),
        "target": exact.to_json(origin.target),
    }
    lines = [f"{json.dumps(key)}: {json.dumps(value, allow_nan=False)}" for key, value in data.items()]
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _write_frames(box: Path, frames: Sequence[Frame]) -> None:
    names: list[tuple[str | None, ...]] = [
        tuple(_write_images(box / camera, images))
        for camera, images in zip(CAMERAS, zip(*((f.left, f.right) for f in frames), strict=True), strict=True)
    ]
    text = frames_text(frames, zip(*names, strict=True))
    (box / FRAMES).write_text(text, encoding="utf-8")


def _write_images(camera: Path, images: Sequence[Image | None]) -> list[str | None]:
    """The file name of each image.  data.csv lists the first of each stamp, for a sequence has no two with the same."""
    names: list[str | None] = []
    listed: dict[int, str] = {}
    for image in images:
        if image is None:
            names.append(None)
            continue
        first = image.timestamp_ns not in listed
        name = f"{image.timestamp_ns}{'' if first else f'-{len(names)}'}.png"
        listed.setdefault(image.timestamp_ns, name)
        (camera / "data").mkdir(parents=True, exist_ok=True)
        (camera / "data" / name).write_bytes(png_bytes(image.pixels))
        names.append(name)
    if listed:
        rows = [f"{timestamp_ns},{name}" for timestamp_ns, name in sorted(listed.items())]
        (camera / "data.csv").write_text("\n".join(["#timestamp [ns],filename", *rows, ""]), encoding="utf-8")
    return names
