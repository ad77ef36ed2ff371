"""Straight lines through the samples of each edge: robust fits that tell an edge's own scatter from its outliers."""

from __future__ import annotations

import numpy as np
from attrs import frozen

from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray

_ROUNDS = 8
_TUKEY = 4.685
_SCALE_FLOOR_PX = 0.05
_MIN_SAMPLES = 5
# Neighbouring profiles share pixels, so they know less than independent ones would, by this factor in variance at
# least; those before an uneven background share more, which their residuals tell: up to this correlation.
_CORRELATION = 2.0
_LARGEST_CORRELATION = 0.9


@frozen(eq=False)
class EdgeLines:
    """One fitted line an edge and camera; arrays of one length m, in the order of (camera, edge).

    camera, edge (m,).  rho (m,) px, theta (m,) rad: x cos(theta) + y sin(theta) = rho in rectified px; theta is that of
    the samples' normals.  cov (m, 2, 2): of (rho, theta) from the scatter about the line.  rms (m,) px.
    weights (n,): of the samples they came from, 0 for outliers and for edges without a line.
    """

    camera: IntArray
    edge: IntArray
    rho: FloatArray
    theta: FloatArray
    cov: FloatArray
    rms: FloatArray
    weights: FloatArray


def fit_edge_lines(camera: IntArray, edge: IntArray, q: FloatArray, n: FloatArray, sigma: FloatArray) -> EdgeLines:
    """Lines through image points q (k, 2) with normals n (k, 2) and standard deviations sigma (k,), px.

    The samples of an edge come in their order along it: how alike neighbours are tells how many are independent.
    The normals of an edge in a camera are equal up to small angles.  There is one line an edge and camera: a
    least-squares fit across the first normal of its edge, reweighted by Tukey's loss with a scale of its own; edges
    with too few agreeing samples are left out.
    """
    if len(camera) == 0:
        none = np.zeros(0)
        return EdgeLines(camera, edge, none, none, np.zeros((0, 2, 2)), none, none)
    keys, first, group, count = np.unique(
        camera * (edge.max() + 1) + edge, return_index=True, return_inverse=True, return_counts=True
    )
    normal = n[first]
    # A row a line; its samples in the first places, the rest without weight.
    order = np.argsort(group, kind="stable")
    place = np.empty(len(group), np.int64)
    place[order] = np.arange(len(group)) - np.repeat(np.cumsum(count) - count, count)
    table = np.zeros((3, len(keys), count.max()))
    table[:, group, place] = [q[:, 0], q[:, 1], sigma]
    present = np.arange(count.max()) < count[:, None]
    centre = table[:2].sum(axis=2) / count
    d = np.where(present, table[:2] - centre[:, :, None], 0.0)
    # Across and along the edge, from its samples' mean.
    across = normal[:, 0, None] * d[0] + normal[:, 1, None] * d[1]
    along = normal[:, 0, None] * d[1] - normal[:, 1, None] * d[0]
    noise = table[2] ** 2
    offset = _medians(across, present, count)
    slope = np.zeros(len(keys))
    for _ in range(_ROUNDS):
        residual = across - offset[:, None] - slope[:, None] * along
        scale = np.maximum(1.4826 * _medians(np.abs(residual), present, count), _SCALE_FLOOR_PX)[:, None]
        tukey = np.where(present, np.maximum(1.0 - (residual / (_TUKEY * scale)) ** 2, 0.0) ** 2, 0.0)
        # Beyond its share of the scatter a profile's own sigma tells how much it knows.
        w = tukey / (noise + scale**2)
        wt, wy = w * along, w * across
        s0, s1, s2 = w.sum(axis=1), wt.sum(axis=1), (wt * along).sum(axis=1)
        y0, y1 = wy.sum(axis=1), (wy * along).sum(axis=1)
        det = s0 * s2 - s1 * s1
        fit = det > 1e-9 * s0 * s2
        safe = np.where(fit, det, 1.0)
        offset = np.where(fit, (s2 * y0 - s1 * y1) / safe, offset)
        slope = np.where(fit, (s0 * y1 - s1 * y0) / safe, 0.0)
    residual = across - offset[:, None] - slope[:, None] * along
    agreeing = (tukey > 0.1).sum(axis=1).astype(np.float64)
    unit = (w * residual**2).sum(axis=1) / np.maximum(agreeing - 2.0, 1.0) * agreeing / np.maximum(s0, 1e-300)
    variance = np.maximum(unit, _SCALE_FLOOR_PX**2 / 4.0) * _shared(residual, tukey, agreeing)
    information = s0 / np.maximum(agreeing, 1.0)
    # Var of (offset, slope) = variance * information * [[s2, -s1], [-s1, s0]] / det, turned into (rho, theta).
    factor = variance * information / safe
    theta = np.arctan2(normal[:, 1], normal[:, 0]) - np.arctan(slope)
    c, s = np.cos(theta), np.sin(theta)
    anchor = centre.T + offset[:, None] * normal
    rho = c * anchor[:, 0] + s * anchor[:, 1]
    middle = anchor[:, 1] * c - anchor[:, 0] * s
    cov = np.empty((len(keys), 2, 2))
    cov[:, 0, 0] = factor * (s2 + 2.0 * middle * s1 + middle**2 * s0)
    cov[:, 0, 1] = cov[:, 1, 0] = factor * (s1 + middle * s0)
    cov[:, 1, 1] = factor * s0
    kept: BoolArray = fit & (agreeing >= _MIN_SAMPLES)
    rms = np.sqrt((tukey * residual**2).sum(axis=1) / np.maximum(tukey.sum(axis=1), 1e-300))
    return EdgeLines(
        camera[first][kept],
        edge[first][kept],
        rho[kept],
        theta[kept],
        cov[kept],
        rms[kept],
        np.where(kept[group], tukey[group, place], 0.0),
    )


def _shared(residual: FloatArray, weight: FloatArray, count: FloatArray) -> FloatArray:
    """By which factor each row's fit varies more than one of as many (count) independent residuals would.

    From the correlation r of neighbours, as if it fell off by r from each to the next, (1 + r) / (1 - r); a line
    through few residuals takes some of the correlation upon itself (M. G. Kendall, "Note on bias
    in the estimation of autocorrelation", 1954).
    """
    both = weight[:, 1:] * weight[:, :-1]
    product = (both * residual[:, 1:] * residual[:, :-1]).sum(axis=1)
    square = 0.5 * (both * (residual[:, 1:] ** 2 + residual[:, :-1] ** 2)).sum(axis=1)
    count = np.maximum(count, 2.0 * _MIN_SAMPLES)
    correlation = (count * product / np.maximum(square, 1e-300) + 2.0) / (count - 4.0)
    correlation = np.clip(correlation, 0.0, _LARGEST_CORRELATION)
    factor: FloatArray = np.maximum((1.0 + correlation) / (1.0 - correlation), _CORRELATION)
    return factor


def _medians(values: FloatArray, present: BoolArray, count: IntArray) -> FloatArray:
    """Of each row's present values."""
    ordered = np.sort(np.where(present, values, np.inf), axis=1)
    row = np.arange(len(count))
    median: FloatArray = 0.5 * (ordered[row, (count - 1) // 2] + ordered[row, count // 2])
    return median
