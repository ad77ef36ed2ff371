"""Finding the board in an image, and why it was not found."""

from __future__ import annotations

import attrs
import cv2
import numpy as np

from rvdnav.calibration.board import Board
from rvdnav.calibration.corners import fit_corners
from rvdnav.camera import CameraModel
from rvdnav.images import PixelArray
from rvdnav.pose.arrays import BoolArray, FloatArray

_MIN_SEEN = 8
"""Corners of a ChArUco board, or fitted ones of a chessboard."""
_BORDER_SQUARES = 1.5
"""A part of a board that ends this near to the image's border is cut off there."""


class BoardNotFoundError(Exception):
    """The board is not usable in an image; the message says why."""


@attrs.frozen(eq=False)
class Corners:
    """The board in one image.

    uv (n, 2): its corners in the board's order, px, NaN where not seen.  blur: median sigma of their edges, px.
    """

    uv: FloatArray
    blur: float


def find_board(image: PixelArray, board: Board) -> Corners:
    """The board's corners in a grey image.  Raises BoardNotFoundError."""
    rough = _find_chessboard(image, board) if board.marker is None else _find_charuco(image, board)
    return _refined(image, board, rough, None)


def refine(image: PixelArray, board: Board, corners: Corners, camera: CameraModel) -> Corners:
    """The corners measured again, now that the camera's distortion is known.  Raises BoardNotFoundError."""
    return _refined(image, board, corners.uv, camera)


def aligned(corners: Corners, reference: Corners, board: Board) -> Corners:
    """The corners in the order in which `reference` has them, who sees the same board.

    A chessboard may be read from either end (a square one from any side); the cameras of a rig are upright to each
    other within 60 degrees, so the order that points the same way is right.
    """
    if board.marker is not None:
        return corners
    grid = corners.uv.reshape(board.rows, board.columns, 2)
    turns = range(4) if board.rows == board.columns else (0, 2)
    wanted = _directions(reference.uv.reshape(grid.shape))
    best = max((np.rot90(grid, turn) for turn in turns), key=lambda turned: float(np.sum(_directions(turned) * wanted)))
    return attrs.evolve(corners, uv=np.ascontiguousarray(best).reshape(-1, 2))


def _directions(grid: FloatArray) -> FloatArray:
    """Unit vectors (2, 2) along the rows and the columns, px."""
    means = np.stack([np.nanmean(np.diff(grid, axis=axis), axis=(0, 1)) for axis in (1, 0)])
    unit: FloatArray = means / np.linalg.norm(means, axis=1, keepdims=True)
    return unit


def _find_chessboard(image: PixelArray, board: Board) -> FloatArray:
    size = (board.columns, board.rows)
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
    found, uv = cv2.findChessboardCorners(image, size, flags=flags)
    if not found:
        found, uv = cv2.findChessboardCornersSB(image, size, flags=cv2.CALIB_CB_NORMALIZE_IMAGE)
    if not found:
        raise BoardNotFoundError(_partial(image, board))
    grid = uv.reshape(board.rows, board.columns, 2).astype(np.float64)
    (ax, ay), (bx, by) = _directions(grid)
    if ax * by - ay * bx < 0.0:  # read from behind
        grid = grid[:, ::-1]
    return grid.reshape(-1, 2)


def _partial(image: PixelArray, board: Board) -> str:
    """Why a chessboard was not found whole: what of it is there."""
    flags = cv2.CALIB_CB_LARGER | cv2.CALIB_CB_NORMALIZE_IMAGE
    found, uv, meta = cv2.findChessboardCornersSBWithMeta(image, (3, 3), flags)
    if not found or uv is None:
        return "the board was not found"
    rows, columns = meta.shape[:2]
    if rows * columns >= board.rows * board.columns:
        return "the board was not found"
    grid = uv.reshape(rows, columns, 2)
    square = float(np.median(np.linalg.norm(np.diff(grid, axis=1), axis=2)))
    height, width = image.shape
    gaps = np.concatenate([grid.min(axis=(0, 1)), (width - 1, height - 1) - grid.max(axis=(0, 1))])
    seen = f"{columns}x{rows} of the {board.columns}x{board.rows} corners are seen"
    if gaps.min() < _BORDER_SQUARES * square:
        return f"the board is cut off at the {('left', 'upper', 'right', 'lower')[int(gaps.argmin())]} border: {seen}"
    return f"the board was not found whole: {seen}"


def _find_charuco(image: PixelArray, board: Board) -> FloatArray:
    corners, ids, _, markers = cv2.aruco.CharucoDetector(board.charuco()).detectBoard(image)
    if ids is None or len(ids) < _MIN_SEEN:
        seen = 0 if markers is None else len(markers)
        raise BoardNotFoundError(
            f"fewer than {_MIN_SEEN} corners of the board were found ({seen} of its {board.markers} markers)"
        )
    uv = np.full((board.columns * board.rows, 2), np.nan)
    uv[ids.ravel()] = corners.reshape(-1, 2)
    return uv


def _refined(image: PixelArray, board: Board, rough: FloatArray, camera: CameraModel | None) -> Corners:
    steps = _steps(rough.reshape(board.rows, board.columns, 2)).reshape(-1, 2, 2)
    usable = np.isfinite(rough).all(axis=1) & np.isfinite(steps).all(axis=(1, 2))
    uv = np.full_like(rough, np.nan)
    if usable.sum() >= _MIN_SEEN:
        fits = fit_corners(
            image,
            _settled(image, rough[usable], steps[usable]),
            steps[usable],
            camera=camera,
            clearance=board.clearance,
        )
        uv[usable] = fits.uv
        seen = int(np.isfinite(fits.uv).all(axis=1).sum())
        if seen >= max(_MIN_SEEN, usable.sum() // 2):
            return Corners(uv=uv, blur=float(np.median(fits.blur[np.isfinite(fits.uv).all(axis=1)])))
        if not fits.inside.sum() >= len(fits.inside) / 2:
            raise BoardNotFoundError("the board is cut off at the image's border")
    raise BoardNotFoundError("what was found does not look like the corners of a chessboard")


def _steps(grid: FloatArray) -> FloatArray:
    """Ways (rows, columns, 2, 2), px, to the next corner of the row and of the column; NaN without a neighbour."""
    steps = []
    for axis in (1, 0):
        ahead = np.diff(grid, axis=axis)
        before, after = (np.insert(ahead, at, np.nan, axis=axis) for at in (0, ahead.shape[axis]))
        both = 0.5 * (before + after)
        steps.append(np.where(np.isfinite(both), both, np.where(np.isfinite(after), after, before)))
    return np.stack(steps, axis=2)


def _settled(image: PixelArray, uv: FloatArray, steps: FloatArray) -> FloatArray:
    """Corners (n, 2) moved from a detector's whole pixels to where the fit finds its minimum."""
    half = int(np.clip(np.linalg.norm(steps, axis=2).min() * 0.4, 2, 5))
    points = np.ascontiguousarray(uv[:, None], dtype=np.float32)
    cv2.cornerSubPix(image, points, (half, half), (-1, -1), (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 20, 1e-2))
    moved: BoolArray = np.linalg.norm(points[:, 0] - uv, axis=1) < half
    return np.where(moved[:, None], points[:, 0].astype(np.float64), uv)
