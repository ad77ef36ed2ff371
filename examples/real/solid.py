"""A target made of flat faces, from the polygons of a CAD model."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray
from rvdnav.target import Target

Points = NDArray[np.float64]

_SAME_M = 1e-6
_FLAT_M = 1e-5
# Measured models are flat to some tenths of a millimetre; a face further from it is no flat one.
_MOST_MOVED_M = 1e-3
_ROUNDS = 10_000
# Faces that meet at less than this have no edge between them, degrees.
_SMOOTH_DEG = 2.0


def solid(name: str, polygons: Iterable[Points], lines: Iterable[Points] = ()) -> Target:
    """The target with these faces, polygons (v, 3) counter-clockwise from outside, and their sides as its edges.

    lines (2, 3): further edges.  All in m.  Sides between faces of one plane, which a triangulated model is full of,
    are no edges.  Faces that aren't quite planar, as in models measured on the object, are made so by moving corners.
    Raises ValueError for faces that would have to move by more than a millimetre.
    """
    points: list[Points] = []

    def number(point: Points) -> int:
        for index, other in enumerate(points):
            if np.abs(point - other).max() < _SAME_M:
                return index
        points.append(np.asarray(point, np.float64))
        return len(points) - 1

    # Exported models have slivers: corners given twice, and faces that this leaves without area.
    faces = [list(dict.fromkeys(number(corner) for corner in polygon)) for polygon in polygons]
    faces = [face for face in faces if len(face) > 2 and np.linalg.norm(_normal(np.array(points)[face])) > _SAME_M**2]
    extra = [(number(a), number(b)) for a, b in lines]
    corners = _flattened(np.array(points), faces)
    return Target(
        name=name,
        points={f"P{index}": corner for index, corner in enumerate(corners)},
        edges=[(f"P{a}", f"P{b}") for a, b in _edges(corners, faces, extra)],
        faces=[[f"P{index}" for index in face] for face in faces],
    )


def _flattened(points: Points, faces: list[list[int]]) -> Points:
    """The points, moved until every face is planar, each face pulling at its own corners."""
    moved = points.copy()
    for _ in range(_ROUNDS):
        pulled, count, worst = np.zeros_like(moved), np.zeros((len(moved), 1)), 0.0
        for face in faces:
            centred = moved[face] - moved[face].mean(axis=0)
            normal = np.linalg.svd(centred)[2][2]
            height = centred @ normal
            worst = max(worst, float(np.abs(height).max()))
            pulled[face] -= height[:, None] * normal
            count[face] += 1
        if worst < _FLAT_M:
            break
        moved += pulled / np.maximum(count, 1)
    distance = float(np.linalg.norm(moved - points, axis=1).max(initial=0.0))
    if worst >= _FLAT_M or distance > _MOST_MOVED_M:
        raise ValueError(f"faces are not planar, by {1e3 * max(worst, distance):.1f} mm")
    return moved


def _edges(points: Points, faces: list[list[int]], extra: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """The faces' sides, each once and only where something changes there, and the extra edges."""
    beside: dict[tuple[int, int], list[Points]] = {}
    for face in faces:
        normal = _normal(points[face])
        for a, b in zip(face, [*face[1:], face[0]], strict=True):
            beside.setdefault((min(a, b), max(a, b)), []).append(normal / np.linalg.norm(normal))
    smooth = np.cos(np.radians(_SMOOTH_DEG))
    sharp = [ends for ends, normals in beside.items() if len(normals) != 2 or normals[0] @ normals[1] < smooth]
    return sharp + [(a, b) for a, b in extra if (min(a, b), max(a, b)) not in sharp]


def _normal(corners: Points) -> Points:
    """Of a polygon, towards where it runs counter-clockwise, twice as long as its area (Newell's method)."""
    normal: Points = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
    return normal
