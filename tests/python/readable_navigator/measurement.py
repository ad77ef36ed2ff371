"""One frame's measurement: from a coarse pose to a refined one with its evidence."""

from __future__ import annotations

import math

import attrs
import numpy as np
from rvdnav.core import Core
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.faces import blur_excess, face_widths
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.navigator.knowledge import Knowledge, Learned
from rvdnav.navigator.measurement import Measurement
from rvdnav.navigator.sides import side_separation
from rvdnav.navigator.views import Images
from rvdnav.pose import (
    EdgeLines,
    LineMeasurements,
    RectifiedCameras,
    difference,
    fit_edge_lines,
    perturb,
    refine_pose_edges,
    refine_pose_lines,
)
from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray
from rvdnav.rig import Rig

from readable_navigator.back_edges import back_coverage
from readable_navigator.faces import edge_blur, with_slopes
from readable_navigator.neighbours import neighbour_separation
from readable_navigator.print_borders import border_separation
from readable_navigator.sampling import SampledEdges, Surroundings, sample_edges
from readable_navigator.shutter import MeasuredShutter
from readable_navigator.systematics import common_covariance, frame_systematics, own_covariance, taught

# Half-width of the profiles at first, around the lines of Hough space, and then around the refined pose.  Each round
# measures where the last one has put the edges, until that changes the pose by less than its standard deviation.
_COARSE_HALF_WIDTH_PX = 3.5
_HALF_WIDTH_PX = 2.5
_MAX_ROUNDS = 5
# Shown blur over the expected one from which larger ones are tried; these, px; the part of them that must be found,
# where the fit of a sharp step ends at 0.6; and from which on the blur mixes the two edges of a bar, px.
_BLURRED = 1.1
_BLURS_PX = (1.3, 2.5, 4.2)
_FOUND_BLUR = 0.85
_MIXING_BLUR_PX = 1.2
# Beside prints the rounds can go to and fro between two sets of samples: from this one on, steps are halved.
_FREE_ROUNDS = 1
# Weight from which a sample or a line counts as agreeing with the pose.
_TRUSTED = 0.2
# How far from the front edge the step may stand where a side face is in sight, as a part of its width in the image; a
# side face brighter than the front draws the step beyond the back edge.
_SIDE_SIGMA = 0.7
# Coverage from which the front edge speaks for itself.
_WHOLE = 0.5
# Part of an edge's samples that must agree in excess for it to have one polarity.
_SAME_POLARITY = 0.6
# Scatter of an edge's samples about its line from which they don't show it.
_STRAIGHT_PX = 0.7
# Logarithm of the odds for an edge's line against steps that noise put anywhere in the windows: from which the edge is
# shown; the mean of a view's edges from which the view shows the target; and what one edge counts at most in it.
# Neighbouring samples share pixels: two count as one.
_LINE_LOG_ODDS = 4.0
_VIEW_LOG_ODDS = 8.0
_MAX_LOG_ODDS = 20.0
_SAMPLES_SHARED = 2.0
# Part of the windows in which noise has such a step, and of an edge's, which may be hidden in part.
_FOUND_IN_NOISE, _FOUND_ON_EDGE = 0.35, 0.6
_LEAST_SCATTER_PX = 0.05
# Of the windows' half-width, px, where no step is looked for.
_WINDOW_MARGIN_PX = 1.0
# An edge against an uneven background scatters, and may be displaced as a whole by this part of its scatter; prints
# repeat along an edge, and displace it in many places alike.
_UNEVEN_SIGMA = 0.2
_PRINTED_SIGMA = 1.5
# By which a blur beyond a sharp image's may displace an edge in one view, as a part of it.
_BLUR_SIGMA = 0.05
# How far what slopes beside an edge have moved it may be wrong, as a part of it.
_MOVED_SIGMA = 0.5


def line_polarity(sampled: SampledEdges, fits: EdgeLines) -> IntArray:
    """(k,) of the fitted lines: +1 where most of their samples are brighter towards the normal, -1 darker."""
    total = np.zeros(sampled.attempted.shape)
    np.add.at(total, (sampled.camera, sampled.edge), fits.weights * sampled.polarity)
    return np.sign(total[fits.camera, fits.edge]).astype(np.int64)


def told_from_noise(sampled: SampledEdges, fits: EdgeLines, half_width: float) -> BoolArray:
    """(k,) whether a fitted line's samples, and those of its view, lie about their lines rather than anywhere.

    In noise some step is the steepest in many a window.  Such steps lie evenly within half_width px less the margin
    that the core leaves, those of an edge normally about its line, and in more of the windows.
    """
    count = sampled.count(fits.weights > 0.0)[fits.camera, fits.edge]
    lacking = sampled.attempted[fits.camera, fits.edge] - count
    window = 2.0 * (half_width - _WINDOW_MARGIN_PX)
    scatter = np.maximum(fits.rms, _LEAST_SCATTER_PX)
    by_scatter = count * np.log(window / (math.sqrt(2.0 * math.pi * math.e) * scatter))
    by_count = count * math.log(_FOUND_ON_EDGE / _FOUND_IN_NOISE)
    by_count += lacking * math.log((1.0 - _FOUND_ON_EDGE) / (1.0 - _FOUND_IN_NOISE))
    odds = (by_scatter + by_count) / _SAMPLES_SHARED
    total = np.zeros(len(sampled.attempted))
    np.add.at(total, fits.camera, np.clip(odds, 0.0, _MAX_LOG_ODDS))
    view = total / np.maximum((sampled.attempted > 0).sum(axis=1), 1)
    told: BoolArray = (odds > _LINE_LOG_ODDS) & (view[fits.camera] > _VIEW_LOG_ODDS)
    return told


def front_coverage(sampled: SampledEdges, inlier: BoolArray) -> FloatArray:
    """(cameras, edges) part of the profiles on the image that are inliers (n,)."""
    part: FloatArray = sampled.count(inlier) / np.maximum(sampled.attempted, 1)
    return part


def sample_polarity(sampled: SampledEdges, inlier: BoolArray) -> IntArray:
    """(cameras, edges) as of `Measurement.polarity`, of samples that are inliers (n,)."""
    brighter, darker = (sampled.count(inlier & (sampled.polarity == sign)) for sign in (1, -1))
    total = brighter - darker
    return np.where(np.abs(total) > _SAME_POLARITY * (brighter + darker), np.sign(total), 0)


def measure(
    core: Core,
    rig: Rig,
    model: EdgeModel,
    knowledge: Knowledge,
    learned: Learned,
    images: Images,
    T_world_target: FloatArray,
    polarity: IntArray,
    z: FloatArray | None = None,
) -> Measurement:
    """The pose that this frame's grey values give around a coarse one.

    images: of each camera, None where it has none.  T_world_target (4, 4): good to two or three pixels.
    polarity (cameras, edges): of the edges as last seen, 0 where unknown; only the first round holds to it, so that it
    can change with the light.  learned: of the lasting errors by the frames before.  z (p,): those that the coarse
    pose was found with; what is expected of them if not given.
    Raises PoseError where the measured geometry does not determine a pose.
    """
    cameras = rectified_cameras(rig)
    T = T_world_target
    z = knowledge.expected(learned) if z is None else z
    shutter = None if learned.motion is None else MeasuredShutter(rig, model, learned.motion)
    offsets = knowledge.edge_offsets(T, z)
    unknown = np.zeros(polarity.shape)
    sharp = Surroundings(unknown, np.full(polarity.shape, core.config.blur_sigma))

    def coarse(beside: Surroundings) -> tuple[SampledEdges, EdgeLines, LineMeasurements, FloatArray]:
        sampled, fits, lines = _measure_lines(
            core, rig, model, images, cameras, T, offsets, shutter, _COARSE_HALF_WIDTH_PX, polarity, beside
        )
        return sampled, fits, lines, edge_blur(sampled, fits.weights > _TRUSTED, beside.blur)

    sampled, fits, lines, blur = coarse(sharp)
    # The fit of a step looks as far as the expected blur: what is smoothed away farther than that seems sharp to it,
    # and a bar narrower than its blur seems to be a wider one.  So a larger one is tried, and held to if it is found.
    suspected = blur > _BLURRED * sharp.blur
    least = blur
    for expected in _BLURS_PX:
        if not suspected.any():
            break
        shown = coarse(Surroundings(face_widths(cameras, T, model), np.where(suspected, expected, blur)))[3]
        suspected &= shown > _FOUND_BLUR * expected
        blur = np.where(suspected, shown, blur)
    if (blur > least).any():
        sampled, fits, lines, blur = coarse(Surroundings(face_widths(cameras, T, model), blur))
    side = line_polarity(sampled, fits)
    systematics = frame_systematics(knowledge, model, T, lines, side, blur, learned, shutter)
    pose = refine_pose_lines(T, lines, cameras, systematics=systematics)
    T, z = pose.T_world_target, pose.z
    either = np.zeros_like(polarity)
    settled = False
    for number in range(_MAX_ROUNDS):
        # At first only the blur is known; then the pose is near enough to tell the edges' two sides, if the blur
        # doesn't mix them anyway.
        sided = number > 0 or float(np.median(blur)) > _MIXING_BLUR_PX
        beside = Surroundings(face_widths(cameras, T, model) if sided else unknown, blur)
        offsets = knowledge.edge_offsets(T, z[: knowledge.lasting])
        sampled, fits, lines = _measure_lines(
            core, rig, model, images, cameras, T, offsets, shutter, _HALF_WIDTH_PX, either, beside
        )
        blur = edge_blur(sampled, fits.weights > _TRUSTED, blur)
        systematics = frame_systematics(
            knowledge, model, T, lines, line_polarity(sampled, fits), blur, learned, shutter
        )
        pose = refine_pose_edges(T, lines, cameras, systematics)
        change = difference(pose.T_world_target, T)
        T, z = pose.T_world_target, pose.z
        settled = float(change @ np.linalg.solve(pose.covariance, change)) < 1.0
        if settled and (number > 0 or model.bracket is None):
            break
        if model.bracket is None and number >= _FREE_ROUNDS:
            T = perturb(T, -0.5 * change)
    trusted = np.zeros((len(images), len(model)), np.bool_)
    # Between prints any straight line agrees with some profiles; an edge's own don't scatter.
    straight = (fits.rms < _STRAIGHT_PX) | (model.bracket is not None)
    told = told_from_noise(sampled, fits, _HALF_WIDTH_PX)
    trusted[lines.camera, lines.edge] = (pose.weights > _TRUSTED) & straight & told
    inlier = (fits.weights > _TRUSTED) & trusted[sampled.camera, sampled.edge]
    lacking = front_coverage(sampled, inlier) < _WHOLE
    back = np.zeros(lacking.shape)
    if model.bracket is not None:
        back = back_coverage(core, rig, images, T, model.bracket, lacking)
    seen = np.array([image is not None for image in images])
    systematics = attrs.evolve(systematics, scales=pose.scales)
    return Measurement(
        pose=attrs.evolve(pose, covariance=pose.covariance + common_covariance(model, pose)),
        lines=lines,
        attempted=sampled.attempted,
        agreed=sampled.count(inlier),
        polarity=sample_polarity(sampled, inlier),
        settled=settled,
        back_coverage=back,
        own_covariance=own_covariance(knowledge, pose, systematics),
        blur=blur,
        systematics=systematics,
        learned=taught(knowledge, learned, pose, systematics),
        seen=seen,
    )


def _measure_lines(
    core: Core,
    rig: Rig,
    model: EdgeModel,
    images: Images,
    cameras: RectifiedCameras,
    T_world_target: FloatArray,
    offsets: FloatArray,
    shutter: MeasuredShutter | None,
    half_width: float,
    polarity: IntArray,
    beside: Surroundings,
) -> tuple[SampledEdges, EdgeLines, LineMeasurements]:
    """The edges measured where a pose puts them: samples, lines through them, and these for the refinement."""
    if shutter is not None:
        offsets = offsets + shutter.edge_offsets(T_world_target)
    sampled = sample_edges(core, rig, images, T_world_target, model, half_width, polarity, beside, offsets)
    if shutter is not None:
        sampled = shutter.at_stamp(sampled, T_world_target)
    moved = np.zeros(polarity.shape)
    if beside.face.any():
        sampled, moved = with_slopes(sampled)
    fits = fit_edge_lines(sampled.camera, sampled.edge, sampled.q, sampled.n, sampled.sigma)
    uneven = _PRINTED_SIGMA if model.bracket is None else _UNEVEN_SIGMA
    shift_sigma = np.hypot(uneven * fits.rms, _MOVED_SIGMA * moved[fits.camera, fits.edge])
    if model.bracket is not None:
        separation = side_separation(cameras, T_world_target, model.bracket, fits.camera, fits.edge, fits.theta)
    else:
        separation = neighbour_separation(cameras, T_world_target, model)[fits.camera, fits.edge]
        border = border_separation(core, rig, images, model, T_world_target, sampled, fits)
        separation = np.maximum(separation, border)
    shift_sigma = np.hypot(_SIDE_SIGMA * separation, shift_sigma)
    excess = blur_excess(beside.blur[fits.camera, fits.edge])
    shift_sigma = np.hypot(_BLUR_SIGMA * excess, shift_sigma)
    endpoints = sampled.spans[fits.camera, fits.edge]
    lines = LineMeasurements(fits.camera, fits.edge, endpoints, fits.rho, fits.theta, fits.cov, shift_sigma)
    return sampled, fits, lines
