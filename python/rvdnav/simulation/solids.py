"""Targets made in a scenario: a four-bar bracket from its sizes, a box; and the printed solid of any target's faces."""

from __future__ import annotations

import numpy as np

from rvdnav.pose.arrays import FloatArray
from rvdnav.simulation.mesh import Material, Mesh, Part, polygon
from rvdnav.simulation.rounding import rounded_solid
from rvdnav.simulation.textures import Rng, printed
from rvdnav.target import Bar, Target

_BARS = (("long_base", 1, 2), ("leg_lower", 2, 3), ("short_base", 3, 4), ("leg_upper", 4, 1))
_EDGE_REFLECTANCE = 0.55


def bracket_target(
    name: str, long_base: float, short_base: float, height: float, bar_width: float, thickness: float
) -> Target:
    """A symmetric bracket in its capture frame, as docs/conventions.md draws it; all sizes in m.

    Raises ValueError where the sizes make no bracket.
    """
    if min(long_base, short_base, height, bar_width, thickness) <= 0.0:
        raise ValueError("a size is not positive")
    slope = 0.5 * (long_base - short_base) / height
    run = bar_width * float(np.hypot(1.0, slope))  # of a leg's width along y
    y_inner = [0.5 * long_base - slope * z - run for z in (bar_width, height - bar_width)]
    if height <= 2.0 * bar_width or min(y_inner) <= 0.0:
        raise ValueError("the bars fill the bracket: there is no opening between them")
    points = {
        "P1": (0.0, -0.5 * long_base, 0.0),
        "P2": (0.0, 0.5 * long_base, 0.0),
        "P3": (0.0, 0.5 * short_base, height),
        "P4": (0.0, -0.5 * short_base, height),
        "Q1": (0.0, -y_inner[0], bar_width),
        "Q2": (0.0, y_inner[0], bar_width),
        "Q3": (0.0, y_inner[1], height - bar_width),
        "Q4": (0.0, -y_inner[1], height - bar_width),
    }
    return Target(
        name=name,
        points=points,
        lines={"l1": ("P1", "P2"), "l2": ("P3", "P4"), "l3": ("P2", "P3"), "l4": ("P4", "P1")},
        bars=[Bar(bar, (f"P{a}", f"P{b}"), (f"Q{a}", f"Q{b}")) for bar, a, b in _BARS],
        bar_thickness=thickness,
    )


def box_target(name: str, size: FloatArray) -> Target:
    """A box of that size (3,), m, centred on its frame: its twelve edges and six faces.

    Raises ValueError for a size that is not positive.
    """
    if not np.all(size > 0.0):
        raise ValueError("a size is not positive")
    signs = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    points = {f"B{i}": 0.5 * size * sign for i, sign in enumerate(signs)}
    edges = [(f"B{i}", f"B{i | bit}") for i in range(8) for bit in (1, 2, 4) if not i & bit]
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return Target(name=name, points=points, edges=edges, faces=[[f"B{i}" for i in face] for face in faces])


def solid(target: Target) -> tuple[list[Mesh], Mesh | None]:
    """The target's flat faces, and what is round between them.

    Raises ValueError where its edges cannot be rounded by its radius.
    """
    faces = [np.array([target.points[name] for name in face]) for face in target.faces]
    if not target.edge_radius:
        return [polygon(face) for face in faces], None
    return rounded_solid(faces, target.edge_radius)


def printed_parts(target: Target, rng: Rng) -> list[Part]:
    """The target's faces, each printed with a pattern of its own; rounded edges are plain."""
    faces, between = solid(target)
    parts = [Part(face, Material(printed(rng))) for face in faces]
    return parts if between is None else [*parts, Part(between, Material(_EDGE_REFLECTANCE))]
