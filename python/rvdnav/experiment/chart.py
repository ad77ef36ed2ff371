"""A test chart: straight edges of known place, contrast and brightness, seen by a camera with noise."""

from __future__ import annotations

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from rvdnav.images import PixelArray
from rvdnav.pose.arrays import FloatArray

LEVELS = (20.0, 55.0, 110.0, 190.0)
"""Grey levels of the chart's quarters: from deep shadow to full light."""
CONTRASTS = (0.08, 0.12, 0.2, 0.35)
"""Of the edges, as a part of the level beside them."""
_BLUR_PX = 0.6
_READ_NOISE = 1.0
_SHOT_NOISE = 0.025
_TURNS = (8.0, 35.0, 62.0, 80.0)
_INSET = 0.16
_OVERSAMPLING = 4
# Corners blend two edges, and are not judged.
_CORNER_PX = 4.0


@attrs.frozen(eq=False)
class Chart:
    """A noisy picture of squares on four grounds.

    image (h, w).  distance (h, w), px: of each pixel from the nearest edge.  places (n, 2): points x, y along the
    edges, px, half a pixel apart.  level, contrast (n,): of the edge at each place.
    """

    image: PixelArray
    distance: FloatArray
    places: FloatArray
    level: FloatArray
    contrast: FloatArray


def draw_chart(width: int, height: int, noise: float, seed: int) -> Chart:
    """The chart, width x height px.

    noise: factor on the noise of a real sensor, whose variance is 1 + 0.025 DN in squared grey levels (read and shot
    noise).  Every quarter has one level and four turned squares, one of each contrast.
    """
    squares = [
        (level, contrast, _square(width, height, quarter, number))
        for quarter, level in enumerate(LEVELS)
        for number, contrast in enumerate(CONTRASTS)
    ]
    scene = _grounds(width, height)
    for level, contrast, corners in squares:
        fixed = np.round((corners + 0.5) * _OVERSAMPLING * 16.0 - 8.0).astype(np.int32)
        cv2.fillPoly(scene, [fixed[:, None, :]], level * (1.0 + contrast), cv2.LINE_8, 4)
    small = scene.reshape(height, _OVERSAMPLING, width, _OVERSAMPLING).mean(axis=(1, 3))
    clean = cv2.GaussianBlur(small, (0, 0), _BLUR_PX)
    sigma = noise * np.sqrt(_READ_NOISE + _SHOT_NOISE * clean)
    noisy = clean + sigma * np.random.default_rng(seed).standard_normal(clean.shape)
    image = np.clip(np.round(noisy), 0, 255).astype(np.uint8)
    sides = [_side_places(corners, _CORNER_PX) for _, _, corners in squares]
    whole = [_side_places(corners, 0.0) for _, _, corners in squares]
    return Chart(
        image=image,
        distance=_distance(width, height, [*whole, _ground_places(width, height)]),
        places=np.concatenate(sides),
        level=np.concatenate([np.full(len(p), s[0]) for p, s in zip(sides, squares, strict=True)]),
        contrast=np.concatenate([np.full(len(p), s[1]) for p, s in zip(sides, squares, strict=True)]),
    )


def _grounds(width: int, height: int) -> NDArray[np.float32]:
    scene = np.empty((height * _OVERSAMPLING, width * _OVERSAMPLING), np.float32)
    rows, columns = scene.shape
    for quarter, level in enumerate(LEVELS):
        y, x = divmod(quarter, 2)
        scene[y * rows // 2 : (y + 1) * rows // 2, x * columns // 2 : (x + 1) * columns // 2] = level
    return scene


def _square(width: int, height: int, quarter: int, number: int) -> FloatArray:
    """Corners (4, 2) of a turned square, px."""
    cell = np.array([width, height]) / 4.0
    column, row = 2 * (quarter % 2) + number % 2, 2 * (quarter // 2) + number // 2
    middle = (np.array([column, row]) + 0.5) * cell - 0.5
    half = float(cell.min()) * (0.5 - _INSET) / np.sqrt(2.0)
    angle = np.radians(_TURNS[number] + 45.0 + 90.0 * np.arange(4))
    corners: FloatArray = middle + half * np.sqrt(2.0) * np.column_stack([np.cos(angle), np.sin(angle)])
    return corners


def _side_places(corners: FloatArray, margin: float) -> FloatArray:
    """Points along a polygon's sides, without that much of them, px, at the corners."""
    places = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        length = float(np.linalg.norm(end - start))
        along = np.arange(margin, length - margin, 0.5)[:, None] / length
        places.append(start + along * (end - start))
    return np.concatenate(places)


def _ground_places(width: int, height: int) -> FloatArray:
    """Points along the borders between the grounds, which are edges too but not judged."""
    x, y = np.arange(0.0, width, 0.5), np.arange(0.0, height, 0.5)
    across = np.column_stack([x, np.full_like(x, height / 2 - 0.5)])
    down = np.column_stack([np.full_like(y, width / 2 - 0.5), y])
    return np.concatenate([across, down])


def _distance(width: int, height: int, places: list[FloatArray]) -> FloatArray:
    marked = np.ones((height, width), np.uint8)
    x, y = np.round(np.concatenate(places)).astype(np.int64).T
    marked[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)] = 0
    distance: FloatArray = cv2.distanceTransform(marked, cv2.DIST_L2, cv2.DIST_MASK_PRECISE).astype(np.float64)
    return distance
