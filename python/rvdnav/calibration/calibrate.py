"""Calibration of the stereo rig from views of a board: Zhang's method, then a bundle adjustment with its covariance.

Z. Zhang, "A flexible new technique for camera calibration", IEEE PAMI 22 (2000), is OpenCV's start for each camera and
for the rig; what follows measures the corners again with the lens known, and adjusts everything at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

import attrs
import numpy as np

from rvdnav.calibration.adjustment import Adjustment, StereoModel, adjust
from rvdnav.calibration.board import Board
from rvdnav.calibration.detection import BoardNotFoundError, refine
from rvdnav.calibration.sources import ImagePair
from rvdnav.calibration.start import calibrate_one, relative_pose_errors, start_stereo
from rvdnav.calibration.stretch import board_stretch
from rvdnav.calibration.views import Dropped, Progress, View, find_views, select
from rvdnav.core import Core
from rvdnav.errors import CoreError
from rvdnav.pose.arrays import BoolArray, FloatArray
from rvdnav.rig import Rig, world_from_camchain

MIN_VIEWS = 3
SQUARE_SIGMA = 0.001
"""How well the size of a board's squares is known, as a share: it scales the baseline, and no picture shows it."""
_MISFIT_RATIO = 4.0
_MISFIT_FLOOR_PX = 0.25
"""A view is dropped whose RMS is this many times the views' median, and above the floor."""
_ONE_RIG_SHARE = 0.01
"""A view belongs to a rig if it fits the relative pose of the cameras in another one to this share of the image's
diagonal (RMS)."""
_OUTLIER = 6.0
"""A corner is dropped whose residual exceeds this many (robust) standard deviations."""


class CalibrationError(ValueError):
    """The views give no calibration; the message is one line, and `dropped` says which views were not used and why."""

    def __init__(self, text: str, dropped: Iterable[Dropped] = ()) -> None:
        super().__init__(text)
        self.dropped = tuple(dropped)


@attrs.frozen(eq=False)
class Calibration:
    """A calibrated rig and how it came about.

    views: those kept, in the order of the adjustment's.  uv (v, 2, n, 2): their corners, px, NaN where not seen or
    dropped.  stretch: by how much the squares are wider than high, as a share, and its sigma: a print's fault.
    """

    board: Board
    rig: Rig
    adjustment: Adjustment
    views: tuple[View, ...]
    uv: FloatArray
    dropped: tuple[Dropped, ...]
    stretch: float
    sigma_stretch: float


def calibrate(pairs: Iterable[ImagePair], board: Board, progress: Progress = lambda name: None) -> Calibration:
    """Calibrate from pairs of images of the board.  Raises CalibrationError."""
    dropped: list[Dropped] = []
    try:
        search = find_views(pairs, board, progress)
        board = search.board
        dropped += search.dropped
        views = select(search.views, dropped)
        _require(views, board)
        for camera in range(2):
            views = _without_misfits(views, partial(_mono_errors, board=board, camera=camera), dropped)
        views = _of_one_rig(views, board, dropped)
        views = _without_misfits(views, lambda left: start_stereo(left, board)[1], dropped)
        adjustment, views, _ = _adjusted(start_stereo(views, board)[0], views, board, dropped)
        model, views = _measured_again(adjustment.model, views, board, dropped)
        adjustment, views, uv = _adjusted(model, views, board, dropped)
        rig = _rig(adjustment)
        stretch, sigma_stretch = board_stretch(adjustment, board.points, uv)
    except np.linalg.LinAlgError as error:
        raise CalibrationError("the views do not determine the rig", dropped) from error
    except ValueError as error:
        raise CalibrationError(str(error), dropped) from error
    return Calibration(board, rig, adjustment, tuple(views), uv, tuple(dropped), stretch, sigma_stretch)


def _require(views: list[View], board: Board) -> None:
    if len(views) < MIN_VIEWS:
        raise ValueError(f"{len(views)} usable views of the {board}, where {MIN_VIEWS} are needed")


def _mono_errors(views: list[View], board: Board, camera: int) -> FloatArray:
    return calibrate_one(views, board, camera).errors


def _of_one_rig(views: list[View], board: Board, dropped: list[Dropped]) -> list[View]:
    """The views that show the cameras in one relative pose, which more than half of them must.

    The relative pose is taken from the view that most agree with (P. J. Rousseeuw, "Least median of squares
    regression", 1984): a camera that lost a frame gives many pairs that do not belong together, and a fit over all of
    them would be anything.
    """
    errors = relative_pose_errors(views, board)
    median = np.sort(errors, axis=1)[:, len(views) // 2]
    fits = errors[np.argmin(median)]
    height, width = views[0].images[0].shape
    limit = _ONE_RIG_SHARE * float(np.hypot(width, height))
    agree = fits <= limit
    if not agree.sum() > len(views) / 2:
        raise ValueError(
            f"the left and the right pictures do not fit one rig ({agree.sum()} of {len(views)} views at most agree on "
            "how the cameras stand to each other); do they belong together?"
        )
    usual = fits[agree]
    dropped += [_misfitting(view, error, usual) for view, error in zip(views, fits, strict=True) if error > limit]
    views = [view for view, good in zip(views, agree, strict=True) if good]
    _require(views, board)
    return views


def _without_misfits(
    views: list[View], errors_of: Callable[[list[View]], FloatArray], dropped: list[Dropped]
) -> list[View]:
    """The views without those that fit far worse than the rest, the worst first: a wrong one spoils the others' fit."""
    while len(views) > MIN_VIEWS:
        errors = errors_of(views)
        worst = int(np.argmax(errors))
        if errors[worst] <= _misfit(errors):
            break
        dropped.append(_misfitting(views[worst], errors[worst], errors))
        views = views[:worst] + views[worst + 1 :]
    return views


def _misfit(errors: FloatArray) -> float:
    return max(_MISFIT_RATIO * float(np.median(errors)), _MISFIT_FLOOR_PX)


def _misfitting(view: View, error: float, errors: FloatArray) -> Dropped:
    return Dropped(view.name, f"does not fit the other views (RMS {error:.2f} px, theirs {np.median(errors):.2f})")


def _adjusted(
    model: StereoModel, views: list[View], board: Board, dropped: list[Dropped]
) -> tuple[Adjustment, list[View], FloatArray]:
    """The adjustment over the views and corners that fit, with those views and corners."""
    uv = np.stack([view.uv for view in views])
    while True:
        adjustment = adjust(model, board.points, uv)
        errors = adjustment.view_rms_px.max(axis=1)
        kept = errors <= _misfit(errors)
        outliers = _outliers(adjustment.residuals)
        if kept.all() and not outliers.any():
            return adjustment, views, uv
        dropped += [_misfitting(views[i], errors[i], errors) for i in np.flatnonzero(~kept)]
        uv = np.where(outliers[..., None], np.nan, uv)[kept]
        views = [view for view, good in zip(views, kept, strict=True) if good]
        _require(views, board)
        model = _of_views(adjustment.model, kept)


def _of_views(model: StereoModel, kept: BoolArray) -> StereoModel:
    return attrs.evolve(model, T_cam0_board=model.T_cam0_board[kept])


def _outliers(residuals: FloatArray) -> BoolArray:
    sigma = 1.4826 * float(np.nanmedian(np.abs(residuals)))
    outliers: BoolArray = (
        np.nanmax(np.abs(np.where(np.isfinite(residuals), residuals, 0.0)), axis=-1) > _OUTLIER * sigma
    )
    return outliers


def _measured_again(
    model: StereoModel, views: list[View], board: Board, dropped: list[Dropped]
) -> tuple[StereoModel, list[View]]:
    """The views with their corners measured through the known lenses."""
    kept = np.ones(len(views), dtype=np.bool_)
    measured = []
    for index, view in enumerate(views):
        try:
            left, right = (
                refine(image, board, corners, camera)
                for image, corners, camera in zip(view.images, view.corners, model.cameras, strict=True)
            )
        except BoardNotFoundError as reason:
            dropped.append(Dropped(view.name, str(reason)))
            kept[index] = False
        else:
            measured.append(attrs.evolve(view, corners=(left, right)))
    _require(measured, board)
    return _of_views(model, kept), measured


def _rig(adjustment: Adjustment) -> Rig:
    model = adjustment.model
    covariance = adjustment.covariance.copy()
    shift = model.T_cam1_cam0[:3, 3]
    covariance[-3:, -3:] += SQUARE_SIGMA**2 * np.outer(shift, shift)
    try:
        rig = Rig(model.cameras, world_from_camchain(model.T_cam1_cam0), covariance)
        Core(rig)  # what the navigator would refuse is no result
        return rig
    except (ValueError, CoreError) as error:
        raise ValueError(f"the views give no usable rig: {error}") from error
