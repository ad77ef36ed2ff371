"""Finding the board in an image, and why it was not found."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import cv2
import numpy as np
from numpy.typing import ArrayLike

from rvdnav.calibration.board import Board
from rvdnav.calibration.corners import fit_corners
from rvdnav.camera import CameraModel
from rvdnav.images import PixelArray
from rvdnav.pose.arrays import BoolArray, FloatArray

_MIN_SEEN = 8
"""Corners of a ChArUco board, or fitted ones of a chessboard."""
_BORDER_SQUARES = 1.5
"""A part of a board that ends this near to the image's border is cut off there."""
_MIN_PART = 12
"""Corners of a part of a board, or of another one, that is told of; of it:"""
_MIN_SQUARE_PX = 4.0
_PLANE = 0.15
"""RMS distance of the corners from those of a plane, in squares; the rest is the lens."""
_LIKE_CORNERS = 0.8
"""Share of them that must look like corners."""


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
    try:
        rough = _find_chessboard(image, board) if board.marker is None else _find_charuco(image, board)
        return _refined(image, board, rough, None)
    except cv2.error as error:  # an image smaller than its windows, for example
        raise BoardNotFoundError("the board was not found") from error


def refine(image: PixelArray, board: Board, corners: Corners, camera: CameraModel) -> Corners:
    """The corners measured again, now that the camera's distortion is known.  Raises BoardNotFoundError."""
    try:
        return _refined(image, board, corners.uv, camera)
    except cv2.error as error:
        raise BoardNotFoundError("the corners cannot be measured again") from error


def aligned(corners: Corners, reference: Corners, board: Board) -> Corners:
    """The corners in the order in which `reference` has them, who sees the same board.

    A chessboard may be read from either end (a square one from any side); the cameras of a rig are upright to each
    other within 60 degrees, so the order that points the same way is right.
    """
    if board.marker is not None:
        return corners
    grid = corners.uv.reshape(board.rows, board.columns, 2)
    wanted = _directions(reference.uv.reshape(grid.shape))
    best = max(_readings(grid, board), key=lambda turned: float(np.sum(_directions(turned) * wanted)))
    return attrs.evolve(corners, uv=np.ascontiguousarray(best).reshape(-1, 2))


def _readings(grid: FloatArray, board: Board) -> list[FloatArray]:
    """The corners (rows, columns, 2) of a chessboard in every order in which it may be read."""
    return [np.rot90(grid, turn) for turn in (range(4) if board.rows == board.columns else (0, 2))]


def _directions(grid: FloatArray) -> FloatArray:
    """Unit vectors (2, 2) along the rows and the columns, px."""
    means = np.stack([np.nanmean(np.diff(grid, axis=axis), axis=(0, 1)) for axis in (1, 0)])
    unit: FloatArray = means / np.linalg.norm(means, axis=1, keepdims=True)
    return unit


def _find_chessboard(image: PixelArray, board: Board) -> FloatArray:
    size = (board.columns, board.rows)
    searches = _SEARCHES if image.size > _COARSE else _SEARCHES[:-1]
    found = (search(*_reduced(image, largest), size) for search, largest in searches)
    uv = next((uv for uv in found if uv is not None), None)
    if uv is None:
        raise BoardNotFoundError(_partial(image, board))
    grid = uv.reshape(board.rows, board.columns, 2)
    (ax, ay), (bx, by) = _directions(grid)
    if ax * by - ay * bx < 0.0:  # read from behind
        grid = grid[:, ::-1]
    # The end at the image's upper left is the first.
    return min(_readings(grid, board), key=lambda turned: float(turned[0, 0].sum())).reshape(-1, 2)


def _reduced(image: PixelArray, largest: int) -> tuple[PixelArray, float]:
    """The image with that many pixels at most, and how many of its own make one of them along a side."""
    factor = max(1.0, float(np.sqrt(image.size / largest)))
    if factor == 1.0:
        return image, factor
    height, width = (max(1, round(side / factor)) for side in image.shape)
    return np.asarray(cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8), factor


def _enlarged(uv: ArrayLike, factor: float) -> FloatArray:
    """Pixels (n, 2) of the whole image from those of a reduced one."""
    points: FloatArray = (np.asarray(uv, dtype=np.float64).reshape(-1, 2) + 0.5) * factor - 0.5
    return points


def _by_sectors(image: PixelArray, factor: float, size: tuple[int, int]) -> FloatArray | None:
    found, uv = cv2.findChessboardCornersSB(image, size, flags=cv2.CALIB_CB_NORMALIZE_IMAGE)
    return _enlarged(uv, factor) if found else None


def _by_quads(image: PixelArray, factor: float, size: tuple[int, int]) -> FloatArray | None:
    flags = cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_FAST_CHECK
    found, uv = cv2.findChessboardCorners(image, size, flags=flags)
    return _enlarged(uv, factor) if found else None


_COARSE, _FINE, _QUADS = 1_400_000, 6_000_000, 500_000
_SEARCHES: tuple[tuple[Callable[[PixelArray, float, tuple[int, int]], FloatArray | None], int], ...] = (
    (_by_sectors, _COARSE),
    (_by_quads, _QUADS),
    (_by_sectors, _FINE),
)
"""How the board is looked for, in turn, in an image reduced to so many pixels: the time of each is about a
second at most, so that an interrupt is heeded.  Quadrangles take minutes in a dark image of 5 megapixels."""


def _partial(image: PixelArray, board: Board) -> str:
    """Why a chessboard was not found whole: what of it, or which other one, is there."""
    reduced, factor = _reduced(image, _COARSE)
    flags = cv2.CALIB_CB_LARGER | cv2.CALIB_CB_NORMALIZE_IMAGE
    found, uv, meta = cv2.findChessboardCornersSBWithMeta(reduced, (3, 3), flags)
    if not found or uv is None:
        return "the board was not found"
    rows, columns = meta.shape[:2]
    grid = _enlarged(uv, factor).reshape(rows, columns, 2)
    if not _is_board(image, grid):
        return "the board was not found"
    square = float(np.median(np.linalg.norm(np.diff(grid, axis=1), axis=2)))
    height, width = image.shape
    gaps = np.concatenate([grid.min(axis=(0, 1)), (width - 1, height - 1) - grid.max(axis=(0, 1))])
    few, many = sorted((rows, columns))
    stated = sorted((board.rows, board.columns))
    seen = f"{many}x{few}" if board.columns >= board.rows else f"{few}x{many}"
    named = f"{board.columns}x{board.rows}"
    if few > stated[0] or many > stated[1]:
        return f"{seen} corners are seen, not {named}"
    if gaps.min() < _BORDER_SQUARES * square:
        side = ("left", "upper", "right", "lower")[int(gaps.argmin())]
        return f"the board is cut off at the {side} border: {seen} of the {named} corners are seen"
    if (few, many) == tuple(stated):
        return "the board was not found"
    return f"the board was not found whole: {seen} of the {named} corners are seen"


def _is_board(image: PixelArray, grid: FloatArray) -> bool:
    """Whether what a detector took for a chessboard (rows, columns, 2), px, is one: noise and foliage have crossings
    too, but neither do those look like corners nor do they lie like those of a plane."""
    uv = grid.reshape(-1, 2)
    if len(uv) < _MIN_PART:
        return False
    flat = np.stack(np.meshgrid(np.arange(grid.shape[1]), np.arange(grid.shape[0])), axis=-1).reshape(-1, 2)
    H, _ = cv2.findHomography(flat.astype(np.float64), uv)
    steps = _steps(grid).reshape(-1, 2, 2)
    square = float(np.linalg.norm(steps, axis=2).min())
    if H is None or square < _MIN_SQUARE_PX:
        return False
    plane = cv2.perspectiveTransform(flat[None].astype(np.float64), H)[0]
    if np.sqrt(np.mean(np.sum((plane - uv) ** 2, axis=1))) > _PLANE * square:
        return False
    fits = fit_corners(image, _settled(image, uv, steps), steps, camera=None)
    return bool(np.isfinite(fits.uv).all(axis=1).mean() > _LIKE_CORNERS)


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
