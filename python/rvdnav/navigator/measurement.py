"""One frame's measurement: from the core's lines to a refined pose with its evidence."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.core import Core, FrameResult
from rvdnav.navigator.back_edges import back_coverage
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.navigator.sampling import SampledEdges, sample_edges
from rvdnav.navigator.sides import side_separation
from rvdnav.pose import (
    EdgeLines,
    LineMeasurements,
    PoseError,
    RectifiedCameras,
    RefinedPose,
    difference,
    fit_edge_lines,
    pose_from_apexes,
    refine_pose_edges,
    refine_pose_lines,
)
from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray
from rvdnav.rig import Rig
from rvdnav.target import Bracket

# Half-width of the profiles at first, around the lines of Hough space, and then around the refined pose.  Each round
# measures where the last one has put the edges, until that changes the pose by less than its standard deviation.
_COARSE_HALF_WIDTH_PX = 3.5
_HALF_WIDTH_PX = 2.5
_MAX_ROUNDS = 5
# Weight from which a sample or a line counts as agreeing with the pose.
_TRUSTED = 0.2
# How far from the front edge the step may stand where a side face is in sight, as a part of its width in the image; a
# side face brighter than the front draws the step beyond the back edge.
_SIDE_SIGMA = 0.7
# Standard deviation of unit weight from which the lines' fit may have gone to the wrong minimum.
_POOR_FIT = 1.5
# Coverage from which the front edge speaks for itself.
_WHOLE = 0.5
# Part of an edge's samples that must agree in excess for it to have one polarity.
_SAME_POLARITY = 0.6
# An edge against an uneven background scatters, and may be displaced as a whole by this part of its scatter.
_UNEVEN_SIGMA = 0.5
# What a line from Hough space alone is good for, and the least that a fitted one is taken to err, px.
_PEAK_SIGMA_PX = 0.7
_LINE_SIGMA_PX = 0.15


@attrs.frozen(eq=False)
class Measurement:
    """A pose refined on this frame's own images, with what speaks for it."""

    pose: RefinedPose
    """Refined over ``lines``; its residuals and weights are theirs."""
    lines: LineMeasurements
    sampled: SampledEdges
    inlier: BoolArray
    """(n,) samples that agree with the pose."""
    settled: bool
    """The last round of sampling and refining changed the pose by less than its standard deviation."""
    back_coverage: FloatArray
    """(cameras, edges) the same as ``coverage`` for the back edges of side faces in sight, where the front edge agrees
    less than all along."""
    frame: FrameResult

    @property
    def coverage(self) -> FloatArray:
        """(cameras, edges) part of the profiles on the image that agree with the pose; 0 where none was possible."""
        return front_coverage(self.sampled, self.inlier)

    @property
    def polarity(self) -> IntArray:
        """(cameras, edges) +1 where the agreeing samples are brighter towards the normal (-dy, dx) of the edge's
        projection, -1 where darker, 0 where there are none or they differ."""
        sampled = self.sampled
        total = np.zeros(sampled.attempted.shape)
        count = np.zeros(sampled.attempted.shape)
        chosen = (sampled.camera[self.inlier], sampled.edge[self.inlier])
        np.add.at(total, chosen, sampled.polarity[self.inlier])
        np.add.at(count, chosen, 1)
        return np.where(np.abs(total) > _SAME_POLARITY * count, np.sign(total), 0.0).astype(np.int64)

    @property
    def total_coverage(self) -> float:
        """Part of all profiles on the images that agree with the pose."""
        return float(self.inlier.sum() / max(int(self.sampled.attempted.sum()), 1))


def front_coverage(sampled: SampledEdges, inlier: BoolArray) -> FloatArray:
    """(cameras, edges) part of the profiles on the image that are inliers (n,)."""
    agreed = np.zeros_like(sampled.attempted)
    np.add.at(agreed, (sampled.camera[inlier], sampled.edge[inlier]), 1)
    part: FloatArray = agreed / np.maximum(sampled.attempted, 1)
    return part


def measure(
    core: Core,
    rig: Rig,
    bracket: Bracket,
    frame: FrameResult,
    images: tuple[NDArray[np.uint8] | None, ...],
    prior: FloatArray,
    polarity: IntArray,
) -> Measurement:
    """The pose that this frame's lines and grey values give.

    prior (4, 4): the acquired or the predicted pose, the start where fewer than four apexes are measured in space.
    polarity (cameras, edges): of the edges as last seen, 0 where unknown; only the first round holds to it, so that it
    can change with the light.
    Raises PoseError where the measured geometry does not determine a pose.
    """
    cameras = rectified_cameras(rig)
    T = _coarse_pose(bracket, frame, cameras, prior)
    _, _, lines = _measure_lines(core, rig, bracket, images, cameras, T, _COARSE_HALF_WIDTH_PX, polarity)
    T = refine_pose_lines(T, lines, cameras).T_world_target
    either = np.zeros_like(polarity)
    settled = False
    for _ in range(_MAX_ROUNDS):
        sampled, fits, lines = _measure_lines(core, rig, bracket, images, cameras, T, _HALF_WIDTH_PX, either)
        pose = refine_pose_edges(T, lines, cameras)
        change = difference(pose.T_world_target, T)
        T = pose.T_world_target
        settled = float(change @ np.linalg.solve(pose.covariance, change)) < 1.0
        if settled:
            break
    trusted = np.zeros((len(images), len(bracket.edge_points)), np.bool_)
    trusted[lines.camera, lines.edge] = pose.weights > _TRUSTED
    inlier = (fits.weights > _TRUSTED) & trusted[sampled.camera, sampled.edge]
    lacking = front_coverage(sampled, inlier) < _WHOLE
    back = back_coverage(core, rig, images, T, bracket, lacking)
    return Measurement(pose, lines, sampled, inlier, settled, back, frame)


def _measure_lines(
    core: Core,
    rig: Rig,
    bracket: Bracket,
    images: tuple[NDArray[np.uint8] | None, ...],
    cameras: RectifiedCameras,
    T_world_target: FloatArray,
    half_width: float,
    polarity: IntArray,
) -> tuple[SampledEdges, EdgeLines, LineMeasurements]:
    """The edges measured where a pose puts them: samples, lines through them, and these for the refinement."""
    sampled = sample_edges(core, rig, images, T_world_target, bracket, half_width, polarity)
    fits = fit_edge_lines(sampled.camera, sampled.edge, sampled.q, sampled.n, sampled.sigma)
    separation = side_separation(cameras, T_world_target, bracket, fits.camera, fits.edge, fits.theta)
    shift_sigma = np.hypot(_SIDE_SIGMA * separation, _UNEVEN_SIGMA * fits.rms)
    endpoints = bracket.edge_points[fits.edge]
    lines = LineMeasurements(fits.camera, fits.edge, endpoints, fits.rho, fits.theta, fits.cov, shift_sigma)
    return sampled, fits, lines


def _coarse_pose(bracket: Bracket, frame: FrameResult, cameras: RectifiedCameras, prior: FloatArray) -> FloatArray:
    """The paper's three-point pose from the triangulated apexes, then all lines of both views together."""
    lines = line_measurements(bracket, frame)
    try:
        start = pose_from_apexes(frame.apexes_W[:4], bracket.outer) if frame.apex_found[:4].all() else prior
        pose = refine_pose_lines(start, lines, cameras)
    except PoseError:  # degenerate corners; the prior may still do
        return refine_pose_lines(prior, lines, cameras).T_world_target
    if pose.sigma0 > _POOR_FIT:
        # One line taken for another spoils its two corners, but is an outlier from a good start.
        pose = min(pose, refine_pose_lines(prior, lines, cameras), key=lambda pose: pose.sigma0)
    return pose.T_world_target


def line_measurements(bracket: Bracket, frame: FrameResult) -> LineMeasurements:
    """The lines found in the views, each with the covariance of its fit or, without one, of its peak."""
    camera, edge, rho, theta, cov = [], [], [], [], []
    for index, view in enumerate(frame.views):
        if view is None:
            continue
        for k in np.flatnonzero(view.line_found):
            line = view.lines[k]
            camera.append(index)
            edge.append(int(k))
            rho.append(float(line["rho"]))
            theta.append(float(line["theta"]))
            cov.append(_line_covariance(line))
    return LineMeasurements(
        camera, edge, bracket.edge_points[edge].reshape(-1, 2, 3), rho, theta, np.array(cov).reshape(-1, 2, 2)
    )


def _line_covariance(line: NDArray[np.void]) -> FloatArray:
    """Of (rho, theta): an offset and a tilt about the line's middle, plus what the fit says where there is one."""
    fitted = bool(line["refitted"])
    sigma = _LINE_SIGMA_PX if fitted else _PEAK_SIGMA_PX
    middle = 0.5 * float(line["t_min"] + line["t_max"])
    tilt = sigma / max(float(line["t_max"] - line["t_min"]), 1.0)
    J = np.array([[1.0, middle], [0.0, 1.0]])
    covariance: FloatArray = J @ np.diag([sigma**2, tilt**2]) @ J.T
    if fitted:
        covariance = covariance + line["covariance"].reshape(2, 2)
    return covariance


def disparity_errors(measurement: Measurement, bracket: Bracket, rig: Rig) -> FloatArray:
    """Disparities (k,) of the correlated points on the bars' faces minus what the pose predicts for them, px."""
    matches = measurement.frame.matches
    matches = matches[matches["accepted"] != 0]
    if len(matches) == 0:
        return np.zeros(0)
    T = measurement.pose.T_world_target
    R_rect_world = rig.R_world_rect.T
    # The face is the plane x_C = const; its normal and a point on it, seen from the left camera in rectified axes.
    normal = R_rect_world @ T[:3, 0]
    point = R_rect_world @ (T[:3, :3] @ bracket.outer[0] + T[:3, 3] - rig.T_world_cam[0][:3, 3])
    rays = np.column_stack([matches["x"], matches["y"], np.full(len(matches), rig.focal_rect)]) / rig.focal_rect
    depth = (normal @ point) / (rays @ normal)
    errors: FloatArray = matches["disparity"] - rig.focal_rect * rig.baseline / depth
    return errors


def measured_segments(frame: FrameResult) -> dict[int, FloatArray]:
    """Camera index -> (n, 4) measured lines as segments x0, y0, x1, y1, rectified px."""
    drawn = {}
    for camera, view in enumerate(frame.views):
        if view is None:
            continue
        lines = view.lines[view.line_found]
        c, s = np.cos(lines["theta"]), np.sin(lines["theta"])
        ends = [
            np.column_stack([c * lines["rho"] - s * lines[t], s * lines["rho"] + c * lines[t]])
            for t in ("t_min", "t_max")
        ]
        drawn[camera] = np.hstack(ends)
    return drawn
