"""What a calibration with a flat board may err: the covariance that a budget assumes where a rig has none of its own.

The views' own poses are unknowns beside the rig's parameters, as in every such calibration (Z. Zhang, "A flexible new
technique for camera calibration", PAMI 22, 2000), so errors that they can take over, such as a shift of the principal
point with a turn of the camera, are large, and correlated.
"""

from __future__ import annotations

import numpy as np

from rvdnav.pose import exp
from rvdnav.pose.arrays import BoolArray, FloatArray
from rvdnav.rig import Rig, calibration_steps

VIEWS, CORNER_SIGMA_PX = 20, 0.1
_COLUMNS, _ROWS, _SQUARE_M = 9, 6, 0.025
_TILT = np.radians(35.0)
# Width of the board, and how far its middle is from the image's, as parts of the image.
_WIDTHS, _ASIDE = (0.35, 0.75), 0.3
_POSE_STEP = 1e-6


def board_calibration_covariance(rig: Rig) -> FloatArray:
    """Covariance (8, 8) or (22, 22), in the order of `calibration_parameters`, of a calibration with such a board.

    There are 20 stereo views, spread over the field and tilted by up to 35 degrees, of 9 x 6 corners found to 0.1 px.
    """
    steps = calibration_steps(len(rig.cameras))
    normal = np.zeros((len(steps), len(steps)))
    changed = [(rig.perturbed(delta), rig.perturbed(-delta)) for delta in np.diag(steps)]
    for corners in board_views(rig):
        seen = _seen(rig, corners)
        by_rig = [
            (_images(above, corners) - _images(below, corners))[seen].ravel() / (2.0 * step)
            for (above, below), step in zip(changed, steps, strict=True)
        ]
        by_pose = [
            (_images(rig, corners + _POSE_STEP * shift) - _images(rig, corners - _POSE_STEP * shift))[seen].ravel()
            / (2.0 * _POSE_STEP)
            for shift in _motions(corners)
        ]
        A, B = (np.stack(columns, axis=1) for columns in (by_rig, by_pose))
        # What is left of the rig's part once the view's pose has taken what it can.
        rest = A - B @ np.linalg.lstsq(B, A, rcond=None)[0]
        normal += rest.T @ rest
    units = 1.0 / np.sqrt(np.diagonal(normal))
    covariance: FloatArray = np.linalg.inv(normal * np.outer(units, units)) * np.outer(units, units)
    symmetric: FloatArray = CORNER_SIGMA_PX**2 * 0.5 * (covariance + covariance.T)
    return symmetric


def board_views(rig: Rig) -> list[FloatArray]:
    """The corners (54, 3) of each view, m in the left camera's frame."""
    rng = np.random.default_rng(1)
    camera = rig.cameras[0]
    flat = np.stack(np.meshgrid(np.arange(_COLUMNS), np.arange(_ROWS), [0.0]), axis=-1).reshape(-1, 3) * _SQUARE_M
    flat -= flat.mean(axis=0)
    boards = []
    for _ in range(VIEWS):
        direction = rng.uniform(0.0, 2.0 * np.pi)
        R = exp(_TILT * rng.uniform(0.3, 1.0) * np.array([np.cos(direction), np.sin(direction), 0.0]))
        depth = float(np.ptp(flat[:, 0])) * camera.fx / (rng.uniform(*_WIDTHS) * camera.width)
        aside = rng.uniform(-_ASIDE, _ASIDE, 2) * (camera.width / camera.fx, camera.height / camera.fy)
        boards.append(flat @ R.T + depth * np.array([*aside, 1.0]))
    return boards


def _motions(corners: FloatArray) -> list[FloatArray]:
    """By what (54, 3) the corners move with each of the board's six degrees of freedom."""
    middle = corners.mean(axis=0)
    shifts = [np.broadcast_to(axis, corners.shape) for axis in np.eye(3)]
    return [*shifts, *(np.cross(axis, corners - middle) for axis in np.eye(3))]


def _images(rig: Rig, corners: FloatArray) -> FloatArray:
    """Pixels (cameras, 54, 2) of corners in the left camera's frame."""
    T_world_left = rig.T_world_cam[0]
    p_W = corners @ T_world_left[:3, :3].T + T_world_left[:3, 3]
    return np.stack([rig.project(index, p_W) for index in range(len(rig.cameras))])


def _seen(rig: Rig, corners: FloatArray) -> BoolArray:
    return rig.on_image(_images(rig, corners))
