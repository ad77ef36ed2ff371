"""Brackets of any size from frames of bars in both views: where they may be, and how large they would be."""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.navigator.bar_frames import BarFrames
from rvdnav.pose import (
    LineMeasurements,
    PoseError,
    RectifiedCameras,
    pose_from_apexes,
    refine_shape,
    triangulate,
)
from rvdnav.pose.arrays import FloatArray, IntArray
from rvdnav.pose.refined import weighted_rms
from rvdnav.trapezoid import Trapezoid

# Corners of one bracket lie on the same rows of both views, px: inner ones, and outer ones, whose sides may be guessed.
_INNER_ROWS_PX = 2.5
_OUTER_ROWS_PX = 5.0
# Disparities of a plane's points are an affine function of their places in the image.
_PLANE_RMS_PX = 1.0
_MAX_FITS = 24
# Corners this near to those of a better pair in both views make the same bracket, px.
_SAME_PX = 3.0
# Bases nearer to each other's length are not taken for a trapezoid's.
_LEAST_TAPER = 0.03
# A segment's error across it, px; that of a side whose place is guessed; what the fit of a bracket to them may leave.
_SEGMENT_SIGMA_PX = 0.3
_GUESS_SIGMA_PX = 1.5
_MAX_RMS_PX = 0.8
# Bars in the order of l1, l2, l3, l4, counted around the frame from l1 on.
_AROUND = (0, 2, 1, 3)
_MIN_LENGTH_M = 0.02
# Bars are wider than this part of the long base; the lines of a panel's grid are not.
_MIN_WIDTH_PART = 0.025


@attrs.frozen(eq=False)
class BracketCandidate:
    """A bracket that a pair of frames may be: pose (4, 4), sizes, RMS of the lines against it, px."""

    T_world_target: FloatArray
    shape: Trapezoid
    rms_px: float


@attrs.frozen(eq=False)
class BracketCandidates:
    """What pairs of frames may be.

    brackets: symmetric trapezoids, best fitting first.  untold: there are frames of bars whose opposite sides are of
    one length, so that nothing tells the long base.  cut: there were more pairs than are looked at.
    """

    brackets: tuple[BracketCandidate, ...]
    untold: bool
    cut: bool


def bracket_candidates(
    left: BarFrames, right: BarFrames, cameras: RectifiedCameras, baseline: float, gate: tuple[float, float]
) -> BracketCandidates:
    """Of the frames of the left and the right view; gate: nearest and farthest range, m."""
    found, fits, untold = [], 0, False
    matrices = [_projection_matrix(cameras, camera) for camera in (0, 1)]
    for i, j, turn in _pairs(left, right, cameras.focal * baseline, gate):
        xy_left, xy_right = left.corners[i], np.roll(right.corners[j], -turn, axis=0)
        points = triangulate(matrices[0], matrices[1], xy_left.reshape(-1, 2), xy_right.reshape(-1, 2))
        points = points.reshape(4, 2, 3)
        bases = _longer_bases(points[:, 0])
        untold = untold or not bases
        for first in bases:
            fits += 1
            candidate = _fit(left, right, (i, j, turn), first, points, cameras) if fits <= _MAX_FITS else None
            if candidate is not None:
                found.append(candidate)
    found.sort(key=lambda candidate: candidate.rms_px)
    return BracketCandidates(tuple(found), untold, left.cut or right.cut or fits > _MAX_FITS)


def _projection_matrix(cameras: RectifiedCameras, camera: int) -> FloatArray:
    K = np.diag([cameras.focal, cameras.focal, 1.0])
    R = cameras.R_rect_world
    matrix: FloatArray = K @ np.column_stack([R, -R @ cameras.centers[camera]])
    return matrix


def _pairs(left: BarFrames, right: BarFrames, scale: float, gate: tuple[float, float]) -> list[tuple[int, int, int]]:
    """Frames i of the left and j of the right view that may be one, with side k of i being side k + turn of j; those
    whose corners agree best first.  scale: focal length times baseline, px·m."""
    if not (len(left) and len(right)):
        return []
    found: list[tuple[float, int, int, int]] = []
    for turn in range(4):
        corners = np.roll(right.corners, -turn, axis=1)
        rows = np.abs(left.corners[:, None, :, :, 1] - corners[None, :, :, :, 1]).max(axis=2)
        disparity = left.corners[:, None, :, 1, 0] - corners[None, :, :, 1, 0]
        # The corners may be nearer or farther than the middle of l1, for which the gate is meant.
        near, far = scale / (0.7 * gate[0]), scale / (1.4 * gate[1])
        agree = (rows[..., 1] < _INNER_ROWS_PX) & (rows[..., 0] < _OUTER_ROWS_PX)
        agree &= (disparity > far).all(axis=2) & (disparity < near).all(axis=2)
        for i, j in zip(*np.nonzero(agree), strict=True):
            rms = _plane_rms(left.corners[i], corners[j])
            if rms < _PLANE_RMS_PX:
                found.append((rms + float(rows[i, j].mean()), int(i), int(j), turn))
    left_kind, right_kind = _kinds(left.corners), _kinds(right.corners)
    chosen: dict[tuple[int, int], tuple[int, int, int]] = {}
    for _, i, j, turn in sorted(found):
        chosen.setdefault((left_kind[i], right_kind[j]), (i, j, turn))
    return list(chosen.values())


def _kinds(corners: FloatArray) -> list[int]:
    """For each frame (n, 4, 2, 2) the first one whose corners, wherever they begin, are nearly the same."""
    apart = np.min(
        [np.abs(np.roll(corners, turn, axis=1)[:, None] - corners[None]).max(axis=(2, 3, 4)) for turn in range(4)],
        axis=0,
    )
    kinds: list[int] = np.argmax(apart < _SAME_PX, axis=1).tolist()
    return kinds


def _plane_rms(left: FloatArray, right: FloatArray) -> float:
    """RMS, px, of the disparities of corners (4, 2, 2) about those of a plane."""
    xy = left.reshape(-1, 2)
    A = np.column_stack([xy, np.ones(len(xy))])
    d = xy[:, 0] - right.reshape(-1, 2)[:, 0]
    return float(np.sqrt(np.mean((d - A @ np.linalg.lstsq(A, d, rcond=None)[0]) ** 2)))


def _longer_bases(outer: FloatArray) -> list[int]:
    """Sides of an outline (4, 3) in space that may be l1: of two that face each other, one clearly longer."""
    lengths = np.linalg.norm(np.roll(outer, -1, axis=0) - outer, axis=1)
    longer = [side if lengths[side] >= lengths[side + 2] else side + 2 for side in (0, 1)]
    return [side for side in longer if lengths[(side + 2) % 4] < (1.0 - _LEAST_TAPER) * lengths[side]]


def _fit(
    left: BarFrames,
    right: BarFrames,
    pair: tuple[int, int, int],
    first: int,
    points: FloatArray,
    cameras: RectifiedCameras,
) -> BracketCandidate | None:
    """The pair of frames read as a bracket whose l1 is the left frame's side `first`; points (4, 2, 3): corners, m."""
    i, j, turn = pair
    outer, inner = np.moveaxis(np.roll(points, -first, axis=0), 1, 0)
    lines = _lines(left, right, (i, (first + np.array(_AROUND)) % 4), (j, (first + turn + np.array(_AROUND)) % 4))
    try:
        shape = _sizes(outer, inner)
        start = pose_from_apexes(outer, shape.apexes[0])
        fit = refine_shape(start, shape.sizes, Trapezoid.edges_of, lines, cameras)
    except (PoseError, ZeroDivisionError):
        return None
    rms = weighted_rms(fit.residuals, fit.weights)
    found = Trapezoid.of(fit.sizes)
    if rms > _MAX_RMS_PX or not plausible(found):
        return None
    return BracketCandidate(fit.T_world_target, found, rms)


def plausible(shape: Trapezoid) -> bool:
    """Whether the sizes are those of a frame of four bars with a longer and a shorter base."""
    if shape.short_base < _MIN_LENGTH_M or shape.long_base <= shape.short_base or shape.height < _MIN_LENGTH_M:
        return False
    if min(shape.long_base_width, shape.short_base_width, shape.leg_width) < _MIN_WIDTH_PART * shape.long_base:
        return False
    try:
        shape.bracket(0.0)
    except ValueError:
        return False
    return True


def _sizes(outer: FloatArray, inner: FloatArray) -> Trapezoid:
    """From measured corners P1..P4 and Q1..Q4 (4, 3), m."""
    along = (outer[1] - outer[0]) / np.linalg.norm(outer[1] - outer[0])

    def across(points: FloatArray, start: FloatArray, direction: FloatArray) -> float:
        return float(np.linalg.norm(np.cross(points - start, direction), axis=1).mean())

    widths = []
    for a, b in ((1, 2), (3, 0)):
        leg = (outer[b] - outer[a]) / np.linalg.norm(outer[b] - outer[a])
        widths.append(across(inner[[a, b]], outer[a], leg))
    return Trapezoid(
        float(np.linalg.norm(outer[1] - outer[0])),
        float(np.linalg.norm(outer[3] - outer[2])),
        across(outer[2:], outer[0], along),
        across(inner[:2], outer[0], along),
        across(inner[2:], 0.5 * (outer[2] + outer[3]), along),
        float(np.mean(widths)),
    )


def _lines(
    left: BarFrames, right: BarFrames, left_sides: tuple[int, IntArray], right_sides: tuple[int, IntArray]
) -> LineMeasurements:
    """The sides of a frame in each view as lines of the edges in the order of `EDGE_NAMES`."""
    camera, edge, rho, theta, cov = [], [], [], [], []
    for index, frames, (frame, sides) in ((0, left, left_sides), (1, right, right_sides)):
        for bar, side in enumerate(sides):
            for k in (0, 1):
                length = float(frames.length[frame, side, k])
                middle = float(frames.middle[frame, side, k])
                sigma = _SEGMENT_SIGMA_PX if frames.seen[frame, side, k] else _GUESS_SIGMA_PX
                J = np.array([[1.0, middle], [0.0, 1.0]])
                camera.append(index)
                edge.append(2 * bar + k)
                rho.append(float(frames.rho[frame, side, k]))
                theta.append(float(frames.theta[frame, side, k]))
                cov.append(J @ np.diag([sigma**2, (2.0 * sigma / length) ** 2]) @ J.T)
    return LineMeasurements(camera, edge, np.zeros((len(edge), 2, 3)), rho, theta, np.array(cov))
