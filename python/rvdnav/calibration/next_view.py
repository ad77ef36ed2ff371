"""Where the next picture of the board would help most: the pose of it that lowers the mission's sigmas most."""

from __future__ import annotations

import itertools

import attrs
import numpy as np

from rvdnav.calibration.adjustment import Adjustment, StereoModel, T_cam_board, view_information
from rvdnav.calibration.board import Board
from rvdnav.calibration.verdict import PoseSensitivity
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import exp, make_T

_PLACES = (0.2, 0.35, 0.5, 0.65, 0.8)
_FILLED = (0.35, 0.55, 0.75)
"""Width of the board, seen squarely, as a part of the image's."""
_TILT_RAD = np.radians(40.0)
_TILTS = ((0.0, 0.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
_BORDER_PX = 6.0


@attrs.frozen(eq=False)
class NextView:
    """A board pose T_cam0_board (4, 4), m, worth taking a picture of, and the covariance (22, 22) with it.

    description: where to hold the board, in words.
    """

    T_cam0_board: FloatArray
    covariance: FloatArray
    description: str


def next_views(
    adjustment: Adjustment, board: Board, sensitivities: tuple[PoseSensitivity, ...], count: int
) -> tuple[NextView, ...]:
    """The best pictures to take, each in addition to those before it; fewer where no board fits into both views.

    Best is what makes the mean of the pose's variances, position and attitude at every range relative to what they are
    now, least.  The corners are taken to err as those of the views so far.
    """
    candidates = _candidates(adjustment.model, board)
    if not candidates or not sensitivities:
        return ()
    poses = np.stack([pose for pose, _ in candidates])
    model = attrs.evolve(adjustment.model, T_cam0_board=poses)
    uv = np.zeros((len(poses), 2, len(board.points), 2))
    information = view_information(model, board.points, uv)
    variance = adjustment.sigma_px**2 * adjustment.correlation
    now = _variances(sensitivities, adjustment.covariance)
    normal = adjustment.normal
    chosen = []
    for _ in range(count):
        covariances = [_inverse(normal + added) * variance for added in information]
        merits = [float(np.mean(_variances(sensitivities, covariance) / now)) for covariance in covariances]
        best = int(np.argmin(merits))
        chosen.append(NextView(poses[best], covariances[best], candidates[best][1]))
        normal = normal + information[best]
    return tuple(chosen)


def _variances(sensitivities: tuple[PoseSensitivity, ...], covariance: FloatArray) -> FloatArray:
    return np.square([sensitivity.sigmas(covariance) for sensitivity in sensitivities])


def _inverse(normal: FloatArray) -> FloatArray:
    units = 1.0 / np.sqrt(np.diagonal(normal))
    inverse: FloatArray = np.linalg.inv(normal * np.outer(units, units)) * np.outer(units, units)
    return inverse


def _candidates(model: StereoModel, board: Board) -> list[tuple[FloatArray, str]]:
    """Board poses over the left image, near and far, square and tilted, that both cameras see whole."""
    camera = model.cameras[0]
    middle = board.points.mean(axis=0)
    width = (board.columns + 1) * board.square
    found = []
    for filled, x, y, tilt in itertools.product(_FILLED, _PLACES, _PLACES, _TILTS):
        distance = camera.fx * width / (filled * camera.width)
        ray = camera.unproject(np.array([[x * camera.width, y * camera.height]]))[0]
        R = exp(np.array([tilt[0], tilt[1], 0.0]) * _TILT_RAD)
        T = make_T(R, ray * distance - R @ middle)
        if _seen(attrs.evolve(model, T_cam0_board=T[None]), board):
            found.append((T, _description(x, y, distance, tilt)))
    return found


def _seen(model: StereoModel, board: Board) -> bool:
    limits = np.array([model.cameras[0].width - 1, model.cameras[0].height - 1]) - _BORDER_PX
    for index, camera in enumerate(model.cameras):
        T = T_cam_board(model, index)[0]
        uv = camera.project(board.points @ T[:3, :3].T + T[:3, 3])
        if not ((uv > _BORDER_PX) & (uv < limits)).all():
            return False
    return True


def _description(x: float, y: float, distance: float, tilt: tuple[float, float]) -> str:
    rows = {True: "upper", False: "lower"}
    vertical = "" if abs(y - 0.5) < 0.1 else rows[y < 0.5]
    horizontal = "" if abs(x - 0.5) < 0.1 else ("left" if x < 0.5 else "right")
    place = (
        f"in the {' '.join(filter(None, (vertical, horizontal)))} part" if vertical or horizontal else "in the middle"
    )
    turned = {
        (0.0, 0.0): "square to the camera",
        (1.0, 0.0): "its upper edge tilted 40° towards the cameras",
        (-1.0, 0.0): "its lower edge tilted 40° towards the cameras",
        (0.0, 1.0): "its right edge tilted 40° towards the cameras",
        (0.0, -1.0): "its left edge tilted 40° towards the cameras",
    }[tilt]
    return f"{distance:.2f} m away, {place} of the left image, {turned}"
