"""Drawn surfaces: the panel's grid, brushed metal, printed faces full of edges, a laboratory's wall; and foil."""

from __future__ import annotations

import cv2
import numpy as np

from rvdnav.pose.arrays import BoolArray, FloatArray
from rvdnav.simulation.mesh import TextureArray

Rng = np.random.Generator


def smooth_noise(rng: Rng, shape: tuple[int, int], cells: int) -> FloatArray:
    """Smooth noise (h, w) of unit deviation, its features a `cells`-th of the longer side in size."""
    scale = cells / max(shape)
    coarse = rng.standard_normal([max(4, round(length * scale) + 3) for length in shape])
    fine = cv2.resize(coarse, shape[::-1], interpolation=cv2.INTER_CUBIC).astype(np.float64)
    noise: FloatArray = fine / fine.std()
    return noise


def brushed(rng: Rng, reflectance: float) -> TextureArray:
    """Matte metal with faint strokes and stains."""
    stains = 0.01 * smooth_noise(rng, (512, 512), 24) + 0.01 * smooth_noise(rng, (512, 512), 160)
    strokes = 0.005 * rng.standard_normal((512, 1))
    return (reflectance * (1.0 + stains + strokes)).astype(np.float32)


def solar_cells(rows: int = 6, columns: int = 18) -> TextureArray:
    """A solar panel: dark cells, thin conductors along u, double seams between the columns."""
    height, width = 1536, 1280
    image = np.full((height, width), 0.04, np.float32)
    for column in range(columns + 1):
        x = 40 + round(column * (width - 81) / columns)
        cv2.line(image, (x, 40), (x, height - 41), 0.3, 3)
    for row in range(rows + 1):
        y = 40 + round(row * (height - 81) / rows)
        for offset in (-6, 6):
            cv2.line(image, (40, y + offset), (width - 41, y + offset), 0.3, 4)
    image[:, :26] = image[:, -26:] = 0.16
    image[:26] = image[-26:] = 0.16
    return np.ascontiguousarray(image.T)


def printed(rng: Rng) -> TextureArray:
    """A printed face: bars, boxes, discs and lines of many greys on a light ground, straight edges everywhere."""
    size = 1024
    image = np.full((size, size), rng.uniform(0.45, 0.7), np.float32)
    for _ in range(80):
        grey = float(rng.uniform(0.03, 0.75))
        x, y = rng.integers(0, size, 2).tolist()
        w, h = rng.integers(16, 220, 2).tolist()
        kind = rng.integers(4)
        if kind == 0:
            cv2.rectangle(image, (x, y), (x + w, y + h), grey, -1)
        elif kind == 1:
            corners = cv2.boxPoints(((x, y), (w, 0.3 * h + 8), float(rng.uniform(0, 180))))
            cv2.fillPoly(image, [corners.astype(np.int32)], grey, cv2.LINE_AA)
        elif kind == 2:
            cv2.circle(image, (x, y), w // 3, grey, -1, cv2.LINE_AA)
        else:
            cv2.line(image, (x, y), (x + 3 * (w - 140), y + 3 * (h - 140)), grey, int(rng.integers(3, 14)), cv2.LINE_AA)
    return image


def wall(rng: Rng) -> TextureArray:
    """A laboratory's wall: seams, door, window, shelves, posters, cables."""
    height, width = 1536, 2048
    image = np.full((height, width), 0.42, np.float32)
    image *= 1.0 + 0.03 * smooth_noise(rng, (height, width), 20).astype(np.float32)
    for x in range(0, width, 128):
        cv2.line(image, (x, 0), (x, height), 0.2, 3)
    for _ in range(110):
        x, y = (rng.uniform(0.0, 1.0, 2) * (width, height)).astype(int).tolist()
        w, h = rng.integers(20, 200, 2).tolist()
        ground = float(rng.uniform(0.05, 0.6))
        cv2.rectangle(image, (x, y), (x + w, y + h), ground, -1)
        cv2.rectangle(image, (x, y), (x + w, y + h), float(rng.uniform(0.02, 0.7)), int(rng.integers(2, 8)))
        for line in range(y + 14, y + h - 8, 16):
            cv2.line(image, (x + 10, line), (x + int(w * rng.uniform(0.5, 0.95)), line), 0.5 * ground, 2)
    for _ in range(12):
        y = int(rng.integers(0, height))
        cv2.line(
            image, (0, y), (width, y + int(rng.integers(-120, 120))), float(rng.uniform(0.03, 0.6)), 6, cv2.LINE_AA
        )
    return image


def crumpled(rng: Rng, shape: tuple[int, int], size: float) -> FloatArray:
    """Heights (h, w), m, of crumpled foil over a sheet whose longer side measures `size`, m: facets between creases."""
    pitch = size / max(shape)
    heights = 0.0004 * smooth_noise(rng, shape, round(size / 0.015))
    for spacing, slope in ((0.06, 0.11), (0.022, 0.09)):
        count = round(shape[0] * shape[1] * (pitch / spacing) ** 2)
        heights += slope * spacing * _facets(rng, shape, count)
    rounded = cv2.GaussianBlur(heights, (0, 0), 0.002 / pitch).astype(np.float64)  # creases are no knife edges
    centred: FloatArray = rounded - rounded.mean()
    return centred


def _facets(rng: Rng, shape: tuple[int, int], count: int) -> FloatArray:
    """A surface (h, w) that is flat between random points, its heights there of unit deviation (Delaunay)."""
    rows, columns = shape
    margin = 0.2 * max(shape)
    mesh = cv2.Subdiv2D((-round(2 * margin), -round(2 * margin), columns + round(4 * margin), rows + round(4 * margin)))
    points = rng.uniform((-margin, -margin), (columns + margin, rows + margin), (2 * count, 2)).astype(np.float32)
    height_at = dict(zip(map(tuple, points.tolist()), rng.standard_normal(len(points)).tolist(), strict=True))
    mesh.insert(list(height_at))
    x, y = np.meshgrid(np.arange(float(columns)), np.arange(float(rows)))
    surface = np.zeros(shape)
    for corners in np.array(mesh.getTriangleList()).reshape(-1, 3, 2):
        ends = [tuple(corner) for corner in corners.tolist()]
        if not all(end in height_at for end in ends):
            continue  # one of the triangulation's own outermost points
        low = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
        high = np.maximum(np.ceil(corners.max(axis=0)).astype(int) + 1, 0)
        window = (slice(low[1], high[1]), slice(low[0], high[0]))
        plane = np.linalg.solve(np.column_stack([corners, np.ones(3)]), [height_at[end] for end in ends])
        inside = _inside(corners.astype(np.float64), x[window], y[window])
        surface[window] = np.where(inside, plane[0] * x[window] + plane[1] * y[window] + plane[2], surface[window])
    return surface


def _inside(corners: FloatArray, x: FloatArray, y: FloatArray) -> BoolArray:
    sides = [
        (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])
        for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)
    ]
    inside: BoolArray = (np.min(sides, axis=0) >= 0.0) | (np.max(sides, axis=0) <= 0.0)
    return inside
