"""The two poses that one view of a planar target leaves: the true one and nearly its mirror image.

A plane tilted one way looks almost as if it were tilted the other way about the line of sight; only perspective tells,
and near a frontal view it tells little (D. Oberkampf, D. DeMenthon, L. Davis, "Iterative pose estimation using coplanar
feature points", 1996).  Both minima are found here, weighed by their residuals and by what was known before, and the
weight that is left to the rival widens the covariance.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.measurement import Measurement
from rvdnav.navigator.one_view import one_view_pose
from rvdnav.pose import (
    PoseError,
    PredictedPose,
    RectifiedCameras,
    RefinedPose,
    difference,
    exp,
    make_T,
)
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.refined import redundancy

# Two minima nearer than this, in standard deviations, are one.
_ONE_MINIMUM = 1.0
# Residuals that edges of one bar share count once rather than twice.
_SHARED = 0.5
# How far a pose may lie from the prediction, as a squared Mahalanobis distance, until the target has rather moved in a
# way that no prediction foresaw.
_FORESEEN = 25.0
# Odds beyond which nothing more is learnt, as their logarithm.
_MAX_LOG_ODDS = 50.0
# A rival with less than this probability is not worth a word.
_NEGLIGIBLE = 1e-4
_FLATNESS = 1e-3


@attrs.frozen(eq=False)
class Decision:
    """Between a pose and its rival.

    T_world_target (4, 4): the likelier one.  rival (4, 4): the other one, or None where there is none to speak of.
    rival_probability: of the rival.  log_odds: what this frame and all before it say for the chosen one.
    swapped: the chosen one is not the one that was measured, so the edges must be measured anew around it.
    """

    T_world_target: FloatArray
    rival: FloatArray | None
    rival_probability: float
    log_odds: float
    swapped: bool

    def widened(self, measurement: Measurement) -> Measurement:
        """The measurement with a covariance that holds both poses, each with its probability."""
        if self.rival is None:
            return measurement
        apart = difference(self.rival, measurement.pose.T_world_target)
        covariance = measurement.pose.covariance + self.rival_probability * np.outer(apart, apart)
        pose = attrs.evolve(measurement.pose, covariance=covariance)
        return attrs.evolve(measurement, pose=pose, rival=self.rival, log_odds=self.log_odds)


def _no_rival(measurement: Measurement) -> Decision:
    return Decision(measurement.pose.T_world_target, None, 0.0, _MAX_LOG_ODDS, swapped=False)


def decide(
    measurement: Measurement,
    model: EdgeModel,
    cameras: RectifiedCameras,
    prediction: PredictedPose | None,
    earlier_odds: float | None,
) -> Decision:
    """Whether the measured pose of a frame with one view or its mirror image is the true one.

    prediction: of the target, None where nothing is known.  earlier_odds: logarithm of the odds that earlier frames
    give the prediction's side where they could not decide; None if they did, and the prediction's covariance tells the
    two apart.  A target whose edges lie in no plane has no such rival.
    """
    T, lines = measurement.pose.T_world_target, measurement.lines
    # Of a solid only what is seen counts: one face of a box is as flat as a panel.
    points = model.edge_points if _is_planar(model.edge_points) else lines.endpoints_C
    if not _is_planar(points):
        return _no_rival(measurement)
    camera = int(lines.camera[0])
    try:
        shown = measurement.pose.displacement_px
        own = one_view_pose(T, lines, cameras, measurement.systematics, shown)
        mirrored = _mirrored(T, points, cameras.centers[camera])
        other = one_view_pose(mirrored, lines, cameras, measurement.systematics, shown)
    except PoseError:
        return _no_rival(measurement)
    apart = difference(other.T_world_target, own.T_world_target)
    if float(apart @ np.linalg.solve(own.covariance, apart)) < _ONE_MINIMUM**2:
        return _no_rival(measurement)
    # Squares in units of the better fit's own scatter, where that is more than was expected.
    unit = max(1.0, min(own.sigma0, other.sigma0) ** 2)
    log_odds = 0.5 * _SHARED * (_squares(other) - _squares(own)) / unit
    if prediction is not None:
        for_own = _foreseen(own, prediction) - _foreseen(other, prediction)
        log_odds += for_own if earlier_odds is None else _both(for_own, earlier_odds)
    log_odds = float(np.clip(log_odds, -_MAX_LOG_ODDS, _MAX_LOG_ODDS))
    swapped = log_odds < 0.0
    chosen, rival = (other, own) if swapped else (own, other)
    probability = 1.0 / (1.0 + math.exp(abs(log_odds)))
    return Decision(
        chosen.T_world_target,
        rival.T_world_target if probability > _NEGLIGIBLE else None,
        probability,
        abs(log_odds),
        swapped,
    )


def _squares(pose: RefinedPose) -> float:
    """Sum of the weighted squares of the whitened residuals."""
    return pose.sigma0**2 * redundancy(pose.weights)


def _both(a: float, b: float) -> float:
    """Logarithm of the odds that both or neither of two things hold, from each one's; less than the smaller of them."""
    return float(np.logaddexp(a + b, 0.0) - np.logaddexp(a, b))


def _foreseen(pose: RefinedPose, prediction: PredictedPose) -> float:
    """Logarithm of how likely the prediction makes a pose; what it did not foresee is as likely as anything else."""
    error = difference(pose.T_world_target, prediction.T_world_target)
    squared = float(error @ np.linalg.solve(pose.covariance + prediction.covariance, error))
    return float(np.logaddexp(-0.5 * squared, -0.5 * _FORESEEN))


def _is_planar(edge_points: FloatArray) -> bool:
    points = edge_points.reshape(-1, 3)
    extents = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(extents[2] < _FLATNESS * extents[1])


def _mirrored(T: FloatArray, edge_points: FloatArray, eye_W: FloatArray) -> FloatArray:
    """The pose at which the plane of edges (m, 2, 3) is tilted the opposite way about the line of sight from eye_W (3,)
    to its middle."""
    points = edge_points.reshape(-1, 3)
    middle_C = points.mean(axis=0)
    normal = T[:3, :3] @ np.linalg.svd(points - middle_C)[2][2]
    middle_W = T[:3, :3] @ middle_C + T[:3, 3]
    sight = (middle_W - eye_W) / np.linalg.norm(middle_W - eye_W)
    if normal @ sight < 0.0:
        normal = -normal
    axis = np.cross(normal, sight)
    sine = float(np.linalg.norm(axis))
    if sine < 1e-9:
        raise PoseError("the target is seen exactly from the front")
    # Twice the angle between normal and sight, beyond the sight to the other side.
    turn = exp(2.0 * math.atan2(sine, float(normal @ sight)) * axis / sine)
    R = turn @ T[:3, :3]
    return make_T(R, middle_W - R @ middle_C)
