"""Meshes of solids with rounded edges, in the capture frame C."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from rvdnav.pose.arrays import FloatArray, float_array
from rvdnav.simulation.mesh import Mesh, behind, merge, polygon, ring

_STEPS = 8
"""Flat strips of a quarter of a cylinder."""


def rounded_frame(outer: ArrayLike, inner: ArrayLike, depth: float, radius: float) -> Mesh:
    """The `frame` with its long edges rounded, front and back: the loops are convex, and a side's faces meet in
    quarters of a cylinder.  radius, m: less than half of the depth and of the bars' width."""
    outer, inner = float_array(outer, None, 3), float_array(inner, None, 3)
    angles = np.linspace(0.0, 0.5 * np.pi, _STEPS + 1)
    # Behind the front, and into the bar, along an edge's section from the front to the side.
    back, into = radius * (1.0 - np.cos(angles)), radius * (1.0 - np.sin(angles))
    section = [
        *((outer, x, d) for x, d in zip(back, into, strict=True)),
        *((outer, depth - x, d) for x, d in zip(back[::-1], into[::-1], strict=True)),
        *((inner, depth - x, -d) for x, d in zip(back, into, strict=True)),
        *((inner, x, -d) for x, d in zip(back[::-1], into[::-1], strict=True)),
    ]
    loops = [behind(_inset(loop, inwards), x) for loop, x, inwards in section]
    return merge(
        [
            polygon([a, b, d, c])
            for first, second in zip(loops, [*loops[1:], loops[0]], strict=True)
            for a, b, c, d in ring(first, second)
        ]
    )


def _inset(loop: FloatArray, distance: float) -> FloatArray:
    """A convex loop (n, 3) across x that turns from y to z, every side moved inwards, m."""
    along = np.roll(loop, -1, axis=0) - loop
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    before = np.roll(along, 1, axis=0)
    # Along both sides of a corner by as much moves it off both by the distance.
    sine = np.cross(before, along)[:, :1]
    moved: FloatArray = loop + distance / sine * (along - before)
    return moved


def rounded_solid(faces: Sequence[FloatArray], radius: float) -> tuple[list[Mesh], Mesh]:
    """A convex solid with its edges and corners rounded: its flat faces, and all that is round.

    faces: polygons (n, 3), counter-clockwise from outside, which share their corners; three meet in each.  radius, m.

    Raises ValueError for any other solid, and one that the radius leaves no flat faces.
    """
    normals = [_normal(face) for face in faces]
    corners: dict[tuple[float, ...], list[int]] = {}
    for index, face in enumerate(faces):
        for point in face.tolist():
            corners.setdefault(tuple(point), []).append(index)
    centers: dict[tuple[float, ...], FloatArray] = {}
    for point, meeting in corners.items():
        if len(meeting) != 3:
            raise ValueError("edges can be rounded only where three faces meet in every corner")
        planes = np.array([normals[index] for index in meeting])
        centers[point] = np.array(point) - radius * np.linalg.solve(planes, np.ones(3))
        if any(((np.array(point) - face[0]) @ n > 1e-9) for face, n in zip(faces, normals, strict=True)):
            raise ValueError("edges can be rounded only of a convex solid")
    flat = [np.array([centers[tuple(point)] for point in face.tolist()]) for face in faces]
    for face, n in zip(flat, normals, strict=True):
        along = np.roll(face, -1, axis=0) - face
        if (np.cross(along, np.roll(along, -1, axis=0)) @ n <= 0.0).any():
            raise ValueError("edge_radius leaves nothing of a face")
    sides = {
        (tuple(a), tuple(b)): index
        for index, face in enumerate(faces)
        for a, b in zip(face.tolist(), np.roll(face, -1, axis=0).tolist(), strict=True)
    }
    round_parts = []
    for (a, b), index in sides.items():
        other = sides.get((b, a))
        if other is None:
            raise ValueError("edges can be rounded only of a solid whose faces close it")
        if index < other:
            arc = radius * _arc(normals[index], normals[other])
            for near, far in pairwise(arc):
                round_parts.append(polygon([centers[b] + near, centers[a] + near, centers[a] + far, centers[b] + far]))
    for point, meeting in corners.items():
        round_parts += _octant(centers[point], radius, *(normals[index] for index in meeting))
    moved = [polygon(face + radius * n) for face, n in zip(flat, normals, strict=True)]
    return moved, merge(round_parts)


def _normal(face: FloatArray) -> FloatArray:
    normal = np.cross(face[1] - face[0], face[2] - face[1])
    unit: FloatArray = normal / np.linalg.norm(normal)
    return unit


def _arc(start: FloatArray, end: FloatArray) -> FloatArray:
    """Unit vectors (n, 3) from one to the other, in even steps."""
    angle = float(np.arccos(np.clip(start @ end, -1.0, 1.0)))
    t = angle * np.linspace(0.0, 1.0, _STEPS + 1)[:, None]
    arc: FloatArray = (np.sin(angle - t) * start + np.sin(t) * end) / np.sin(angle)
    return arc


def _octant(center: FloatArray, radius: float, a: FloatArray, b: FloatArray, c: FloatArray) -> list[Mesh]:
    """The piece of a sphere between three directions."""
    rows = [[a]]
    for left, right in zip(_arc(a, b)[1:], _arc(a, c)[1:], strict=True):
        count = len(rows)
        t = np.linspace(0.0, 1.0, count + 1)[:, None]
        row = (1.0 - t) * left + t * right
        rows.append(list(row / np.linalg.norm(row, axis=1, keepdims=True)))
    triangles = []
    for above, below in pairwise(rows):
        triangles += [[above[i], below[i], below[i + 1]] for i in range(len(above))]
        triangles += [[above[i], below[i + 1], above[i + 1]] for i in range(len(above) - 1)]
    outwards = np.cross(b - a, c - a) @ (a + b + c) > 0.0
    return [polygon(center + radius * np.array(t if outwards else t[::-1])) for t in triangles]
