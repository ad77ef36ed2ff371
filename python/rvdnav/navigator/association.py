"""Which candidate line is which edge: the associations that agree with one pose, by a beam search.

Every edge is either one of its candidates or not found.  Edge by edge a hypothesis takes up a candidate and moves its
pose by a Kalman update, so that what it takes must be jointly compatible (J. Neira and J. D. Tardos, "Data association
in stochastic mapping using the joint compatibility test", 2001); the likeliest are followed (D. B. Reid, "An algorithm
for tracking multiple targets", 1979).
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from rvdnav.navigator.candidates import EdgeCandidates
from rvdnav.pose import PredictedPose, perturb
from rvdnav.pose.arrays import FloatArray, IntArray

_BEAM = 400
# Hypotheses this much less likely than the best are given up, as logarithms.
_GIVE_UP = 25.0
# Of a peak of Hough space: offset and, at the ends of the edge, tilt, px.
_OFFSET_SIGMA_PX = 0.8
_TILT_SIGMA_PX = 1.0
# How much of the window's half-width the projection bends beyond its derivative.
_BEND = 0.04
_GATE = 16.0
_DETECTED = 0.9
# Poses that move no end of an edge by more than this, px, are one.
_DISTINCT_PX = 3.0


@attrs.frozen(eq=False)
class Association:
    """A pose with the lines that it was made of.

    T_world_target (4, 4).  chosen (g,): candidate of each edge in the order given, -1 for none.  log_likelihood: up to
    a constant that all associations of a frame share.  half_rho: half-width of the widest window, px.
    """

    T_world_target: FloatArray
    chosen: IntArray
    log_likelihood: float
    half_rho: float


def associate(prediction: PredictedPose, candidates: list[EdgeCandidates], most: int) -> list[Association]:
    """The likeliest associations, at most so many, whose poses differ; the likeliest first."""
    order = sorted(range(len(candidates)), key=lambda g: -candidates[g].length)
    delta = np.zeros((1, 6))
    covariance = prediction.covariance[None]
    score = np.zeros(1)
    chosen = np.full((1, len(candidates)), -1, np.int64)
    for g in order:
        edge = candidates[g]
        if len(edge.rho) == 0:
            continue
        d, S, gain = _innovations(delta, covariance, edge)
        squares = np.einsum("bck,bkl,bcl->bc", d, np.linalg.inv(S), d)
        reward = _reward(edge) - 0.5 * np.log(np.linalg.det(S))[:, None] - 0.5 * squares
        taken = np.where(squares < _GATE, score[:, None] + reward, -np.inf)
        scores = np.concatenate([score[:, None] + math.log(1.0 - _DETECTED), taken], axis=1)
        best = np.argsort(-scores, axis=None, kind="stable")[:_BEAM]
        best = best[scores.ravel()[best] > scores.max() - _GIVE_UP]
        parent, candidate = best // scores.shape[1], best % scores.shape[1] - 1
        found = candidate >= 0
        step = np.einsum("bik,bk->bi", gain[parent], d[parent, candidate])
        delta = delta[parent] + np.where(found[:, None], step, 0.0)
        reduction = np.einsum("bik,bkl,bjl->bij", gain, S, gain)
        covariance = covariance[parent] - np.where(found[:, None, None], reduction[parent], 0.0)
        score = scores.ravel()[best]
        chosen = chosen[parent]
        chosen[:, g] = candidate
    return _distinct(prediction, candidates, delta, score, chosen, most)


def _innovations(
    delta: FloatArray, covariance: FloatArray, edge: EdgeCandidates
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Of b hypotheses and c candidates: innovations (b, c, 2), their covariances (b, 2, 2) and gains (b, 6, 2)."""
    J = edge.across
    offset = _OFFSET_SIGMA_PX**2 + (_BEND * edge.half_rho) ** 2
    tilt = _TILT_SIGMA_PX**2
    noise = np.array([[offset + tilt, offset - tilt], [offset - tilt, offset + tilt]])
    d = edge.offset[None] - (delta @ J.T)[:, None]
    PJ = np.einsum("bij,kj->bik", covariance, J)
    S = np.einsum("ki,bil->bkl", J, PJ) + noise
    return d, S, PJ @ np.linalg.inv(S)


def _reward(edge: EdgeCandidates) -> FloatArray:
    """Logarithm (c,) of what speaks for a candidate but its place: it must be found among the window's others, and the
    more of the edge it covers the likelier it is the edge rather than a print."""
    density = (len(edge.rho) + 1.0) / (2.0 * edge.half_rho) ** 2
    covering = np.log(2.0 * np.maximum(edge.support, 0.05))
    reward: FloatArray = math.log(_DETECTED / (2.0 * math.pi * density)) + covering
    return reward


def _distinct(
    prediction: PredictedPose,
    candidates: list[EdgeCandidates],
    delta: FloatArray,
    score: FloatArray,
    chosen: IntArray,
    most: int,
) -> list[Association]:
    J = np.concatenate([edge.across for edge in candidates]) if candidates else np.zeros((0, 6))
    moved = delta @ J.T
    kept: list[int] = []
    for b in np.argsort(-score, kind="stable"):
        if all(np.abs(moved[b] - moved[k]).max(initial=0.0) > _DISTINCT_PX for k in kept):
            kept.append(int(b))
        if len(kept) == most:
            break
    widest = max((edge.half_rho for edge in candidates), default=0.0)
    return [Association(perturb(prediction.T_world_target, delta[b]), chosen[b], float(score[b]), widest) for b in kept]
