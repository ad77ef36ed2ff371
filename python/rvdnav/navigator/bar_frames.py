"""Closed frames of four bars in one view, of any size: what a bracket of unknown dimensions looks like.

The inner outline is sought first: four segments that meet at their ends, with the same light side.  Its sides end at
its corners, which tells it from lines that cross.  Then, beside each, the outer side of the bar, with the opposite
light side; one of the four may be missing.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.navigator.view_segments import Segments
from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray

# Between the two sides of a bar, rad; their least distance, px; their least overlap as a multiple of the distance and
# as a part of the inner side.
_MAX_TAPER = 0.10
_MIN_WIDTH_PX = 2.0
_MIN_SLENDERNESS = 1.5
_MIN_OVERLAP = 0.35
_MIN_OUTER_SIDES = 3
_MAX_WAYS = 4
# Between adjoining sides, rad; between the widths of a frame's bars.
_MIN_CORNER = 0.35
_WIDTH_RATIO = 2.0
_MAX_NEIGHBOURS = 12
# Part of an inner side that its segment must cover.
_MIN_COVERAGE = 0.6
_MAX_FRAMES = 800


@attrs.frozen(eq=False)
class BarFrames:
    """Frames of four adjoining bars in one rectified view; arrays of one length n.

    rho, theta (n, 4, 2): lines of the frame's sides, px and rad, outer and inner ones.  middle, length (n, 4, 2): where
    along the line what is seen of it lies, and how long it is, px.  seen (n, 4, 2): whether the side is; the others are
    guessed from the inner side and the other bars' widths.  The sides run around the frame with its inside
    at (-dy, dx), from corner i to corner i + 1 of corners (n, 4, 2, 2), px.
    cut: there were more frames or segments than are looked at.
    """

    rho: FloatArray
    theta: FloatArray
    middle: FloatArray
    length: FloatArray
    seen: BoolArray
    corners: FloatArray
    cut: bool = False

    def __len__(self) -> int:
        return len(self.rho)


def find_bar_frames(records: NDArray[np.void]) -> BarFrames:
    """The frames among SEGMENT records, those with the best covered inner outline first."""
    segments = Segments.of(records).with_joined()
    loops, directions = _inner_outlines(segments)
    partners = _partners(segments)
    found: list[tuple[float, IntArray, FloatArray]] = []
    for loop, direction, coverage in zip(loops, directions, _coverages(segments, loops), strict=True):
        if coverage.min() < _MIN_COVERAGE:
            continue
        # Where the walk goes along the tangent (-sin, cos), its inside (-dy, dx) lies against the normal.
        options = [partners[int(i)][0 if d > 0 else 1] for i, d in zip(loop, direction, strict=True)]
        for outer, width in _outer_sides(options):
            found.append((float(coverage.sum()), np.stack([outer, loop]), width * direction))
    found.sort(key=lambda frame: -frame[0])
    best = found[:_MAX_FRAMES]
    if not best:
        none = np.zeros((0, 4, 2))
        return BarFrames(none, none, none, none, none > 0.0, np.zeros((0, 4, 2, 2)))
    return _frames(
        segments,
        np.array([sides for _, sides, _ in best]),
        np.array([shift for *_, shift in best]),
        len(found) > len(best),
    )


def _inner_outlines(segments: Segments) -> tuple[IntArray, IntArray]:
    """Loops (n, 4) of segments that meet end to end, with the inside at (-dy, dx) and the same light side, and whether
    each is walked along its tangent, +1, or against it, -1 (n, 4)."""
    neighbours = _neighbours(segments)
    loops = set()
    # A step walks along a segment to its other end and on to a neighbour's end.
    for start in range(len(segments.rho)):
        halfway: dict[tuple[int, int], list[int]] = {}
        for second, end in neighbours[start][1]:
            for third, third_end in neighbours[second][1 - end]:
                halfway.setdefault((third, third_end), []).append(second)
        for fourth, end in neighbours[start][0]:
            for third, third_end in neighbours[fourth][1 - end]:
                for second in halfway.get((third, 1 - third_end), ()):
                    loop = (start, second, third, fourth)
                    if start == min(loop) and len(set(loop)) == 4:
                        loops.add(loop)
    found = np.array(sorted(loops), np.int64).reshape(-1, 4)
    corners = _meet(segments.rho[found], segments.theta[found])
    backwards = _area(corners) < 0.0
    found[backwards] = found[backwards, ::-1]
    corners = _meet(segments.rho[found], segments.theta[found])
    walk = np.roll(corners, -1, axis=1) - corners
    direction = np.sign(np.einsum("nsi,nsi->ns", walk, segments.tangent[found])).astype(np.int64)
    inside_light = -direction * segments.polarity[found]
    sound = _convex(corners) & (np.abs(inside_light.sum(axis=1)) == 4)
    return found[sound], direction[sound]


def _neighbours(segments: Segments) -> list[list[list[tuple[int, int]]]]:
    """Of each segment and end (0 the lower, 1 the upper): the segments whose end meets it, and which of their ends."""
    sine = np.sin(segments.theta[None, :] - segments.theta[:, None])
    cosine = np.cos(segments.theta[None, :] - segments.theta[:, None])
    with np.errstate(divide="ignore", invalid="ignore"):
        place = (segments.rho[None, :] - segments.rho[:, None] * cosine) / sine  # of k's line, along i
    reach = 5.0 + 0.15 * segments.length
    misses = np.abs(place[:, :, None] - segments.ends[:, None, :]) / reach[:, None, None]
    end, miss = np.argmin(misses, axis=2), misses.min(axis=2)
    meets = (np.abs(sine) > np.sin(_MIN_CORNER)) & (miss < 1.0) & (miss.T < 1.0)
    both = np.where(meets, miss + miss.T, np.inf)
    found = []
    for i, order in enumerate(np.argsort(both, axis=1, kind="stable")):
        others: list[list[tuple[int, int]]] = [[], []]
        for k in order[: np.count_nonzero(meets[i])]:
            at = others[int(end[i, k])]
            if len(at) < _MAX_NEIGHBOURS:
                at.append((int(k), int(end[k, i])))
        found.append(others)
    return found


def _coverages(segments: Segments, loops: IntArray) -> FloatArray:
    """Part (n, 4) of each side of the outlines that its segment covers."""
    corners = _meet(segments.rho[loops], segments.theta[loops])
    low, high = _extent(segments.tangent[loops], corners)
    ends = segments.ends[loops]
    covered: FloatArray = (np.minimum(ends[..., 1], high) - np.maximum(ends[..., 0], low)) / np.maximum(
        high - low, 1e-9
    )
    return covered


Option = tuple[float, int, float]
"""The other side of a bar: its distance, px, its segment, and how much of the first side it runs beside, px."""


def _partners(segments: Segments) -> list[tuple[list[Option], list[Option]]]:
    """Of each segment, the other sides of the bars of which it may be one: those at growing rho, and those opposite."""
    sign, sine, along, across = segments.aligned()
    own = segments.length
    low, high = segments.ends.T
    overlap = np.minimum(high[:, None], along[..., 1]) - np.maximum(low[:, None], along[..., 0])
    width = np.abs(across)
    fits = (np.abs(sine) < _MAX_TAPER) & (width > _MIN_WIDTH_PX) & (overlap > _MIN_OVERLAP * own[:, None])
    fits &= (overlap > _MIN_SLENDERNESS * width) & (sign * segments.polarity[:, None] * segments.polarity < 0)
    found = []
    for i in range(len(own)):
        sides: tuple[list[Option], list[Option]] = ([], [])
        for j in np.flatnonzero(fits[i]):
            sides[0 if across[i, j] > 0.0 else 1].append((float(width[i, j]), int(j), float(overlap[i, j])))
        found.append(sides)
    return found


def _outer_sides(options: list[list[Option]]) -> list[tuple[IntArray, FloatArray]]:
    """Ways to choose four outer sides alike in width, those that run longest beside the inner ones first: segments
    (4,), -1 where there is none, and widths (4,), px."""
    ways: dict[tuple[int, ...], tuple[float, FloatArray]] = {}
    for reference in {width for side in options for width, *_ in side}:
        sides, widths, beside = [], [], 0.0
        for side in options:
            nearest = min(side, key=lambda option: abs(np.log(option[0] / reference)), default=(np.inf, -1, 0.0))
            alike = 1.0 / _WIDTH_RATIO < nearest[0] / reference < _WIDTH_RATIO
            sides.append(nearest[1] if alike else -1)
            widths.append(nearest[0] if alike else np.nan)
            beside += nearest[2] if alike else 0.0
        if sum(j >= 0 for j in sides) >= _MIN_OUTER_SIDES:
            ways[tuple(sides)] = beside, np.array(widths)
    longest = sorted(ways.items(), key=lambda way: (-way[1][0], way[0]))[:_MAX_WAYS]
    return [
        (np.array(sides, np.int64), np.where(np.array(sides) < 0, np.nanmean(widths), widths))
        for sides, (_, widths) in longest
    ]


def _frames(segments: Segments, sides: IntArray, shift: FloatArray, cut: bool) -> BarFrames:
    """sides (n, 2, 4): outer and inner segments; shift (n, 4): of the outer side along the inner one's normal, px."""
    rho, theta = (values[sides] for values in (segments.rho, segments.theta))
    missing = sides[:, 0] < 0
    rho[:, 0][missing] = rho[:, 1][missing] + shift[missing]
    theta[:, 0][missing] = theta[:, 1][missing]
    corners = np.stack([_meet(rho[:, k], theta[:, k]) for k in (0, 1)], axis=2)
    ends = segments.ends[sides]
    ends[:, 0][missing] = ends[:, 1][missing]
    whole = _convex(corners[:, :, 0])
    parts = (rho, theta, ends.mean(axis=3), np.ptp(ends, axis=3))
    rho, theta, middle, length = (np.swapaxes(part, 1, 2)[whole] for part in parts)
    seen = np.swapaxes(sides >= 0, 1, 2)[whole]
    return BarFrames(rho, theta, middle, length, seen, corners[whole], cut)


def _meet(rho: FloatArray, theta: FloatArray) -> FloatArray:
    """Corners (n, 4, 2) of outlines of lines (n, 4): corner i is where sides i - 1 and i meet."""
    other_rho, other_theta = np.roll(rho, 1, axis=1), np.roll(theta, 1, axis=1)
    sine = np.sin(other_theta - theta)
    sine = np.where(np.abs(sine) < 1e-9, 1e-9, sine)
    x = (rho * np.sin(other_theta) - other_rho * np.sin(theta)) / sine
    y = (other_rho * np.cos(theta) - rho * np.cos(other_theta)) / sine
    return np.stack([x, y], axis=-1)


def _area(corners: FloatArray) -> FloatArray:
    x, y = np.moveaxis(corners, -1, 0)
    area: FloatArray = 0.5 * (x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y).sum(axis=1)
    return area


def _extent(tangent: FloatArray, corners: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lower and upper place (n, 4) of each side's corners along its line."""
    places = [np.einsum("nsi,nsi->ns", tangent, points) for points in (corners, np.roll(corners, -1, axis=1))]
    return np.minimum(*places), np.maximum(*places)


def _convex(corners: FloatArray) -> BoolArray:
    """Which outlines (n, 4, 2) turn towards (-dy, dx) at every corner."""
    side = np.roll(corners, -1, axis=1) - corners
    following = np.roll(side, -1, axis=1)
    turns = side[..., 0] * following[..., 1] - side[..., 1] * following[..., 0]
    convex: BoolArray = np.all(turns > 0.0, axis=1)
    return convex
