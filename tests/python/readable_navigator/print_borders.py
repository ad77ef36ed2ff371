"""Steps beside an edge that may be the edge instead: a print's border within a few pixels of it.

Between two steps of the same polarity, or before one of the other, the grey values must step back.  Where they do so
all along an edge and within reach of its profiles, the wrong step may have been measured.
"""

from __future__ import annotations

import numpy as np
from rvdnav.core import Core
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.navigator.views import Images
from rvdnav.pose import EdgeLines, LineMeasurements, fit_edge_lines, line_residuals
from rvdnav.pose.arrays import FloatArray
from rvdnav.rig import Rig

from readable_navigator.sampling import SampledEdges, sample_edges

_HALF_WIDTH_PX = 3.5
# Of the profiles that must show the step back, and how straight, px.
_COVERED = 0.35
_STRAIGHT_PX = 0.7
_AGREEING = 0.1


def border_separation(
    core: Core,
    rig: Rig,
    images: Images,
    model: EdgeModel,
    T_world_target: FloatArray,
    sampled: SampledEdges,
    fits: EdgeLines,
) -> FloatArray:
    """Distance (k,), px, from each fitted line to a line of opposite polarity next to it; 0 where there is none."""
    total = np.zeros(sampled.attempted.shape)
    np.add.at(total, (sampled.camera, sampled.edge), fits.weights * sampled.polarity)
    opposite = -np.sign(total).astype(np.int64)
    back = sample_edges(core, rig, images, T_world_target, model, _HALF_WIDTH_PX, opposite)
    lines = fit_edge_lines(back.camera, back.edge, back.q, back.n, back.sigma)
    agreed = back.count(lines.weights > _AGREEING)
    covered = agreed[lines.camera, lines.edge] >= _COVERED * back.attempted[lines.camera, lines.edge]
    shown = covered & (lines.rms < _STRAIGHT_PX) & (opposite[lines.camera, lines.edge] != 0)
    offset = np.full(total.shape, np.nan)
    offset[lines.camera[shown], lines.edge[shown]] = _offsets(rig, T_world_target, sampled, lines)[shown]
    between = np.abs(offset[fits.camera, fits.edge] - _offsets(rig, T_world_target, sampled, fits))
    separation: FloatArray = np.nan_to_num(between, nan=0.0)
    return separation


def _offsets(rig: Rig, T_world_target: FloatArray, sampled: SampledEdges, fits: EdgeLines) -> FloatArray:
    """Mean distance of the projected ends to each line (k,), px."""
    endpoints = sampled.spans[fits.camera, fits.edge]
    lines = LineMeasurements(fits.camera, fits.edge, endpoints, fits.rho, fits.theta, fits.cov)
    mean: FloatArray = line_residuals(T_world_target, lines, rectified_cameras(rig))[0].mean(axis=1)
    return mean
