"""Poses over time, and the TUM files that hold them: `timestamp_s tx ty tz qx qy qz qw`, T_world_target."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rvdnav.conventions import format_timestamp_s, parse_timestamp_s
from rvdnav.errors import InputError
from rvdnav.files import read_rows, write_text_atomically
from rvdnav.pose.arrays import FloatArray, float_array
from rvdnav.pose.so3 import make_T, quaternion_xyzw, rotation_from_quaternion_xyzw

STAMP_TOLERANCE_NS = 1_000
"""Stamps this close are the same: other tools write microseconds or floats."""
_NORM_TOLERANCE = 1e-3


def _stamps(values: ArrayLike) -> NDArray[np.int64]:
    stamps: NDArray[np.int64] = np.array(values, dtype=np.int64)
    stamps.setflags(write=False)
    return stamps


def _poses(values: ArrayLike) -> FloatArray:
    poses: FloatArray = float_array(values, None, 4, 4).copy()
    poses.setflags(write=False)
    return poses


@attrs.frozen(eq=False)
class Truth:
    """The target's true poses: timestamps_ns (n,) int64, strictly increasing, and T_world_target (n, 4, 4), m.

    Raises ValueError when the lengths differ, the order is another, or a number is not finite.
    """

    timestamps_ns: NDArray[np.int64] = attrs.field(converter=_stamps)
    T_world_target: FloatArray = attrs.field(converter=_poses)

    def __attrs_post_init__(self) -> None:
        if self.timestamps_ns.shape != self.T_world_target.shape[:1]:
            raise ValueError(f"{self.timestamps_ns.shape} timestamps for {len(self.T_world_target)} poses")
        if (np.diff(self.timestamps_ns) <= 0).any():
            raise ValueError("the timestamps do not increase")

    def __len__(self) -> int:
        return len(self.timestamps_ns)

    def at(self, timestamp_ns: int) -> FloatArray | None:
        """T_world_target (4, 4) at a time, to within a microsecond; None where there is no such pose."""
        after = int(np.searchsorted(self.timestamps_ns, timestamp_ns))
        near = range(max(after - 1, 0), min(after + 1, len(self)))
        if not near:
            return None
        index = min(near, key=lambda i: abs(int(self.timestamps_ns[i]) - timestamp_ns))
        if abs(int(self.timestamps_ns[index]) - timestamp_ns) > STAMP_TOLERANCE_NS:
            return None
        pose: FloatArray = self.T_world_target[index]
        return pose

    def nearest_ns(self, timestamps_ns: Iterable[int]) -> int | None:
        """How far the nearest pose is from any of these times, ns; None without poses or times."""
        if not len(self):
            return None
        return min((int(np.abs(self.timestamps_ns - stamp).min()) for stamp in timestamps_ns), default=None)


def read_tum(path: str | Path) -> Truth:
    """The poses of a TUM file; none at all is no fault.

    Raises InputError naming the file and the line when it is missing or malformed: eight finite numbers a line, unit
    quaternions, timestamps that increase.
    """
    stamps: list[int] = []
    poses: list[FloatArray] = []
    for number, line in read_rows(Path(path)):
        try:
            timestamp_ns, pose = _parse_line(line.replace(",", " ").split())
            if stamps and timestamp_ns <= stamps[-1]:
                raise ValueError("the timestamps do not increase")
        except ValueError as error:
            raise InputError(f"{path}: line {number}: {error}") from error
        stamps.append(timestamp_ns)
        poses.append(pose)
    return Truth(stamps, np.array(poses).reshape(-1, 4, 4))


def _parse_line(words: list[str]) -> tuple[int, FloatArray]:
    if len(words) != 8:
        raise ValueError(f"{len(words)} values where timestamp tx ty tz qx qy qz qw are needed")
    timestamp_ns = parse_timestamp_s(words[0])
    values = float_array([float(word) for word in words[1:]], 7)
    norm = math.hypot(*values[3:])
    if abs(norm - 1.0) > _NORM_TOLERANCE:
        raise ValueError(f"the quaternion has length {norm:.4g}, not 1")
    return timestamp_ns, make_T(rotation_from_quaternion_xyzw(values[3:]), values[:3])


def write_tum(path: str | Path, poses: Iterable[tuple[int, FloatArray]]) -> None:
    """Write (timestamp_ns, T_world_target (4, 4)) as a TUM file with nine decimals, whole or not at all.

    Raises InputError naming the file when it cannot be written.
    """
    lines = ["# timestamp_s tx ty tz qx qy qz qw   (T_world_target: C in W, metres)"]
    for timestamp_ns, T in poses:
        values = [*T[:3, 3], *quaternion_xyzw(T[:3, :3])]
        lines.append(" ".join([format_timestamp_s(timestamp_ns), *(f"{value:.9f}" for value in values)]))
    write_text_atomically(Path(path), "\n".join([*lines, ""]))
