"""The paper's section 3.1: the adaptive threshold against the plain Sobel operator with a given one."""

from __future__ import annotations

import attrs
import cv2
import numpy as np

from rvdnav.core import Core, unpack_edges
from rvdnav.experiment.chart import Chart, draw_chart
from rvdnav.images import PixelArray
from rvdnav.pose.arrays import BoolArray, FloatArray

NOISES = (1.0, 2.0, 3.0)
"""Factors on the sensor's noise."""
THRESHOLDS = np.arange(3.0, 40.0, 1.0)
"""Of the plain operator, grey levels of a step."""
_MAGNITUDE_PER_STEP = 3.0
# An edge is found where a pixel of the map lies this near; farther than the second distance there is none to find.
_FOUND_PX = 1.5
_EMPTY_PX = 4.0


@attrs.frozen(eq=False)
class Quality:
    """Of an edge map: the part of the true edges that it shows, and its edge pixels where there is no edge, as a part
    of all pixels there."""

    detail: float
    noise: float


@attrs.frozen(eq=False)
class EdgeTrial:
    """Both operators on a chart with that noise.

    adaptive: at its one setting.  plain: at every one of THRESHOLDS.  matched: index of the threshold at which the
    plain operator first shows no more noise than the adaptive one.  detail (2, levels, contrasts): the part of the
    edges that the adaptive and the matched plain operator show.
    """

    noise: float
    chart: Chart
    adaptive_map: BoolArray
    plain_map: BoolArray
    adaptive: Quality
    plain: tuple[Quality, ...]
    matched: int
    detail: FloatArray


def plain_sobel(smoothed: PixelArray) -> FloatArray:
    """Magnitude (h, w) of the gradient by the 3 x 3 Sobel operator, in grey levels of a sharp step, as the core counts
    it after its smoothing."""
    gx, gy = (cv2.Sobel(smoothed, cv2.CV_64F, dx, dy, ksize=3) for dx, dy in ((1, 0), (0, 1)))
    magnitude: FloatArray = np.hypot(gx, gy) / _MAGNITUDE_PER_STEP
    return magnitude


def adaptive_edges(core: Core, image: PixelArray) -> BoolArray:
    """The core's edge map (h, w) before thinning and without the filter of false edges."""
    bits, _ = core.detect_edges(0, core.smooth(0, image))
    return unpack_edges(bits, image.shape[1])


def compare_edges(core: Core, *, seed: int = 1) -> tuple[EdgeTrial, ...]:
    """Both operators on charts of the size of the core's images, one for each of NOISES, after the same smoothing."""
    return tuple(_trial(core, noise, seed) for noise in NOISES)


def _trial(core: Core, noise: float, seed: int) -> EdgeTrial:
    chart = draw_chart(core.width, core.height, noise, seed)
    adaptive_map = adaptive_edges(core, chart.image)
    magnitude = plain_sobel(core.smooth(0, chart.image))
    adaptive = quality(chart, adaptive_map)
    plain = tuple(quality(chart, magnitude >= threshold) for threshold in THRESHOLDS)
    as_quiet = [index for index, one in enumerate(plain) if one.noise <= adaptive.noise]
    matched = as_quiet[0] if as_quiet else len(plain) - 1
    plain_map = magnitude >= THRESHOLDS[matched]
    return EdgeTrial(
        noise=noise,
        chart=chart,
        adaptive_map=adaptive_map,
        plain_map=plain_map,
        adaptive=adaptive,
        plain=plain,
        matched=matched,
        detail=np.stack([detail_by_kind(chart, edges) for edges in (adaptive_map, plain_map)]),
    )


def quality(chart: Chart, edges: BoolArray) -> Quality:
    """Of an edge map (h, w) of the chart."""
    empty = chart.distance > _EMPTY_PX
    return Quality(float(_found(chart, edges).mean()), float(edges[empty].mean()))


def detail_by_kind(chart: Chart, edges: BoolArray) -> FloatArray:
    """Part of the edges that a map (h, w) shows, by level and contrast (levels, contrasts)."""
    found = _found(chart, edges)
    levels, contrasts = np.unique(chart.level), np.unique(chart.contrast)
    return np.array([[found[(chart.level == a) & (chart.contrast == c)].mean() for c in contrasts] for a in levels])


def _found(chart: Chart, edges: BoolArray) -> BoolArray:
    """Which of the chart's places (n,) have an edge pixel beside them."""
    away = cv2.distanceTransform((~edges).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    x, y = np.round(chart.places).astype(np.int64).T
    found: BoolArray = away[y, x] <= _FOUND_PX
    return found
