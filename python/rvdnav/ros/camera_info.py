"""The calibration that a bag brings along: CameraInfo messages, and where the cameras are, of their P or /tf_static."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from rvdnav.camera import CameraModel
from rvdnav.conventions import rigid_transform
from rvdnav.errors import InputError
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import inverse_T, make_T, rotation_from_quaternion_xyzw
from rvdnav.rig import CameraChain, check_side
from rvdnav.ros.bag import Bag, Images
from rvdnav.ros.topics import is_rectified

_MODELS = ("plumb_bob", "rational_polynomial", "")
_DEEPEST = 100
"""Frames from one to the root of their tree."""


def read_camera_infos(path: Path, bag: Bag) -> CameraChain:
    """What the bag at a path says of its cameras.

    Where a topic's images are rectified, its P is the camera, else K and D are; a D of more than four terms is refused
    unless the rest are zero.  The cameras lie to each other as R and P say, else as /tf_static says of their frames.
    Raises InputError naming the bag when it says too little, or something else than a pinhole with such a distortion.
    """
    sides = [images for images in (bag.left, bag.right) if images is not None]
    infos = [_only_info(path, images) for images in sides]
    try:
        cameras = tuple(_camera(info, images) for info, images in zip(infos, sides, strict=True))
        T_cam1_cam0 = None
        if len(sides) == 2:
            T_cam1_cam0 = _from_projections(infos, sides)
            if T_cam1_cam0 is None:
                T_cam1_cam0 = _from_transforms(bag, infos[0]["frame"], infos[1]["frame"])
    except ValueError as error:
        raise InputError(f"{path}: {error}") from error
    return CameraChain(path, cameras, T_cam1_cam0)


def _only_info(path: Path, images: Images) -> dict[str, Any]:
    if not images.camera_infos:
        raise InputError(f"{path}: has no camera_info beside {images.topic}, and there is no camchain.yaml")
    if len(images.camera_infos) > 1:
        raise InputError(f"{path}: the camera_info beside {images.topic} changes")
    return images.camera_infos[0]


def _camera(info: dict[str, Any], images: Images) -> CameraModel:
    told = f"the camera_info beside {images.topic}"
    K, R, P = (np.array(info[name]) for name in "krp")
    if not all(np.isfinite(values).all() for values in (K, R, P, np.array(info["d"]))):
        raise ValueError(f"{told} has numbers that are not finite")
    if any(size > 1 for size in info["binning"]):
        raise ValueError(f"{told} has pixels binned, which is not supported")
    if any(info["region"]) and info["region"] != [0, 0, *info["size"]]:
        raise ValueError(f"{told} has a region of interest, which is not supported")
    try:
        width, height = check_side(*info["size"])
    except ValueError as error:
        raise ValueError(f"{told}: the size {error}") from error
    distortion = [*info["d"], 0.0, 0.0, 0.0, 0.0]
    if is_rectified(images.topic):
        K, distortion = np.delete(P.reshape(3, 4), 3, axis=1).ravel(), [0.0] * 4
    elif info["model"] not in _MODELS or any(distortion[4:]):
        raise ValueError(
            f"{told} has the distortion {info['model']!r} {info['d']}, only plumb_bob of k1 k2 p1 p2 is read"
        )
    if not K.any():
        raise ValueError(f"{told} says that the camera is not calibrated, and there is no camchain.yaml")
    if K[1] or K[3] or K[6] or K[7] or K[8] != 1.0:
        raise ValueError(f"{told} has a camera matrix with more than fx, fy, cx, cy")
    try:
        return CameraModel(width, height, K[0], K[4], K[2], K[5], distortion[:4])
    except ValueError as error:
        raise ValueError(f"{told}: {error}") from error


def _from_projections(infos: list[dict[str, Any]], sides: list[Images]) -> FloatArray | None:
    """T_cam1_cam0 by R and P of both; None where P has no baseline.

    A point's coordinates in a camera's rectified frame are R p; P = [K' | K' t], where t is the camera's shift against
    the left one in the frame that both share.
    """
    shifts, turns = [], []
    for info, images in zip(infos, sides, strict=True):
        P = np.array(info["p"]).reshape(3, 4)
        if not P[0, 0] > 0.0 or not P[1, 1] > 0.0:
            return None
        shifts.append(np.array([P[0, 3] / P[0, 0], P[1, 3] / P[1, 1], 0.0]))
        R = np.eye(4)
        R[:3, :3] = np.eye(3) if is_rectified(images.topic) else np.array(info["r"]).reshape(3, 3)
        turns.append(R)
    if not (shifts[1] - shifts[0]).any():
        return None
    try:
        left, right = (rigid_transform(R) for R in turns)
    except ValueError as error:
        raise ValueError(f"R of a camera_info is none: {error}") from error
    return inverse_T(right) @ make_T(np.eye(3), shifts[1] - shifts[0]) @ left


def _from_transforms(bag: Bag, left: str, right: str) -> FloatArray:
    """T_cam1_cam0 by the frames of the cameras.  Raises ValueError where these do not hang together."""
    above: dict[str, tuple[str, FloatArray]] = {}
    for frame, child, xyz, xyzw in bag.transforms:
        norm = float(np.linalg.norm(xyzw))
        if not (np.isfinite([*xyz, *xyzw]).all() and abs(norm - 1.0) < 1e-3):
            raise ValueError(f"/tf_static has no transform from {child} to {frame}")
        above[child] = (frame, make_T(rotation_from_quaternion_xyzw(np.array(xyzw)), np.array(xyz)))
    (root_left, T_root_left), (root_right, T_root_right) = (_to_root(above, name) for name in (left, right))
    if root_left != root_right or left == right:
        raise ValueError(
            "neither P of the camera_info nor /tf_static says how the cameras lie to each other, and there is no "
            "camchain.yaml"
        )
    return inverse_T(T_root_right) @ T_root_left


def _to_root(above: dict[str, tuple[str, FloatArray]], frame: str) -> tuple[str, FloatArray]:
    frame, T_root_frame = frame.lstrip("/"), np.eye(4)
    for _ in range(_DEEPEST):
        if frame not in above:
            return frame, T_root_frame
        frame, T_above = above[frame]
        T_root_frame = T_above @ T_root_frame
    raise ValueError(f"/tf_static has more than {_DEEPEST} frames above another")
