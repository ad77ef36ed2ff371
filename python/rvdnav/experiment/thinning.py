"""The core's thinning against the usual one, of T. Y. Zhang and C. Y. Suen (1984), as scikit-image has it."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from rvdnav.core import Core, unpack_edges
from rvdnav.experiment.chart import Chart
from rvdnav.extras import needs_extra
from rvdnav.pose.arrays import BoolArray

_REPEATS = 7
_NEAR_PX = 4.0


@attrs.frozen(eq=False)
class Thinning:
    """What a thinning makes of an edge map.

    edges (h, w): what is left.  pixels: their number.  thick: 2 x 2 blocks of edge pixels, where the edge is not one
    pixel wide.  components: of connected edges, before and after.  offset_px: RMS distance of the pixels beside true
    edges from them.  seconds: median time.
    """

    name: str
    edges: BoolArray
    pixels: int
    thick: int
    components: tuple[int, int]
    offset_px: float
    seconds: float


def compare_thinning(core: Core, chart: Chart, edges: BoolArray) -> tuple[Thinning, Thinning]:
    """The core's thinning and the usual one on the same map (h, w) of a chart.

    Raises InputError without scikit-image.
    """
    with needs_extra("experiment", "the comparison of thinnings"):
        from skimage.morphology import skeletonize
    bits = pack_edges(edges)
    usual: Callable[[BoolArray], Any] = skeletonize
    return (
        _judged("rvdnav", edges, chart, lambda: core.thin(0, bits), lambda out: unpack_edges(out, edges.shape[1])),
        _judged("Zhang-Suen", edges, chart, lambda: usual(edges), lambda out: np.asarray(out, np.bool_)),
    )


def pack_edges(edges: BoolArray) -> NDArray[np.uint32]:
    """A mask (h, w) as the core's packed edge bits (h, words)."""
    height, width = edges.shape
    octets = np.zeros((height, -(-width // 32) * 4), np.uint8)
    packed = np.packbits(edges, axis=1, bitorder="little")
    octets[:, : packed.shape[1]] = packed
    return octets.view("<u4")


def _judged(
    name: str, before: BoolArray, chart: Chart, work: Callable[[], Any], unpack: Callable[[Any], BoolArray]
) -> Thinning:
    seconds = []
    for _ in range(_REPEATS):
        start = time.perf_counter()
        out = work()
        seconds.append(time.perf_counter() - start)
    edges = unpack(out)
    near = chart.distance[edges]
    near = near[near < _NEAR_PX]
    return Thinning(
        name=name,
        edges=edges,
        pixels=int(edges.sum()),
        thick=int((edges[1:, 1:] & edges[1:, :-1] & edges[:-1, 1:] & edges[:-1, :-1]).sum()),
        components=(_components(before), _components(edges)),
        offset_px=float(np.sqrt(np.mean(near**2))) if near.size else float("nan"),
        seconds=float(np.median(seconds)),
    )


def _components(edges: BoolArray) -> int:
    return int(cv2.connectedComponents(edges.astype(np.uint8), connectivity=8)[0]) - 1
