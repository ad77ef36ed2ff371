"""The coarse pose of a frame: from the core's apexes and lines, before the edges are measured around it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rvdnav.core import FrameResult
from rvdnav.core.pose import refine_pose_lines
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.knowledge import Knowledge, Learned
from rvdnav.pose import (
    LineMeasurements,
    PoseError,
    RectifiedCameras,
    RefinedPose,
    inverse_T,
    iterative_three_point_pose,
    make_T,
    pose_from_apexes,
)
from rvdnav.pose.arrays import FloatArray

# Standard deviation of unit weight from which the lines' fit may have gone to the wrong minimum.
_POOR_FIT = 1.5
# What a line from Hough space alone is good for, and the least that a fitted one is taken to err, px.
_PEAK_SIGMA_PX = 0.7
_LINE_SIGMA_PX = 0.15
# Three or four lines leave nothing to tell that one of them is another's, and the prior is better than they.
_MIN_LINES = 5
# From which distance, px, a line lies beside its edge, and how many must come back to it for the calibration to be off:
# that moves many at once, noise and blur some.
_ASTRAY_PX = 1.0
_MOVED_LINES = 3


def coarse_pose(
    model: EdgeModel,
    frame: FrameResult,
    cameras: RectifiedCameras,
    prior: FloatArray,
    knowledge: Knowledge,
    learned: Learned,
) -> tuple[FloatArray, FloatArray]:
    """The paper's three-point pose from the apexes, then all lines of the views together; and the lasting parameters
    (p,) that it was found with.

    Those are the expected ones, unless most of the lines that contradict them agree once the calibration is freed.
    prior (4, 4): the acquired or the predicted pose, taken as it is where fewer than five lines were found, or they
    determine no pose.
    """
    lines = line_measurements(model.edge_points, frame)
    expected = knowledge.expected(learned)
    if len(lines) < _MIN_LINES:
        return prior, expected
    try:
        pose = _by_lines(model, frame, lines, cameras, prior)
    except PoseError:
        return prior, expected
    if knowledge.lasting > 0 and len(np.unique(lines.camera)) > 1:
        T = pose.T_world_target
        freed = refine_pose_lines(T, lines, cameras, systematics=knowledge.of_coarse_lines(T, lines, learned))
        astray, left = _astray(pose), _astray(freed)
        if astray - left >= _MOVED_LINES and 2 * left < astray:
            return freed.T_world_target, freed.z
    return pose.T_world_target, expected


def _astray(pose: RefinedPose) -> int:
    """How many lines lie beside their edges at a pose."""
    return int(np.count_nonzero(np.abs(pose.residuals).max(axis=1) > _ASTRAY_PX))


def _by_lines(
    model: EdgeModel, frame: FrameResult, lines: LineMeasurements, cameras: RectifiedCameras, prior: FloatArray
) -> RefinedPose:
    try:
        start = _three_point_pose(model, frame, cameras, prior)
        pose = refine_pose_lines(start, lines, cameras)
    except PoseError:  # degenerate corners; the prior may still do
        return refine_pose_lines(prior, lines, cameras)
    if pose.sigma0 > _POOR_FIT:
        # One line taken for another spoils its two corners, but is an outlier from a good start.
        pose = min(pose, refine_pose_lines(prior, lines, cameras), key=lambda pose: pose.sigma0)
    return pose


def _three_point_pose(model: EdgeModel, frame: FrameResult, cameras: RectifiedCameras, prior: FloatArray) -> FloatArray:
    """From apexes in space or, with one view, from three of them along their rays; the prior where they were not found.

    Raises PoseError for apexes that determine no pose.
    """
    if model.bracket is None:
        return prior
    if frame.apex_found[:4].all():
        return pose_from_apexes(frame.apexes_W[:4], model.bracket.outer)
    seen = [camera for camera, view in enumerate(frame.views) if view is not None]
    view = frame.views[seen[0]]
    if len(seen) > 1 or view is None or not view.apex_found[:3].all():
        return prior
    R, centre = cameras.R_rect_world, cameras.centers[seen[0]]
    T_rect_world = make_T(R, -R @ centre)
    rays = np.column_stack([view.apexes[:3], np.full(3, cameras.focal)])
    T_rect_target = iterative_three_point_pose(rays, model.bracket.outer[:3], T_rect_world @ prior)
    start: FloatArray = inverse_T(T_rect_world) @ T_rect_target
    return start


def line_measurements(edge_points: FloatArray, frame: FrameResult) -> LineMeasurements:
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
        camera, edge, edge_points[edge].reshape(-1, 2, 3), rho, theta, np.array(cov).reshape(-1, 2, 2)
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
