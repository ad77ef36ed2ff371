"""The target as its file describes it: named points, lines, bars, edges and faces in the capture frame C."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import ArrayLike

from rvdnav.bracket import EDGE_NAMES, Bracket, tolerance
from rvdnav.errors import InputError
from rvdnav.pose.arrays import FloatArray, float_array
from rvdnav.trapezoid import Trapezoid
from rvdnav.yamlio import Section, read_yaml

__all__ = ["EDGE_NAMES", "Bar", "Bracket", "Target", "load_target"]

_SIZES = ("long_base", "short_base", "height", "bar_width")
_KEYS = (
    *("name", "units", "dimensions", "points", "lines", "bars", "bar_thickness", "edge_radius", "edges", "faces"),
    "tolerance",
    *_SIZES,
)

UNSTATED_TOLERANCE = 3e-4
"""Standard deviation of a point's coordinates where the file says nothing, m: a thing measured with calipers."""

_METRES = {"m": 1.0, "mm": 1e-3}
_MIN_SEPARATION_M = 1e-6
_EXAMPLE = Trapezoid(0.2, 0.1, 0.15, 0.015, 0.015, 0.015)
"""Stands for the shape of a bracket whose file gives no coordinates."""
_FLATNESS = 1e-3
"""Smallest extent of the points across their main direction, as a fraction of the extent along it."""


@attrs.frozen
class Bar:
    """A bar with two parallel long edges, each given by the names of its ends; inner[i] lies next to outer[i]."""

    name: str
    outer: tuple[str, str]
    inner: tuple[str, str]


def _points(values: Mapping[str, ArrayLike]) -> dict[str, FloatArray]:
    points = {}
    for name, value in values.items():
        point: FloatArray = float_array(value, 3).copy()
        point.setflags(write=False)
        points[name] = point
    return points


def _same_points(a: Mapping[str, FloatArray], b: Mapping[str, FloatArray]) -> bool:
    return a.keys() == b.keys() and all(np.array_equal(a[name], b[name]) for name in a)


def _lines(values: Mapping[str, tuple[str, str]]) -> dict[str, tuple[str, str]]:
    return dict(values)


def _bars(values: Iterable[Bar]) -> tuple[Bar, ...]:
    return tuple(values)


def _edges(values: Iterable[tuple[str, str]]) -> tuple[tuple[str, str], ...]:
    return tuple(values)


def _faces(values: Iterable[Iterable[str]]) -> tuple[tuple[str, ...], ...]:
    return tuple(tuple(face) for face in values)


@attrs.frozen
class Target:
    """A target with straight edges.

    points: name -> position (3,), m in C.  lines: name -> names of the two ends.  bars, and their thickness towards
    +x_C, m.  edge_radius: by which all edges are rounded, m; the points are where they would meet if they were sharp.
    edges: further straight edges, by their ends.  faces: planar polygons, counter-clockwise from outside.
    dimensions_known: whether the points are the true sizes or merely an example of the shape.
    tolerance: name -> standard deviation of each coordinate of a point, m; None where nobody said, then
    `UNSTATED_TOLERANCE` stands for it.

    Raises ValueError for points that coincide or are all collinear, names that no point has, ends that are the same,
    faces that are not planar, a thickness that is negative, and a bracket that is none.
    """

    name: str
    points: dict[str, FloatArray] = attrs.field(converter=_points, eq=attrs.cmp_using(eq=_same_points))
    lines: dict[str, tuple[str, str]] = attrs.field(factory=dict, converter=_lines)
    bars: tuple[Bar, ...] = attrs.field(default=(), converter=_bars)
    bar_thickness: float = 0.0
    edge_radius: float = 0.0
    edges: tuple[tuple[str, str], ...] = attrs.field(default=(), converter=_edges)
    faces: tuple[tuple[str, ...], ...] = attrs.field(default=(), converter=_faces)
    dimensions_known: bool = True
    tolerance: Mapping[str, float] | None = attrs.field(default=None)
    bracket: Bracket | None = attrs.field(init=False, eq=False, repr=False)
    """The four-bar bracket that lines l1..l4 and the bars along them form, or None for any other target."""

    @bracket.default
    def _find_bracket(self) -> Bracket | None:
        self._check_points()
        self._check_names()
        self._check_faces()
        for name in ("bar_thickness", "edge_radius"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} is not a length")
        if self.tolerance is not None:
            self._check_tolerance(self.tolerance)
        if not self.bars or not {"l1", "l2", "l3", "l4"} <= self.lines.keys():
            return None
        outer, inner = _bracket_names(self.lines, self.bars)
        return Bracket([self.points[name] for name in outer], [self.points[name] for name in inner], self.bar_thickness)

    @property
    def bracket_names(self) -> tuple[str, ...]:
        """Names of P1..P4 and Q1..Q4.  Raises ValueError for a target that is no four-bar bracket."""
        outer, inner = _bracket_names(self.lines, self.bars)
        return (*outer, *inner)

    def point_sigma(self, name: str) -> float:
        """Standard deviation of each coordinate of a point, m, with what a rounded edge adds to it.

        Where faces meet at a right angle the silhouette of an edge of radius r lies up to (√2 − 1) r inside the corner,
        by the view; the step in brightness lies anywhere on the rounding.
        """
        stated = UNSTATED_TOLERANCE if self.tolerance is None else self.tolerance[name]
        return math.hypot(stated, (math.sqrt(2.0) - 1.0) * self.edge_radius)

    def resized(self, shape: Trapezoid) -> Target:
        """The same bracket with these sizes, as known ones; where its bars have no thickness, with half of their width
        in its place, which allows for side faces as deep as that.

        Raises ValueError for a target that is no bracket and sizes that make none.
        """
        if self.bracket is None:
            raise ValueError(f"target {self.name} is no four-bar bracket")
        thickness = self.bar_thickness or 0.5 * min(shape.long_base_width, shape.short_base_width, shape.leg_width)
        points = _bracket_points(self.lines, self.bars, shape)
        return attrs.evolve(self, points=points, bar_thickness=thickness, dimensions_known=True)

    def _check_points(self) -> None:
        if len(self.points) < 3:
            raise ValueError("fewer than three points")
        for a, b in itertools.combinations(self.points, 2):
            if np.linalg.norm(self.points[a] - self.points[b]) < _MIN_SEPARATION_M:
                raise ValueError(f"points {a} and {b} coincide")
        array = np.array(list(self.points.values()))
        extents = np.linalg.svd(array - array.mean(axis=0), compute_uv=False)
        if extents[1] < _FLATNESS * extents[0]:
            raise ValueError("the points are collinear")

    def _check_names(self) -> None:
        pairs = [(f"line {name}", ends) for name, ends in self.lines.items()]
        pairs += [(f"bar {bar.name}", ends) for bar in self.bars for ends in (bar.outer, bar.inner)]
        pairs += [(f"edge {list(ends)}", ends) for ends in self.edges]
        loops = [(f"face {list(face)}", face) for face in self.faces]
        for what, names in [*pairs, *loops]:
            for name in names:
                if name not in self.points:
                    raise ValueError(f"{what} names an unknown point {name!r}")
            if len(set(names)) < len(names):
                raise ValueError(f"{what} names a point twice")

    def _check_tolerance(self, tolerance: Mapping[str, float]) -> None:
        if tolerance.keys() != self.points.keys():
            raise ValueError("tolerance names other points than there are")
        size = float(np.ptp(np.array(list(self.points.values())), axis=0).max())
        for name, sigma in tolerance.items():
            if not 0.0 <= sigma <= size:
                raise ValueError(f"the tolerance of {name} is not between 0 and the target's size")

    def _check_faces(self) -> None:
        for face in self.faces:
            if len(face) < 3:
                raise ValueError(f"face {list(face)} has fewer than three points")
            corners = np.array([self.points[name] for name in face])
            centred = corners - corners.mean(axis=0)
            normal = np.linalg.svd(centred)[2][2]
            if np.abs(centred @ normal).max() > tolerance(float(np.abs(centred).max())):
                raise ValueError(f"face {list(face)} is not planar")


def _bracket_names(
    lines: Mapping[str, tuple[str, str]], bars: Iterable[Bar]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of P1..P4 and of Q1..Q4: P2 is where l1 meets l3, P3 where l3 meets l2, and so on round."""
    order = ("l1", "l3", "l2", "l4")
    loop = [set(lines[name]) for name in order]
    shared = [loop[i - 1] & loop[i] for i in range(4)]  # corners P1, P2, P3, P4
    if [len(corner) for corner in shared] != [1, 1, 1, 1] or len(set.union(*shared)) != 4:
        raise ValueError("lines l1, l3, l2, l4 do not form a closed loop")
    outer = tuple(corner.pop() for corner in shared)
    beside: dict[str, set[str]] = {name: set() for name in outer}
    for name, ends in zip(order, loop, strict=True):
        along = [bar for bar in bars if set(bar.outer) == ends]
        if len(along) != 1:
            raise ValueError(f"{len(along)} bars lie along line {name}, not one")
        for outer_name, inner_name in zip(along[0].outer, along[0].inner, strict=True):
            beside[outer_name].add(inner_name)
    for name, inner_names in beside.items():
        if len(inner_names) != 1:
            raise ValueError(f"the bars that meet in {name} have different inner points there")
    return outer, tuple(beside[name].pop() for name in outer)


def _bracket_points(
    lines: Mapping[str, tuple[str, str]], bars: Iterable[Bar], shape: Trapezoid
) -> dict[str, FloatArray]:
    """Positions of a bracket's points for a shape.  Raises ValueError where lines and bars form no bracket."""
    names = _bracket_names(lines, bars)
    return dict(zip((*names[0], *names[1]), np.concatenate(shape.apexes), strict=True))


def load_target(path: str | Path) -> Target:
    """The target that a `target.yaml` describes.

    Raises InputError naming the file when it is missing or malformed, lacks units or points, has neither bars nor
    edges, contradicts itself (see `Target`), or states a size that its points do not have.
    """
    section = read_yaml(Path(path))
    section.only(*_KEYS)
    if section.text("units") not in _METRES:
        raise section.fault("units", f"{section.text('units')!r} is not supported, only 'mm' and 'm'")
    scale = _METRES[section.text("units")]
    bars = [_read_bar(bar) for bar in section.sections("bars")] if "bars" in section else []
    edges = section.text_lists("edges") if "edges" in section else []
    if not bars and not edges:
        raise InputError(f"{path}: neither bars nor edges")
    known = _read_dimensions(section)
    lines_section = section.section("lines") if "lines" in section else None
    lines = {name: _pair(lines_section, name) for name in lines_section} if lines_section is not None else {}
    thick = bool(bars) and (known or "bar_thickness" in section)
    try:
        target = Target(
            name=section.text("name"),
            points=_read_points(section, scale) if known else _placeholder_points(section, lines, bars),
            lines=lines,
            bars=bars,
            bar_thickness=scale * section.number("bar_thickness") if thick else 0.0,
            edge_radius=scale * section.number("edge_radius") if "edge_radius" in section else 0.0,
            edges=[_as_pair(section, "edges", ends) for ends in edges],
            faces=section.text_lists("faces") if "faces" in section else (),
            dimensions_known=known,
        )
        target = attrs.evolve(target, tolerance=_read_tolerance(section, scale, target))
    except ValueError as error:
        raise InputError(f"{path}: {error}") from error
    if known and target.bracket is not None:
        _check_sizes(section, scale, target.bracket)
    return target


def _read_points(section: Section, scale: float) -> dict[str, FloatArray]:
    points = section.section("points")
    return {name: scale * points.numbers(name, 3) for name in points}


def _read_tolerance(section: Section, scale: float, target: Target) -> dict[str, float] | None:
    """By point: one number for all, or some for those that are named, the others' being unstated; None without any."""
    if "tolerance" not in section:
        return None
    if not isinstance(section.values["tolerance"], Mapping):
        return dict.fromkeys(target.points, scale * section.number("tolerance"))
    named = section.section("tolerance")
    named.only(*target.points)
    return {name: scale * named.number(name) if name in named else UNSTATED_TOLERANCE for name in target.points}


def _placeholder_points(
    section: Section, lines: Mapping[str, tuple[str, str]], bars: Iterable[Bar]
) -> dict[str, FloatArray]:
    """Of a bracket of unknown size: an example of its shape.  The file's points are looked at for their names alone.

    Raises InputError for lines and bars that form no bracket and points that are none of its corners.
    """
    if not {"l1", "l2", "l3", "l4"} <= lines.keys():
        raise section.fault("dimensions", "can be unknown only for a four-bar bracket with lines l1, l2, l3, l4")
    points = _bracket_points(lines, bars, _EXAMPLE)
    if "points" in section:
        named = section.values["points"]
        names = section.texts("points") if isinstance(named, list) else tuple(section.section("points"))
        others = sorted(set(names) - points.keys())
        if others:
            raise section.fault("points", f"has {others[0]!r}, which is no corner of the bracket of unknown dimensions")
    return points


def _pair(section: Section, key: str) -> tuple[str, str]:
    return _as_pair(section, key, section.texts(key))


def _as_pair(section: Section, key: str, names: tuple[str, ...]) -> tuple[str, str]:
    if len(names) != 2:
        raise section.fault(key, "needs two names for its ends")
    return names[0], names[1]


def _read_bar(section: Section) -> Bar:
    section.only("name", "outer", "inner")
    return Bar(section.text("name"), _pair(section, "outer"), _pair(section, "inner"))


def _read_dimensions(section: Section) -> bool:
    dimensions = section.text("dimensions") if "dimensions" in section else "known"
    if dimensions not in ("known", "unknown"):
        raise section.fault("dimensions", f"{dimensions!r} is neither 'known' nor 'unknown'")
    return dimensions == "known"


def _check_sizes(section: Section, scale: float, bracket: Bracket) -> None:
    """Raise InputError where a stated size differs from the points'."""
    given = ([bracket.long_base], [bracket.short_base], bracket.heights, bracket.bar_widths.ravel())
    measured = {key: np.asarray(values) for key, values in zip(_SIZES, given, strict=True)}
    for key in measured.keys() & set(section):
        stated = scale * section.number(key)
        worst = measured[key][np.argmax(np.abs(measured[key] - stated))]
        if abs(worst - stated) > tolerance(abs(stated)):
            raise section.fault(key, f"is {stated / scale:g} but the points give {worst / scale:g}")
