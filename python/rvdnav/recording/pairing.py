"""Which images of two cameras belong together, by their stamps."""

from __future__ import annotations

import bisect

import attrs

from rvdnav.recording.entry import Entry


@attrs.frozen
class Moment:
    """The images of one frame, at least one of them."""

    timestamp_ns: int
    left: Entry | None
    right: Entry | None


def pair(left: list[Entry], right: list[Entry], tolerance_ns: int, notices: list[str]) -> list[Moment]:
    """Moments in time order: mutual nearest neighbours within the tolerance, and those that are left over."""
    left_stamps, right_stamps = ([entry.timestamp_ns for entry in entries] for entries in (left, right))
    pairs: dict[int, int] = {}
    for i, timestamp_ns in enumerate(left_stamps):
        j = _nearest(right_stamps, timestamp_ns)
        if abs(right_stamps[j] - timestamp_ns) <= tolerance_ns and _nearest(left_stamps, right_stamps[j]) == i:
            pairs[i] = j
    paired = set(pairs.values())
    alone = (
        [entry for i, entry in enumerate(left) if i not in pairs],
        [entry for j, entry in enumerate(right) if j not in paired],
    )
    for entry in alone[0] + alone[1]:
        notices.append(f"{entry.name} has no partner within {tolerance_ns / 1e6:g} ms: its frame has one image")
    moments = [Moment(left_stamps[i], left[i], right[j]) for i, j in pairs.items()] + single(*alone)
    return sorted(moments, key=lambda moment: moment.timestamp_ns)


def single(left: list[Entry], right: list[Entry]) -> list[Moment]:
    """Moments of images that have no partner."""
    return [Moment(entry.timestamp_ns, entry, None) for entry in left] + [
        Moment(entry.timestamp_ns, None, entry) for entry in right
    ]


def _nearest(stamps: list[int], timestamp_ns: int) -> int:
    """Index of the stamp nearest to a time, the earlier of two; stamps are sorted and at least one."""
    after = bisect.bisect_left(stamps, timestamp_ns)
    near = [i for i in (after - 1, after) if 0 <= i < len(stamps)]
    return min(near, key=lambda i: abs(stamps[i] - timestamp_ns))
