"""Whether a measurement may be published: the gates, each with its reason."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rvdnav.core import FrameResult
from rvdnav.corrections import Corrections
from rvdnav.navigator.agreement import disparity_errors, view_difference
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.faces import blur_excess
from rvdnav.navigator.knowledge import Knowledge
from rvdnav.navigator.measurement import Measurement
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.pose import PredictedPose, difference
from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray
from rvdnav.pose.loss import Loss
from rvdnav.pose.refined import weighted_rms
from rvdnav.rig import Rig
from rvdnav.solution import Reason

_MIN_MATCHES = 3
# Profiles on the image from which an edge is expected to be shown.
_MIN_PROFILES = 8
# Part of the edges that a view holds which it must show.
_SHOWN_PART = 0.6
# Of a bar: two edges in two views.
_EDGE_IMAGES = 4
# Of the polarities of the eight edges, outer and inner in turn: +1 where the bar is lighter than what is beside it.
_INWARDS = np.tile([1, -1], 4)
_SHIFT_PX = 0.1
_MIN_EDGE_IMAGES = 4
# Part of all profiles by which a target is wholly shown; which one view by itself must show of a bracket, and of an
# edge that alone stands for a bar: a rod or a shadow beside one agrees with less (soak on the approach, blurred views
# of the tumbling and the sunlit scenario: wrong ones 0.63 to 0.72 and 0.46, right ones from 0.68 and 0.68).
_WHOLLY_SHOWN = 0.9
_SHOWN_ALONE = 2.0 / 3.0
_HALF_SHOWN = 0.5
# Of any target's edges, and of all their profiles: with the borders of prints a solid can look like a smaller one.
_MOST_EDGES = 0.7
_MOST_PROFILES = 0.6
# How many times larger than stated the errors of a group must seem, or the correction of a combination in stated
# standard deviations, before the statement itself is doubted.  Of groups as stated of which the images tell 4 or more
# parameters one in 10^3 (target) and 10^5 (calibration) or fewer seems so large, for a chi-square of as many degrees of
# freedom.  A target's combinations are many, and what displaces single edges looks like errors of its points.
_DOUBTED_SCALE = 2.0
_DOUBTED_SIGMAS = {Reason.TARGET_TOLERANCE: 5.0, Reason.CALIBRATION: 4.0}


def failed_gates(
    measurement: Measurement,
    model: EdgeModel,
    frame: FrameResult,
    rig: Rig,
    knowledge: Knowledge,
    settings: NavigatorSettings,
    config: Any,
) -> frozenset[Reason]:
    """What speaks against publishing the measurement by itself; empty if nothing does.  config: the core's."""
    reasons = set()
    pose = measurement.pose
    acquired = frame.bracket is not None
    if not _enough_shown(measurement, model, settings, acquired):
        reasons.add(Reason.TOO_FEW_LINES)
    if not measurement.settled:
        reasons.add(Reason.NOT_CONVERGED)
    if _rms_px(measurement) > _largest_rms_px(measurement, model, rig, settings):
        reasons.add(Reason.RESIDUALS)
    views = len(measurement.cameras)
    if model.bracket is not None:
        front = measurement.coverage >= settings.edge_coverage
        # A bar beside itself is so in every view.
        if 2 * displaced_bars(front, measurement.polarity) >= views * settings.min_displaced_bars:
            reasons.add(Reason.DISPLACED)
        errors, sigmas = disparity_errors(frame.matches, pose, model.bracket, rig, knowledge)
        # Of faces without texture a few points are matched to something else: only most of them together contradict.
        astray = np.count_nonzero(np.abs(errors) > settings.max_disparity_px + settings.view_sigmas * sigmas)
        if len(errors) >= _MIN_MATCHES and 2 * astray > len(errors):
            reasons.add(Reason.CROSS_VIEW)
    # The surface between a bracket's edges is the bracket itself, while any target's may be printed with lines.
    loss: Loss = "tukey" if model.bracket is None else "huber"
    if views > 1 and view_difference(measurement, rig, loss) > settings.view_sigmas:
        reasons.add(Reason.CROSS_VIEW)
    distance = float(np.linalg.norm(pose.T_world_target[:3, 3]))
    # It bounds the search; what is tracked may come nearer or go farther, as long as its edges are in view.
    if acquired and not config.range_min <= distance <= config.range_max:
        reasons.add(Reason.RANGE_GATE)
    if too_uncertain(pose.covariance, distance, settings):
        # The rival's share widens the covariance; without it the pose by itself is sure enough.
        alone = measurement.rival is None or too_uncertain(measurement.own_covariance, distance, settings)
        reasons.add(Reason.COVARIANCE if alone else Reason.AMBIGUOUS)
    return frozenset(reasons)


def contradicted(corrections: Corrections | None) -> frozenset[Reason]:
    """What of the stated tolerances the images seem to contradict; a pose that passed the gates holds it and may be
    published."""
    if corrections is None:
        return frozenset()
    shown = {
        Reason.TARGET_TOLERANCE: (corrections.target_scale, corrections.target_distance),
        Reason.CALIBRATION: (corrections.calibration_scale, corrections.calibration_distance),
    }
    return frozenset(
        reason
        for reason, (scale, sigmas) in shown.items()
        if scale > _DOUBTED_SCALE or sigmas > _DOUBTED_SIGMAS[reason]
    )


def _largest_rms_px(measurement: Measurement, model: EdgeModel, rig: Rig, settings: NavigatorSettings) -> float:
    """What is known to a tolerance only, or seen blurred, may leave more of the edges than what is known exactly."""
    lines = measurement.lines
    pixel_m = float(np.linalg.norm(measurement.pose.T_world_target[:3, 3])) / rig.focal_rect
    tolerance = float(np.sqrt(np.mean(model.point_sigmas**2))) / pixel_m
    blur = float(np.median(blur_excess(measurement.blur[lines.camera, lines.edge])))
    parts = (settings.max_rms_px, settings.max_rms_tolerances * tolerance, settings.max_rms_blurs * blur)
    return float(np.linalg.norm(parts))


def too_far_apart(first: Measurement, second: Measurement, settings: NavigatorSettings) -> bool:
    """Whether what lies half way between two measurements, where the truth is at either, is off by more than three of
    the largest standard deviations."""
    apart = second.pose.T_world_target[:3, 3] - first.pose.T_world_target[:3, 3]
    return float(np.linalg.norm(apart)) > 6.0 * settings.max_position_sigma


def too_uncertain(covariance: FloatArray, distance: float, settings: NavigatorSettings) -> bool:
    """Whether the largest standard deviation in any direction exceeds its limit; distance, m."""
    position, attitude = (float(np.sqrt(np.linalg.eigvalsh(block)[-1])) for block in _blocks(covariance))
    return position > settings.max_position_sigma or attitude > settings.max_attitude_sigma * (1.0 + distance)


def _blocks(covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    return covariance[:3, :3], covariance[3:, 3:]


def _enough_shown(measurement: Measurement, model: EdgeModel, settings: NavigatorSettings, acquired: bool) -> bool:
    """Whether the images show enough of the target's edges where the pose puts them."""
    shown = (measurement.coverage >= settings.edge_coverage) | (measurement.back_coverage >= settings.edge_coverage)
    expected = measurement.attempted >= _MIN_PROFILES
    if model.bracket is None:
        enough = measurement.total_coverage >= max(settings.min_coverage, _MOST_PROFILES)
        return enough and most_shown(measurement.coverage, measurement.attempted, settings)
    # At close range parts of the target are beyond the images' borders: a view cannot show more than it holds.
    least = np.minimum(settings.min_edges, np.ceil(_SHOWN_PART * expected.sum(axis=1)))
    seen = measurement.seen
    if (shown.sum(axis=1) < least)[seen].any() or measurement.total_coverage < settings.min_coverage:
        return False
    if shown.any(axis=0).sum() < min(settings.min_edges, len(model)):
        return False
    # In one view nothing else contradicts a bracket that is nearer, and so larger, along two of its bars.
    alone = len(measurement.cameras) == 1
    if alone and measurement.total_coverage < _SHOWN_ALONE:
        return False
    least = settings.acquired_bar_edges if acquired or alone else settings.min_bar_edges
    if _every_bar_shown(shown, expected, least):
        return True
    if alone:
        shown &= measurement.coverage >= _HALF_SHOWN
    return _all_but_one_bar(shown, expected, measurement.polarity, settings)


def most_shown(coverage: FloatArray, attempted: IntArray, settings: NavigatorSettings) -> bool:
    """Whether the views together show most of the edges that they should, and each at least half of its own.

    coverage (cameras, edges): part of the attempted profiles, of the same shape, that agree with a pose.  What one view
    does not show of a rigid target the other one vouches for.  Three edges fit any three lines: without a fourth one
    nothing would contradict a wrong pose.
    """
    expected = attempted >= _MIN_PROFILES
    shown = (coverage >= settings.edge_coverage) & expected
    if (2 * shown.sum(axis=1) < expected.sum(axis=1)).any():
        return False
    return bool(shown.sum() >= max(_MIN_EDGE_IMAGES, np.ceil(_MOST_EDGES * expected.sum())))


def _every_bar_shown(shown: BoolArray, expected: BoolArray, least: int) -> bool:
    """Whether each bar is shown by enough of its two edges in the views that should see them; shown and expected
    (cameras, edges); least, of a bar's four edge images.  Without a bar the target's size in one direction goes
    unchecked: a wrong one passes for a tilt.
    """
    return bool(_shown_bars(shown, expected, least).all())


def _shown_bars(shown: BoolArray, expected: BoolArray, least: int) -> BoolArray:
    """(bars,) which of them are shown so."""
    wanted = _by_bar(expected).sum(axis=(0, 2))
    found = _by_bar(shown).sum(axis=(0, 2))
    # Fewer are asked for where one view alone, or a part of the bracket, is there to show them.
    enough: BoolArray = found >= np.ceil(wanted * least / _EDGE_IMAGES)
    return enough


def _all_but_one_bar(shown: BoolArray, expected: BoolArray, polarity: IntArray, settings: NavigatorSettings) -> bool:
    """Whether all bars but one are shown by enough edges, and those of that one have their light side where the other
    bars have it; polarity (cameras, edges), the others as above.

    A joint, a shadow or a background that blur mixes in may hide an edge in both views.  The others then vouch for the
    pose, the more of them the fewer are asked of that bar, and the light side tells that the bar's remaining edge isn't
    its other one, a bar's width off.
    """
    lacking = ~_shown_bars(shown, expected, settings.acquired_bar_edges)
    whole = (_by_bar(shown) | ~_by_bar(expected)).all(axis=(0, 2))
    least = 1 if whole[~lacking].all() else settings.min_bar_edges
    if lacking.sum() != 1 or not _every_bar_shown(shown, expected, least):
        return False
    lighter = _by_bar(polarity * _INWARDS)
    seen = _by_bar(shown)
    usual = np.sign(np.where(seen[:, ~lacking], lighter[:, ~lacking], 0).sum())
    # Before an uneven background an edge has either side lighter in turn, which speaks neither for it nor against it.
    remaining = lighter[:, lacking][seen[:, lacking]]
    return bool(usual != 0 and (remaining == usual).any() and (remaining != -usual).all())


def _by_bar(edges: NDArray[Any]) -> NDArray[Any]:
    """Values of edges (cameras, edges) as (cameras, bars, 2): outer and inner."""
    return edges.reshape(len(edges), -1, 2)


def displaced_bars(shown: BoolArray, polarity: IntArray) -> int:
    """How many bars in how many views look as if they were measured one bar's width beside themselves.

    shown (cameras, edges): edges that agree with the pose.  polarity (cameras, edges): as `Measurement.polarity`, which
    is +1 where it is brighter towards the inside of the frame, around which the edges run.  A pose that lies a bar's
    width off finds the outer edge of a bar where its inner one is, or the other way round: that edge's light side is on
    the wrong side, and the bar's other edge finds nothing.
    """
    lighter = _by_bar(polarity * _INWARDS)
    seen = _by_bar(shown)
    both = seen.all(axis=2)
    usual = np.sign(lighter[both].sum())
    alone = seen.sum(axis=2) == 1
    light = np.where(seen, lighter, 0).sum(axis=2)
    return int(np.count_nonzero(alone & (light == -usual) & (usual != 0)))


def _rms_px(measurement: Measurement) -> float:
    """RMS of the trusted lines' endpoints against the pose, px; lines that a side face may have moved count less."""
    pose = measurement.pose
    weights = pose.weights / (1.0 + (measurement.lines.shift_sigma / _SHIFT_PX) ** 2)
    return weighted_rms(pose.residuals, weights)


def plausible_motion(
    measurement: Measurement,
    acquired: bool,
    prediction: PredictedPose,
    lasting: FloatArray,
    seconds: float,
    settings: NavigatorSettings,
) -> bool:
    """Whether the target can have come from the prediction to the measured pose.

    That is within the prediction's and the measurement's covariance together; or, where the whole images were searched
    rather than the windows that the wrong prediction opened, within what the largest speeds allow in the seconds since
    the last pose.  One view by itself overrules a prediction only if it shows the whole target: a rod or a shadow can
    stand in for a bar.  lasting (6, 6): of what errs alike in all frames what doesn't cancel between the two.
    """
    error = difference(measurement.pose.T_world_target, prediction.T_world_target)
    alone = len(measurement.cameras) == 1
    covariance = prediction.covariance + measurement.own_covariance + lasting
    if float(error @ np.linalg.solve(covariance, error)) <= settings.motion_sigmas**2:
        return True
    if not acquired or (alone and measurement.total_coverage < _WHOLLY_SHOWN):
        return False
    slow = float(np.linalg.norm(error[:3])) <= settings.max_speed * seconds
    return slow and float(np.linalg.norm(error[3:])) <= settings.max_turn_rate * seconds
