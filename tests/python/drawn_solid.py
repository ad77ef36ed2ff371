"""Drawn frames of printed solids, panels and frames: exact truth, surfaces full of straight edges that are no model's.

Faces are painted from far to near, which is right for a convex solid.  Prints are convex polygons in a face's own
coordinates, from 0 to 1 along its first two sides.
"""

from __future__ import annotations

from collections.abc import Iterator

import attrs
import cv2
import numpy as np
from drawn_scene import SCANLINES, frame_of, outline, paint
from rvdnav import Frame, Rig, Target

BACKGROUND = 12.0
NOISE = 1.5
BLUR = 0.6

_BOX_FACES = {
    "front": ("A", "D", "C", "B"),
    "back": ("E", "F", "G", "H"),
    "low": ("A", "B", "F", "E"),
    "high": ("D", "H", "G", "C"),
    "left": ("A", "E", "H", "D"),
    "right": ("B", "C", "G", "F"),
}


def box_target(size: tuple[float, float, float] = (0.16, 0.12, 0.2)) -> Target:
    """A box about C's origin; its front looks towards -x_C."""
    x, y, z = np.array(size) / 2.0
    corners = {"A": (-x, -y, -z), "B": (-x, y, -z), "C": (-x, y, z), "D": (-x, -y, z)}
    corners |= {"E": (x, -y, -z), "F": (x, y, -z), "G": (x, y, z), "H": (x, -y, z)}
    faces = [_outward(face, corners) for face in _BOX_FACES.values()]
    edges = ["AB", "BC", "CD", "DA", "EF", "FG", "GH", "HE", "AE", "BF", "CG", "DH"]
    return Target("box", corners, edges=[tuple(edge) for edge in edges], faces=faces)


def _outward(face: tuple[str, ...], corners: dict[str, tuple[float, float, float]]) -> tuple[str, ...]:
    a, b, c = (np.array(corners[name]) for name in face[:3])
    return face if np.cross(b - a, c - b) @ a > 0.0 else face[::-1]


def panel_target(width: float = 0.24, height: float = 0.16) -> Target:
    """A thin panel with a front and a back, and the two joints of its cells as further edges."""
    y, z, third = width / 2.0, height / 2.0, width / 6.0
    points = {"A": (0, -y, -z), "B": (0, y, -z), "C": (0, y, z), "D": (0, -y, z)}
    points |= {"P": (0, -third, -z), "Q": (0, -third, z), "R": (0, third, -z), "S": (0, third, z)}
    edges = [("A", "B"), ("B", "C"), ("C", "D"), ("D", "A"), ("P", "Q"), ("R", "S")]
    return Target("panel", points, edges=edges, faces=[("A", "D", "C", "B"), ("A", "B", "C", "D")])


def frame_target(outer: float = 0.2, inner: float = 0.15) -> Target:
    """A flat square frame without faces: every edge is seen from both sides."""
    points = {}
    for name, half in (("P", outer / 2.0), ("Q", inner / 2.0)):
        corners = [(-half, -half), (half, -half), (half, half), (-half, half)]
        points |= {f"{name}{i}": (0.0, y, z) for i, (y, z) in enumerate(corners, start=1)}
    edges = [(f"{n}{i}", f"{n}{i % 4 + 1}") for n in "PQ" for i in range(1, 5)]
    return Target("frame", points, edges=edges)


@attrs.frozen
class Surface:
    """A face as painted: its corners (v, 3) in C, its grey, its prints: corners (k, 2) in the face with a grey, and the
    corners of a hole."""

    corners: np.ndarray
    grey: float
    prints: tuple[tuple[np.ndarray, float], ...] = ()
    hole: np.ndarray | None = None


def surfaces(target: Target, seed: int = 3) -> list[Surface]:
    """Every face of the target with a print of its own: stripes, a grid, letters, a border, all straight."""
    rng = np.random.default_rng(seed)
    greys = (150.0, 95.0, 200.0, 120.0, 60.0, 170.0)
    return [
        Surface(np.array([target.points[name] for name in face]), greys[i % 6], tuple(_print(i, greys[i % 6], rng)))
        for i, face in enumerate(target.faces)
    ]


def panel_surfaces(target: Target, seed: int = 3) -> list[Surface]:
    """Both sides of `panel_target`: a print over three cells, of which the middle one is darker."""
    front, back = surfaces(target, seed)
    cells = (_box(0.0, 1.0 / 3.0, 1.0, 2.0 / 3.0), _box(1.0 / 3.0, 0.0, 2.0 / 3.0, 1.0))
    return [
        attrs.evolve(side, prints=((cell, 0.75 * side.grey), *side.prints))
        for side, cell in zip((front, back), cells, strict=True)
    ]


def frame_surfaces(target: Target) -> list[Surface]:
    """Both sides of `frame_target`."""
    outer, inner = (np.array([target.points[f"{name}{i}"] for i in range(1, 5)]) for name in "PQ")
    return [Surface(outer, 150.0, hole=inner), Surface(outer[::-1], 110.0, hole=inner[::-1])]


def _print(kind: int, grey: float, rng: np.random.Generator) -> Iterator[tuple[np.ndarray, float]]:
    dark, light = 0.45 * grey, min(1.4 * grey, 245.0)
    if kind % 3 == 0:  # a border and bars of letters
        yield from ((box, dark) for box in (_box(0.06, 0.06, 0.94, 0.1), _box(0.06, 0.9, 0.94, 0.94)))
        for row in np.arange(0.2, 0.8, 0.16):
            for column in np.arange(0.12, 0.82, 0.12):
                yield _box(column, row, column + 0.02, row + 0.1), light
                if rng.random() < 0.7:
                    yield _box(column, row, column + 0.07, row + 0.025), light
    elif kind % 3 == 1:  # stripes along the first side
        for low in np.arange(0.08, 0.92, 0.105):
            yield _box(0.04, low, 0.96, low + 0.045), dark
    else:  # a grid of cells and a slanted stripe
        for u in np.arange(0.07, 0.9, 0.15):
            for v in np.arange(0.07, 0.9, 0.15):
                yield _box(u, v, u + 0.12, v + 0.12), dark
        yield np.array([[0.1, 0.55], [0.13, 0.5], [0.9, 0.8], [0.87, 0.85]]), light


def _box(u0: float, v0: float, u1: float, v1: float) -> np.ndarray:
    return np.array([[u0, v0], [u1, v0], [u1, v1], [u0, v1]])


def draw_solid(
    rig: Rig, faces: list[Surface], T_world_target: np.ndarray, *, timestamp_ns: int, seed: int = 0
) -> Frame:
    """A frame with an image of every camera of the rig."""
    rng = np.random.default_rng(seed)
    images = [_draw(rig, camera, faces, T_world_target, rng) for camera in range(len(rig.cameras))]
    return frame_of([*images, None][:2], timestamp_ns)


def _draw(rig: Rig, camera: int, faces: list[Surface], T: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    canvas = np.full((rig.height * SCANLINES, rig.width), BACKGROUND, np.float32)
    _stars(canvas, rng)
    eye_C = T[:3, :3].T @ (rig.T_world_cam[camera][:3, 3] - T[:3, 3])
    for face in sorted(faces, key=lambda face: -float(np.linalg.norm(face.corners.mean(axis=0) - eye_C))):
        a, b, c = face.corners[:3]
        normal = np.cross(b - a, c - b)
        if normal @ (eye_C - a) <= 0.0:
            continue
        # Lambert's law for a lamp at the camera.
        to_eye = eye_C - face.corners.mean(axis=0)
        shade = 0.35 + 0.65 * float(normal @ to_eye) / float(np.linalg.norm(normal) * np.linalg.norm(to_eye))
        hole = None if face.hole is None else outline(rig, camera, T, face.hole)
        paint(canvas, shade * face.grey, outline(rig, camera, T, face.corners), hole)
        u, v = b - a, face.corners[-1] - a
        for corners, grey in face.prints:
            paint(canvas, shade * grey, outline(rig, camera, T, a + corners @ np.array([u, v])))
    image = canvas.reshape(rig.height, SCANLINES, rig.width).mean(axis=1)
    image = cv2.GaussianBlur(image, (0, 0), BLUR)
    noisy = image + rng.normal(0.0, NOISE, image.shape)
    return np.clip(np.round(noisy), 0, 255).astype(np.uint8)


def _stars(canvas: np.ndarray, rng: np.random.Generator) -> None:
    rows, columns = rng.integers(0, canvas.shape[0] - 8, 60), rng.integers(0, canvas.shape[1], 60)
    for row, column in zip(rows, columns, strict=True):
        canvas[row : row + 8, column] = 200.0
