"""What a frame's lines share, and what a refined frame tells of it."""

from __future__ import annotations

import numpy as np
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.faces import blur_excess
from rvdnav.navigator.knowledge import TARGET, Knowledge, Learned
from rvdnav.pose import LineMeasurements, RefinedPose
from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray
from rvdnav.pose.systematics import Systematics

from readable_navigator.shutter import MeasuredShutter

# By how much a step is displaced towards its dark side, as a part of its blur: sharpening, a response that bends.
_STEP_PART = 0.015
# By how much an edge is displaced in all views alike, px, by what lies beside it: of a sharp image, and as a part of
# the blur beyond that.
_EDGE_SIGMA_PX = 0.007
_EDGE_PART = 0.06
# Of the tolerance of a point, what all of them have in common.
_COMMON_PART = 0.5


def frame_systematics(
    knowledge: Knowledge,
    model: EdgeModel,
    T_world_target: FloatArray,
    lines: LineMeasurements,
    polarity: IntArray,
    blur: FloatArray,
    learned: Learned,
    shutter: MeasuredShutter | None = None,
) -> Systematics:
    """Of lines near a pose (4, 4); polarity (n,): +1 brighter towards a line's normal, -1 darker, 0 unknown.

    blur (cameras, edges): standard deviation of the steps' blur, px.
    Raises PoseError for an edge that is not in front of its camera.
    """
    row = np.arange(len(lines))
    own = blur[lines.camera, lines.edge]
    steps = np.zeros((len(lines), 2, len(blur)))
    steps[row, :, lines.camera] = -(_STEP_PART * own * polarity)[:, None]
    edges = np.zeros((len(lines), 2, len(model)))
    edges[row, :, lines.edge] = -np.hypot(_EDGE_SIGMA_PX, _EDGE_PART * blur_excess(own))[:, None]
    moved = np.zeros((len(lines), 2, 0)) if shutter is None else shutter.by_motion(T_world_target, lines)
    derivative = np.concatenate([knowledge.derivative(T_world_target, lines), steps, edges, moved], axis=2)
    return knowledge.systematics(derivative, learned)


def common_covariance(model: EdgeModel, pose: RefinedPose) -> FloatArray:
    """(6, 6) by what errs in all points alike, as where their lengths were measured from one end: no line shows it."""
    covariance = np.zeros((6, 6))
    uncertain = model.point_sigmas[model.point_sigmas > 0.0]
    if len(uncertain) > 0:
        variance = float(np.mean(uncertain**2)) * pose.scales[TARGET] ** 2
        covariance[:3, :3] = _COMMON_PART**2 * variance * np.eye(3)
    return covariance


def own_covariance(knowledge: Knowledge, pose: RefinedPose, systematics: Systematics) -> FloatArray:
    """(6, 6) of a refined pose by what is this frame's own, and by what it changed of the lasting parameters."""
    lasting = slice(6, 6 + knowledge.lasting)
    free = np.ones(6 + len(pose.z), np.bool_)
    free[lasting] = False
    information = pose.told.information.copy()
    information[6:, 6:] += systematics.prior_information
    own = np.linalg.inv(information[np.ix_(free, free)])
    by_lasting = -(own @ information[np.ix_(free, ~free)])[:6]
    prior = np.linalg.inv(systematics.prior_information[: knowledge.lasting, : knowledge.lasting])
    change = prior - np.linalg.inv(information)[lasting, lasting]
    covariance = own[:6, :6] + by_lasting @ change @ by_lasting.T
    symmetric: FloatArray = 0.5 * (covariance + covariance.T)
    return symmetric


def taught(knowledge: Knowledge, learned: Learned, pose: RefinedPose, systematics: Systematics) -> Learned:
    """With what a refined pose's lines add."""
    lasting: BoolArray = np.arange(len(pose.z)) < knowledge.lasting
    scales = pose.scales[systematics.members]
    return learned.with_frame(*pose.told.of_parameters(lasting, 1.0 / scales**2), pose.scales)
