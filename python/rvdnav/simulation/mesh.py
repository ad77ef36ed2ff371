"""Triangle meshes of a target's parts, in the capture frame C, and what their surfaces are made of."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rvdnav.pose.arrays import FloatArray, float_array

TextureArray = NDArray[np.float32]
TriangleArray = NDArray[np.uint32]


def _points(values: ArrayLike) -> FloatArray:
    return float_array(values, None, 3)


def _coordinates(values: ArrayLike) -> FloatArray:
    return float_array(values, None, 2)


def _triangles(values: ArrayLike) -> TriangleArray:
    return np.asarray(values, dtype=np.uint32).reshape(-1, 3)


@attrs.frozen(eq=False)
class Mesh:
    """vertices (n, 3), m; triangles (m, 3), indices, counter-clockwise from outside; uv (n, 2) in [0, 1]².

    smooth: whether the shading hides the edges between triangles.
    """

    vertices: FloatArray = attrs.field(converter=_points)
    triangles: TriangleArray = attrs.field(converter=_triangles)
    uv: FloatArray = attrs.field(converter=_coordinates)
    smooth: bool = False


@attrs.frozen(eq=False)
class Material:
    """reflectance: a number, or a texture (h, w) whose first row is at v = 0.  roughness: of a metal (GGX alpha), or
    None for a matte surface."""

    reflectance: float | TextureArray
    roughness: float | None = None


@attrs.frozen(eq=False)
class Part:
    """A piece of the scene: one mesh of one material."""

    mesh: Mesh
    material: Material


def merge(meshes: Sequence[Mesh]) -> Mesh:
    """All of them as one mesh."""
    offsets = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    triangles = [mesh.triangles + np.uint32(offset) for mesh, offset in zip(meshes, offsets, strict=True)]
    return Mesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate(triangles),
        np.concatenate([mesh.uv for mesh in meshes]),
    )


def polygon(corners: ArrayLike, uv: ArrayLike | None = None) -> Mesh:
    """A flat convex polygon (n, 3), counter-clockwise from outside.

    Without uv (n, 2) its first side runs along u, and the longer of its extents is 1.
    """
    points = float_array(corners, None, 3)
    if uv is None:
        uv = _flat_coordinates(points)
    fan = [(0, i, i + 1) for i in range(1, len(points) - 1)]
    return Mesh(points, fan, uv)


def _flat_coordinates(points: FloatArray) -> FloatArray:
    along = points[1] - points[0]
    along /= np.linalg.norm(along)
    normal = np.cross(along, points[2] - points[0])
    across = np.cross(normal / np.linalg.norm(normal), along)
    flat = (points - points[0]) @ np.stack([along, across], axis=1)
    flat -= flat.min(axis=0)
    scaled: FloatArray = flat / flat.max()
    return scaled


def box(low: ArrayLike, high: ArrayLike) -> Mesh:
    """An upright box between two corners (3,)."""
    (x0, y0, z0), (x1, y1, z1) = float_array(low, 3), float_array(high, 3)
    front = [[x0, y0, z0], [x0, y0, z1], [x0, y1, z1], [x0, y1, z0]]
    return prism(front, x1 - x0)


def prism(front: ArrayLike, depth: float) -> Mesh:
    """A solid behind a polygon (n, 3) that faces -x, by depth, m, along +x."""
    front = float_array(front, None, 3)
    back = behind(front, depth)
    sides = [polygon([a, c, d, b]) for a, b, c, d in ring(front, back)]
    return merge([polygon(front), polygon(back[::-1]), *sides])


def frame(outer: ArrayLike, inner: ArrayLike, depth: float) -> Mesh:
    """A flat frame of straight bars: between an outer and an inner polygon (n, 3) that turn from y to z about +x,
    and by depth, m, along +x."""
    outer, inner = float_array(outer, None, 3), float_array(inner, None, 3)
    outer_back, inner_back = behind(outer, depth), behind(inner, depth)
    faces = []
    for a, b, c, d in ring(outer, inner):
        faces.append(polygon([a, c, d, b]))
    for a, b, c, d in ring(outer_back, inner_back):
        faces.append(polygon([a, b, d, c]))
    for a, b, c, d in ring(outer, outer_back):
        faces.append(polygon([a, b, d, c]))
    for a, b, c, d in ring(inner, inner_back):
        faces.append(polygon([a, c, d, b]))
    return merge(faces)


def behind(points: FloatArray, depth: float) -> FloatArray:
    """Points (n, 3) moved by depth, m, along +x."""
    moved: FloatArray = points + np.array([depth, 0.0, 0.0])
    return moved


def ring(first: FloatArray, second: FloatArray) -> list[tuple[FloatArray, FloatArray, FloatArray, FloatArray]]:
    """For every side: its start and end in the first loop, then in the second."""
    return list(zip(first, np.roll(first, -1, axis=0), second, np.roll(second, -1, axis=0), strict=True))


def cylinder(center: ArrayLike, radius: float, length: float, *, hole: float = 0.0, sides: int = 64) -> Mesh:
    """A cylinder about an axis along +x from `center` (3,), the middle of its front; hole: radius of a bore, m."""
    angles = 2.0 * np.pi * np.arange(sides) / sides
    circle = np.stack([np.zeros(sides), np.cos(angles), np.sin(angles)], axis=1)
    front = float_array(center, 3) + radius * circle
    if hole > 0.0:
        return frame(front, float_array(center, 3) + hole * circle, length)
    return prism(front[::-1], length)


def sheet(heights: ArrayLike, low: ArrayLike, high: ArrayLike) -> Mesh:
    """A smooth surface facing -x over a rectangle from low to high (y, z), m, at x = heights (rows along z)."""
    x = float_array(heights, None, None)
    rows, columns = x.shape
    (y0, z0), (y1, z1) = float_array(low, 2), float_array(high, 2)
    z, y = np.meshgrid(np.linspace(z0, z1, rows), np.linspace(y0, y1, columns), indexing="ij")
    v, u = np.meshgrid(np.linspace(0.0, 1.0, rows), np.linspace(0.0, 1.0, columns), indexing="ij")
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1].ravel(), index[:-1, 1:].ravel(), index[1:, 1:].ravel(), index[1:, :-1].ravel()
    triangles = np.concatenate([np.stack([a, d, c], axis=1), np.stack([a, c, b], axis=1)])
    vertices, uv = np.stack([x, y, z], axis=2).reshape(-1, 3), np.stack([u, v], axis=2).reshape(-1, 2)
    return Mesh(vertices, triangles, uv, smooth=True)
