"""Blur and slopes of the grey values that the samples of edges show."""

from __future__ import annotations

import attrs
import numpy as np
from rvdnav.pose.arrays import BoolArray, FloatArray

from readable_navigator.sampling import SampledEdges

# Slope of the grey beside a step, parts of its contrast a pixel, that the model of the blur itself leaves.
_SLOPE_SIGMA = 0.02
# Samples from which an edge may have a blur of its own, and by which part it must differ from its view's: within the
# spread that the fit of a step allows for anyway, the difference is noise, and displaces the step.
_MIN_BLURS = 12
_OWN_BLUR = 0.3


def edge_blur(sampled: SampledEdges, agreeing: BoolArray, expected: FloatArray) -> FloatArray:
    """(cameras, edges) blur, px, that the agreeing samples (n,) show: of an edge the median of its own where that is
    clearly another than its view's, for motion blurs along itself alone; else the median of its view; the expected
    (cameras, edges) where there are none.
    """
    blur: FloatArray = expected.copy()
    own = sampled.medians(sampled.blur, agreeing)
    enough = sampled.count(agreeing) >= _MIN_BLURS
    for camera in range(len(blur)):
        chosen = agreeing & (sampled.camera == camera)
        if not chosen.any():
            continue
        of_view = float(np.median(sampled.blur[chosen]))
        apart = enough[camera] & (np.abs(own[camera] / of_view - 1.0) > _OWN_BLUR)
        blur[camera] = np.where(apart, own[camera], of_view)
    return blur


def with_slopes(sampled: SampledEdges) -> tuple[SampledEdges, FloatArray]:
    """The samples where their steps stand once the slopes beside them are allowed for, as far as an edge shows any.

    A slope that a single profile shows may be noise, and a small one the remains of the blur's model; one that
    is seen all along an edge is there.  Returned too: by how much (cameras, edges), px, each edge moved in the middle.
    """
    slope = sampled.medians(sampled.slope)
    part = slope**4 / (slope**4 + _SLOPE_SIGMA**4)
    moved: FloatArray = np.nan_to_num(np.abs(part * sampled.medians(sampled.slope_shift)))
    shift = part[sampled.camera, sampled.edge] * sampled.slope_shift
    return attrs.evolve(sampled, q=sampled.q + shift[:, None] * sampled.n), moved
