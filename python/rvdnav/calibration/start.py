"""The start of the bundle adjustment: Zhang's method and the stereo calibration as OpenCV has them."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rvdnav.calibration.adjustment import StereoModel
from rvdnav.calibration.board import Board
from rvdnav.calibration.views import View
from rvdnav.camera import CameraModel
from rvdnav.pose.arrays import BoolArray, FloatArray
from rvdnav.pose.so3 import exp, make_T

_FLAGS = cv2.CALIB_FIX_K3
_CRITERIA = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-9)
_Points = list[NDArray[np.float32]]


@attrs.frozen(eq=False)
class MonoCalibration:
    """One camera by itself: K (3, 3), distortion (5,), each view's RMS error (v,), px, and T_cam_board (v, 4, 4)."""

    K: FloatArray
    distortion: FloatArray
    errors: FloatArray
    T_cam_board: FloatArray


def start_stereo(views: Sequence[View], board: Board) -> tuple[StereoModel, FloatArray]:
    """The rig by OpenCV's stereo calibration, and the RMS error (v,), px, of each view, the worse camera's.

    Raises ValueError where the views do not determine it.
    """
    left, right = (calibrate_one(views, board, camera) for camera in range(2))
    seen = [_seen(view.uv[0]) & _seen(view.uv[1]) for view in views]
    size = _size(views)
    try:
        # The cameras are held: a view that doesn't belong would bend them instead of showing in its own error.
        _, _, _, _, _, R, t, _, _, rotations, translations, errors = cv2.stereoCalibrateExtended(
            _object_points(board, seen),
            _image_points(views, 0, seen),
            _image_points(views, 1, seen),
            left.K,
            left.distortion,
            right.K,
            right.distortion,
            size,
            np.eye(3),
            np.zeros(3),
            flags=cv2.CALIB_FIX_INTRINSIC,
            criteria=_CRITERIA,
        )
    except cv2.error as error:
        raise ValueError("the views do not determine the rig") from error
    poses = [_transform(r, p) for r, p in zip(rotations, translations, strict=True)]
    model = StereoModel(
        cameras=(_camera(size, left), _camera(size, right)),
        T_cam1_cam0=_transform(R, t),
        T_cam0_board=np.stack(poses),
    )
    return model, np.max(errors, axis=1)


def calibrate_one(views: Sequence[View], board: Board, camera: int) -> MonoCalibration:
    """One camera of the rig by Zhang's method.  Raises ValueError where the views do not determine it."""
    seen = [_seen(view.uv[camera]) for view in views]
    try:
        _, K, distortion, rotations, translations, _, _, errors = cv2.calibrateCameraExtended(
            _object_points(board, seen),
            _image_points(views, camera, seen),
            _size(views),
            np.eye(3),
            np.zeros(5),
            flags=_FLAGS,
        )
    except cv2.error as error:
        raise ValueError("the views do not determine the cameras") from error
    return MonoCalibration(
        K=np.asarray(K, np.float64),
        distortion=np.asarray(distortion, np.float64).ravel(),
        errors=np.asarray(errors, np.float64).ravel(),
        T_cam_board=np.stack([_transform(r, t) for r, t in zip(rotations, translations, strict=True)]),
    )


def relative_pose_errors(views: Sequence[View], board: Board) -> FloatArray:
    """How well each view's corners fit the relative pose of the cameras in each other view (v, v), RMS px.

    Row i takes T_cam1_cam0 from view i alone; column j is the error of view j's corners when its board is carried by
    that from one camera to the other, the way that fits better, since a camera that sees a board square on may mistake
    its tilt.  Raises ValueError where the views do not determine the cameras.
    """
    mono = [calibrate_one(views, board, camera) for camera in range(2)]
    to_right = mono[1].T_cam_board @ np.linalg.inv(mono[0].T_cam_board)
    errors = []
    for camera, carry in ((1, to_right), (0, np.linalg.inv(to_right))):
        carried = carry[:, None] @ mono[1 - camera].T_cam_board  # (v, v, 4, 4)
        points = board.points @ np.swapaxes(carried[..., :3, :3], -1, -2) + carried[..., None, :3, 3]
        own = mono[camera]
        flat, _ = cv2.projectPoints(points.reshape(-1, 3), np.zeros(3), np.zeros(3), own.K, own.distortion)
        distances = np.linalg.norm(flat.reshape(*points.shape[:3], 2) - [view.uv[camera] for view in views], axis=-1)
        behind = (points[..., 2] <= 0.0).any(axis=-1)
        errors.append(np.where(behind, np.inf, np.sqrt(np.nanmean(distances**2, axis=-1))))
    return np.minimum(*errors)


def _seen(uv: FloatArray) -> BoolArray:
    return np.isfinite(uv[..., 0]) & np.isfinite(uv[..., 1])


def _object_points(board: Board, seen: Sequence[BoolArray]) -> _Points:
    return [board.points[mask].astype(np.float32) for mask in seen]


def _image_points(views: Sequence[View], camera: int, seen: Sequence[BoolArray]) -> _Points:
    return [view.uv[camera][mask].astype(np.float32) for view, mask in zip(views, seen, strict=True)]


def _size(views: Sequence[View]) -> tuple[int, int]:
    height, width = views[0].images[0].shape
    return width, height


def _camera(size: tuple[int, int], mono: MonoCalibration) -> CameraModel:
    K = mono.K
    try:
        return CameraModel(*size, K[0, 0], K[1, 1], K[0, 2], K[1, 2], mono.distortion[:4])
    except ValueError as error:
        raise ValueError(
            f"the views do not determine the lens ({error}); show the board in the image's corners"
        ) from error


def _transform(rotation: ArrayLike, translation: ArrayLike) -> FloatArray:
    """From OpenCV's rotation matrix or vector and translation."""
    R = np.asarray(rotation, dtype=np.float64)
    if R.size == 3:
        R = exp(R.ravel())
    return make_T(R, np.asarray(translation, dtype=np.float64).ravel())
