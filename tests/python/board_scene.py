"""Drawn pictures of a calibration board, through the exact lens model, and a small rig to take them with."""

from __future__ import annotations

from functools import cache

import cv2
import numpy as np
from rvdnav.calibration import Board, ImagePair
from rvdnav.camera import CameraModel
from rvdnav.images import PixelArray
from rvdnav.pose import exp, inverse_T, make_T
from rvdnav.pose.arrays import FloatArray
from rvdnav.rig import Rig, world_from_camchain

BOARD = Board(7, 5, 0.03)
RIG = Rig(
    (
        CameraModel(352, 288, 334.2, 334.6, 178.4, 141.7, [-0.2034, 0.0617, 0.00052, -0.00041]),
        CameraModel(352, 288, 336.0, 336.2, 173.6, 146.0, [-0.1987, 0.0583, -0.00038, 0.00055]),
    ),
    world_from_camchain(make_T(exp(np.array([0.005, 0.027, -0.005])), np.array([-0.12, 0.0004, 0.0015]))),
)
_SAMPLES = 3  # a pixel and axis
_TEXELS = 48  # a square
_MARGIN = 2 * _TEXELS


def T_cam0_boards(count: int, board: Board = BOARD, seed: int = 1) -> FloatArray:
    """Poses (count, 4, 4) in which both cameras see the board, at many places and tilts."""
    rng = np.random.default_rng(seed)
    poses: list[FloatArray] = []
    while len(poses) < count:
        R = exp(np.append(rng.uniform(-0.6, 0.6, 2), rng.uniform(-0.3, 0.3)))
        z = rng.uniform(0.4, 0.7)
        middle = np.array([0.06 + rng.uniform(-0.25, 0.25) * z, rng.uniform(-0.25, 0.25) * z, z])
        T = make_T(R, middle - R @ board.points.mean(axis=0))
        border = np.array([RIG.width - 1, RIG.height - 1]) - 8
        uv = exact_corners(T[None], board)[0]
        if ((uv > 8) & (uv < border)).all():
            poses.append(T)
    return np.stack(poses)


def exact_corners(T_cam0_board: FloatArray, board: Board = BOARD, rig: Rig = RIG) -> FloatArray:
    """Where the corners are imaged: (v, 2, n, 2), px."""
    T_cam1_cam0 = inverse_T(rig.T_world_cam[1]) @ rig.T_world_cam[0]
    uv = []
    for T in T_cam0_board:
        views = (T, T_cam1_cam0 @ T)
        uv.append([c.project(board.points @ V[:3, :3].T + V[:3, 3]) for c, V in zip(rig.cameras, views, strict=True)])
    return np.array(uv)


@cache
def _rays(camera: int) -> FloatArray:
    model = RIG.cameras[camera]
    inside = (np.arange(_SAMPLES) + 0.5) / _SAMPLES - 0.5
    u, v = ((np.arange(size)[:, None] + inside).ravel() for size in (model.width, model.height))
    return model.unproject(np.stack(np.meshgrid(u, v), axis=-1))


@cache
def _texture(board: Board) -> PixelArray:
    columns, rows = board.columns + 1, board.rows + 1
    if board.marker is None:
        squares = np.add.outer(np.arange(rows), np.arange(columns)) % 2 * 255
        texture = np.kron(squares, np.ones((_TEXELS, _TEXELS))).astype(np.uint8)
    else:
        texture = board.charuco().generateImage((columns * _TEXELS, rows * _TEXELS), marginSize=0, borderBits=1)
    return np.pad(texture, _MARGIN, constant_values=255)


def draw_board(camera: int, T_cam_board: FloatArray, board: Board = BOARD, *, blur: float = 0.6) -> PixelArray:
    """The board before a dark background, with a lens blur (sigma, px) and a little noise."""
    R, t = T_cam_board[:3, :3], T_cam_board[:3, 3]
    model = RIG.cameras[camera]
    fine = np.full((model.height * _SAMPLES, model.width * _SAMPLES), 60.0)
    part = _extent(model, T_cam_board, board)
    rays = _rays(camera)[part]
    depth = (R[:, 2] @ t) / (rays @ R[:, 2])
    xy = ((rays * depth[..., None] - t) @ R)[..., :2]
    texture = _texture(board)
    place = np.floor(xy / board.square * _TEXELS + _MARGIN + _TEXELS).astype(int)
    inside = ((place >= 0) & (place < texture.shape[::-1])).all(axis=-1)
    x, y = np.where(inside[..., None], place, 0).transpose(2, 0, 1)
    fine[part] = np.where(inside, texture[y, x], 60.0)
    pixels = fine.reshape(model.height, _SAMPLES, model.width, _SAMPLES).mean(axis=(1, 3))
    pixels = cv2.GaussianBlur(pixels, (0, 0), blur) * 0.7 + 20.0
    noise = np.random.default_rng(int(abs(t).sum() * 1e6) + camera).normal(0.0, 1.0, pixels.shape)
    return np.clip(np.rint(pixels + noise), 0, 255).astype(np.uint8)


def _extent(model: CameraModel, T_cam_board: FloatArray, board: Board) -> tuple[slice, slice]:
    """Rows and columns of the samples that may show the board."""
    side = np.linspace(0.0, 1.0, 20)
    unit = np.array([(a, b) for a in side for b in side])
    points = (unit * (board.columns + 5, board.rows + 5) - 3.0) * board.square
    uv = model.project(points @ T_cam_board[:3, :2].T + T_cam_board[:3, 3])
    low, high = (np.nanmin(uv, axis=0) - 1) * _SAMPLES, (np.nanmax(uv, axis=0) + 2) * _SAMPLES
    (u0, v0), (u1, v1) = np.maximum(low, 0).astype(int), np.maximum(high, 1).astype(int)
    return slice(v0, v1), slice(u0, u1)


def draw_pair(name: str, T_cam0_board: FloatArray, board: Board = BOARD) -> ImagePair:
    """The board as both cameras see it."""
    T_cam1_cam0 = inverse_T(RIG.T_world_cam[1]) @ RIG.T_world_cam[0]
    return ImagePair(name, (draw_board(0, T_cam0_board, board), draw_board(1, T_cam1_cam0 @ T_cam0_board, board)))
