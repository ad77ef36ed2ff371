"""Drawn stereo frames of a bracket, for any rig, bracket and pose: known truth without a renderer.

Every shape is a convex polygon whose sides are bent by the lens.  A scanline's coverage is exact along the row; eight
scanlines make a pixel.  Then come the blur of the lens and seeded noise.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise
from pathlib import Path

import attrs
import cv2
import numpy as np
from rvdnav import CameraModel, Frame, Rig, Target, load_rig
from rvdnav.images import Image
from rvdnav.pose import rotation_from_euler
from rvdnav.pose.euler import EulerAngles
from rvdnav.rig import world_from_camchain
from rvdnav.target import Bar, Bracket
from scipy.spatial.transform import Rotation

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "approach"
START_NS = 1_700_000_000_000_000_000
STEP_NS = 125_000_000

SCANLINES = 8
_SIDE_POINTS = 12


@attrs.frozen
class Look:
    """What is in the picture beside the front face: grey levels, clutter, noise (standard deviation, grey levels)."""

    background: float = 25.0
    face: float = 150.0
    side: float = 70.0
    thick: bool = True
    clutter: bool = True
    bracket: bool = True
    blur: float = 0.6
    noise: float = 1.5


def example_rig() -> Rig:
    """704 x 576, f = 670 px, 0.12 m: the rig of the example sequence."""
    return load_rig(EXAMPLE)


def wide_rig() -> Rig:
    """640 x 480, f = 540 px, 0.2 m, toed in and with distortions of its own."""
    left = CameraModel(640, 480, 541.2, 540.1, 325.3, 236.2, [-0.11, 0.021, -0.0003, 0.0007])
    right = CameraModel(640, 480, 538.4, 538.9, 313.9, 243.8, [-0.125, 0.028, 0.0006, -0.0002])
    T_cam1_cam0 = np.eye(4)
    T_cam1_cam0[:3, :3] = Rotation.from_euler("xyz", [0.4, 3.2, -0.5], degrees=True).as_matrix()
    T_cam1_cam0[:3, 3] = [-0.1998, 0.0011, 0.0062]
    return Rig((left, right), world_from_camchain(T_cam1_cam0), np.zeros((22, 22)))


def bracket_target(
    long_base: float = 0.18,
    short_base: float = 0.09,
    height: float = 0.14,
    width: float = 0.014,
    thickness: float = 0.006,
) -> Target:
    """A symmetric trapezoid frame of those sizes, m."""
    a, b = long_base / 2, short_base / 2
    slope = (a - b) / height

    def inner_half(z: float) -> float:
        return a - slope * z - width * float(np.hypot(1.0, slope))

    outer = [(a, 0.0), (b, height)]
    inner = [(inner_half(z), z) for z in (width, height - width)]
    points = {}
    for kind, ((low, z_low), (high, z_high)) in (("P", outer), ("Q", inner)):
        corners = [(-low, z_low), (low, z_low), (high, z_high), (-high, z_high)]
        points.update({f"{kind}{i}": [0.0, *corner] for i, corner in enumerate(corners, start=1)})
    lines = {"l1": ("P1", "P2"), "l2": ("P3", "P4"), "l3": ("P2", "P3"), "l4": ("P4", "P1")}
    bars = [Bar(name, outer, (outer[0].replace("P", "Q"), outer[1].replace("P", "Q"))) for name, outer in lines.items()]
    return Target("drawn", points, lines, bars, thickness, tolerance=dict.fromkeys(points, 0.0))


def pose(
    x: float, y: float = 0.0, z: float = 0.05, phi: float = 0.0, theta: float = 0.0, psi: float = 0.0
) -> np.ndarray:
    """T_world_target: position in W, m; attitude angles, degrees."""
    T = np.eye(4)
    T[:3, :3] = rotation_from_euler(EulerAngles(*np.radians([phi, theta, psi])))
    T[:3, 3] = [x, y, z]
    return T


def draw_frame(
    rig: Rig,
    target: Target,
    T_world_target: np.ndarray,
    *,
    timestamp_ns: int = START_NS,
    seed: int = 0,
    look: Look | None = None,
) -> Frame:
    """Both images of one moment."""
    images = draw_images(rig, target, T_world_target, seed=seed, look=look)
    return frame_of(images, timestamp_ns)


def frame_of(images: Iterable[np.ndarray | None], timestamp_ns: int = START_NS) -> Frame:
    """A frame of two images, either of which may be missing."""
    left, right = (None if pixels is None else Image(pixels, timestamp_ns) for pixels in images)
    return Frame(timestamp_ns, left, right)


def draw_images(
    rig: Rig, target: Target, T_world_target: np.ndarray, *, seed: int = 0, look: Look | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """The left and the right image."""
    look = look or Look()
    rng = np.random.default_rng(seed)
    left, right = (_draw(rig, camera, target.bracket, T_world_target, look, rng) for camera in (0, 1))
    return left, right


def _draw(rig: Rig, camera: int, bracket: Bracket, T: np.ndarray, look: Look, rng: np.random.Generator) -> np.ndarray:
    canvas = np.full((rig.height * SCANLINES, rig.width), look.background, np.float32)
    if look.clutter:
        for corners, grey in _clutter(bracket):
            paint(canvas, grey, outline(rig, camera, T, corners))
    if look.bracket:
        if look.thick:
            for quad in _sides_in_sight(bracket, T, rig.T_world_cam[camera][:3, 3]):
                paint(canvas, look.side, outline(rig, camera, T, quad))
        hole = outline(rig, camera, T, bracket.inner)
        paint(canvas, look.face, outline(rig, camera, T, bracket.outer), hole)
    image = canvas.reshape(rig.height, SCANLINES, rig.width).mean(axis=1)
    image = cv2.GaussianBlur(image, (0, 0), look.blur)
    noisy = image + rng.normal(0.0, look.noise, image.shape)
    return np.clip(np.round(noisy), 0, 255).astype(np.uint8)


def _sides_in_sight(bracket: Bracket, T: np.ndarray, centre_W: np.ndarray) -> Iterator[np.ndarray]:
    """Side faces of the bars that a camera sees, as quadrilaterals in C."""
    back = np.array([bracket.thickness, 0.0, 0.0])
    eye_C = T[:3, :3].T @ (centre_W - T[:3, 3])
    middle = bracket.outer.mean(axis=0)
    for corners, outwards in ((bracket.outer, 1.0), (bracket.inner, -1.0)):
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
            normal = np.cross(b - a, back)
            normal *= outwards * np.sign(normal @ (a - middle))
            if normal @ (eye_C - a) > 0.0:
                yield np.array([a, b, b + back, a + back])


def _clutter(bracket: Bracket) -> Iterator[tuple[np.ndarray, float]]:
    """A panel's grid beyond the short base, and a wall with facets and a doubler plate beside the long one."""
    h, a = float(bracket.outer[2, 2]), float(bracket.outer[1, 1])

    def rectangle(x: float, y: tuple[float, float], z: tuple[float, float]) -> np.ndarray:
        return np.array([[x, y[0], z[0]], [x, y[1], z[0]], [x, y[1], z[1]], [x, y[0], z[1]]])

    yield rectangle(0.01, (-1.6 * a, 1.6 * a), (1.12 * h, 2.7 * h)), 95.0
    cells = np.linspace(-1.55 * a, 1.55 * a, 8)
    columns = np.linspace(1.16 * h, 2.65 * h, 6)
    for y0, y1 in pairwise(cells):
        for z0, z1 in pairwise(columns):
            yield rectangle(0.01, (y0 + 0.004, y1 - 0.004), (z0 + 0.004, z1 - 0.004)), 45.0
    yield rectangle(0.012, (-2.2 * a, 2.2 * a), (-3.0 * h, -0.12 * h)), 60.0
    facets = np.random.default_rng(7)
    for _ in range(24):
        centre = np.array([0.012, facets.uniform(-1.9, 1.9) * a, facets.uniform(-2.6, -0.5) * h])
        angles = np.sort(facets.uniform(0.0, 2 * np.pi, 4))
        corners = np.column_stack([np.zeros(4), np.cos(angles), np.sin(angles)]) * facets.uniform(0.1, 0.4) * h
        if (np.diff(np.append(angles, angles[0] + 2 * np.pi)) < np.pi).all():
            yield centre + corners, facets.uniform(20.0, 200.0)


def outline(rig: Rig, camera: int, T: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Raw pixels (n, 2) along the outline of a polygon in C."""
    ends = np.roll(corners, -1, axis=0)
    w = np.linspace(0.0, 1.0, _SIDE_POINTS, endpoint=False)[:, None]
    points = np.concatenate([a + w * (b - a) for a, b in zip(corners, ends, strict=True)])
    return rig.project(camera, points @ T[:3, :3].T + T[:3, 3])


def paint(canvas: np.ndarray, grey: float, outline: np.ndarray, hole: np.ndarray | None = None) -> None:
    if not np.isfinite(outline).all():
        return
    covered = _coverage(canvas.shape, outline)
    if covered is None:
        return
    rows, columns, part = covered
    if hole is not None:
        cut = _coverage(canvas.shape, hole)
        if cut is not None:
            inside = part[cut[0].start - rows.start : cut[0].stop - rows.start]
            inside[:, cut[1].start - columns.start : cut[1].stop - columns.start] -= cut[2]
    canvas[rows, columns] += part * (grey - canvas[rows, columns])


def _coverage(shape: tuple[int, int], outline: np.ndarray) -> tuple[slice, slice, np.ndarray] | None:
    """Part of each scanline's pixels inside a convex outline, over the rows and columns that it touches."""
    x, y = outline[:, 0], (outline[:, 1] + 0.5) * SCANLINES - 0.5
    rows = slice(max(int(np.ceil(y.min())), 0), min(int(np.floor(y.max())) + 1, shape[0]))
    columns = slice(max(int(np.floor(x.min())) - 1, 0), min(int(np.ceil(x.max())) + 2, shape[1]))
    if rows.stop <= rows.start or columns.stop <= columns.start:
        return None
    line = np.arange(rows.start, rows.stop, dtype=np.float64)[:, None]
    x1, y1 = np.roll(x, -1), np.roll(y, -1)
    crossed = (line >= np.minimum(y, y1)) & (line < np.maximum(y, y1))
    at = x + (line - y) / np.where(y1 == y, 1.0, y1 - y) * (x1 - x)
    low = np.where(crossed, at, np.inf).min(axis=1)
    high = np.where(crossed, at, -np.inf).max(axis=1)
    low, high = (np.where(crossed.any(axis=1), bound, 0.0)[:, None] for bound in (low, high))
    right = np.arange(columns.start, columns.stop) + 0.5
    part = np.clip(right - low, 0.0, 1.0) - np.clip(right - high, 0.0, 1.0)
    return rows, columns, part.astype(np.float32)
