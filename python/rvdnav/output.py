"""The files of a run, written all or not at all, and read back."""

from __future__ import annotations

import json
import os
import shutil
import signal
import tempfile
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from rvdnav.errors import InputError
from rvdnav.files import read_lines
from rvdnav.jsonio import parse_object
from rvdnav.sequence import CAMERAS, read_tum, write_tum
from rvdnav.solution import Solution

POSES = "poses.tum"
SOLUTIONS = "solutions.jsonl"
SMOOTHED = "smoothed.tum"


@contextmanager
def staged_directory(directory: Path) -> Iterator[Path]:
    """Give a temporary folder whose files and folders are moved into ``directory`` when the block ends well.

    A camera's folder takes none.  After an exception or an interrupt the folder is gone and ``directory`` is as it was.
    It lies on the same file system, so that each move is atomic.  Raises InputError when ``directory`` cannot be
    written.
    """
    for place in (directory.resolve(), *directory.resolve().parents):
        if place.name in CAMERAS and place.is_dir():
            raise InputError(f"{directory}: lies in {place.name}, a camera's folder; results belong elsewhere")
    ancestor = directory
    while not ancestor.exists() and ancestor != ancestor.parent:
        ancestor = ancestor.parent
    if not ancestor.is_dir():
        raise InputError(f"{ancestor}: not a folder")
    try:
        staging = Path(tempfile.mkdtemp(prefix=".rvdnav-", dir=ancestor))
    except OSError as error:
        raise InputError(f"{directory}: cannot be written: {error.strerror}") from error
    try:
        yield staging
        with _interrupts_wait():
            _publish(staging, directory)
    except OSError as error:  # the disk is full, a name is taken by a folder, ...
        raise InputError(f"{directory}: cannot be written: {error.strerror}") from error
    finally:
        with _interrupts_wait():
            shutil.rmtree(staging, ignore_errors=True)


@contextmanager
def _interrupts_wait() -> Iterator[None]:
    """Let SIGINT and SIGTERM have their effect at the end of the block, so that it is done whole or not at all."""
    came: list[int] = []
    previous = {}
    if threading.current_thread() is threading.main_thread():  # no other heeds them
        for number in (signal.SIGINT, signal.SIGTERM):
            if signal.getsignal(number) is not None:  # else it was not set by Python, which could not set it again
                previous[number] = signal.signal(number, lambda number, _: came.append(number))
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
        if came:
            signal.raise_signal(came[0])


@contextmanager
def staged_report(directory: Path, name: str) -> Iterator[Path]:
    """Give a path to write a report to, which comes after the results: where it fails, they are there without it.

    Raises InputError that says so when the report cannot be written.
    """
    try:
        (directory / name).unlink(missing_ok=True)  # an older one does not belong to these results
        with staged_directory(directory) as staging:
            yield staging / name
    except (InputError, OSError) as error:
        raise InputError(f"{directory / name}: cannot be written, the results are there without it: {error}") from error


def _publish(staging: Path, directory: Path) -> None:
    directory.mkdir(parents=True, exist_ok=True)
    for file in sorted(staging.iterdir()):
        destination = directory / file.name
        if file.is_dir() and destination.is_dir():  # only an empty folder would make way
            os.replace(destination, staging / f".old-{file.name}")
        os.replace(file, destination)


def write_solutions(folder: Path, solutions: Iterable[Solution]) -> None:
    """Write ``poses.tum`` (published frames alone) and ``solutions.jsonl`` (one object a frame)."""
    published = []
    with (folder / SOLUTIONS).open("w", encoding="utf-8") as file:
        for solution in solutions:
            file.write(json.dumps(solution.to_json(), allow_nan=False) + "\n")
            if solution.T_world_target is not None:
                published.append((solution.timestamp_ns, solution.T_world_target))
    write_tum(folder / POSES, published)


def write_smoothed(folder: Path, solutions: Iterable[Solution]) -> None:
    """Write ``smoothed.tum``: the filtered poses of the published frames."""
    smoothed = [(s.timestamp_ns, s.smoothed_T_world_target) for s in solutions if s.published]
    write_tum(folder / SMOOTHED, [(stamp, pose) for stamp, pose in smoothed if pose is not None])


def read_solutions(folder: Path) -> tuple[Solution, ...]:
    """Read a run back and check that both of its files say the same.

    Raises InputError naming the file when one is missing or damaged, or when they disagree.
    """
    path = folder / SOLUTIONS
    solutions = tuple(_parse(path, number, line) for number, line in read_lines(path))
    if not solutions:
        raise InputError(f"{path}: holds no frames")
    _check_poses(folder / POSES, solutions)
    return solutions


def _parse(path: Path, number: int, line: str) -> Solution:
    try:
        return Solution.from_json(parse_object(line))
    except (InputError, ValueError) as error:
        raise InputError(f"{path}: line {number}: {error}") from error


def _check_poses(path: Path, solutions: Sequence[Solution]) -> None:
    poses = read_tum(path)
    published = [(s.timestamp_ns, s.T_world_target) for s in solutions if s.T_world_target is not None]
    if [timestamp_ns for timestamp_ns, _ in published] != poses.timestamps_ns.tolist():
        raise InputError(f"{path}: its frames are not those published in {SOLUTIONS}")
    for (timestamp_ns, T_world_target), pose in zip(published, poses.T_world_target, strict=True):
        if not np.allclose(T_world_target, pose, rtol=0, atol=1e-6):  # 9 decimals are written
            raise InputError(f"{path}: the pose at {timestamp_ns} ns is not the one in {SOLUTIONS}")
