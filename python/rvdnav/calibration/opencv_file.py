"""OpenCV's FileStorage: writing a rig so that OpenCV 4 and 5 read it, and reading what they or their users wrote.

The names are those of OpenCV's stereo sample: M1, D1, M2, D2, R, T, in one file.
"""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from rvdnav.camera import CameraModel
from rvdnav.conventions import rigid_transform
from rvdnav.errors import InputError
from rvdnav.files import read_text, write_text_atomically
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import inverse_T, make_T
from rvdnav.rig import Rig, world_from_camchain

OPENCV_FILE = "stereo_opencv.yaml"
_TERMS = 4  # of the distortion: k1, k2, p1, p2


def save_opencv(rig: Rig, path: Path) -> None:
    """Write a stereo rig as an OpenCV FileStorage (YAML): M1, D1, M2, D2, R, T of cam0 to cam1, m, and the image size.

    The header is the one that OpenCV 4 and 5 both accept.  Raises InputError naming the file when it cannot be written.
    """
    T_cam1_cam0 = inverse_T(rig.T_world_cam[1]) @ rig.T_world_cam[0]
    lines = ["%YAML:1.0", "---", f"image_width: {rig.width}", f"image_height: {rig.height}"]
    for index, camera in enumerate(rig.cameras, start=1):
        lines += _matrix(f"M{index}", camera.K) + _matrix(f"D{index}", np.append(camera.distortion, 0.0)[None])
    lines += _matrix("R", T_cam1_cam0[:3, :3]) + _matrix("T", T_cam1_cam0[:3, 3:])
    write_text_atomically(path, "\n".join([*lines, ""]))


def load_opencv(path: Path) -> Rig:
    """The stereo rig in an OpenCV FileStorage with M1, D1, M2, D2, R, T and image_width and image_height.

    Raises InputError naming the file when something is missing, or when a distortion has terms beyond k1, k2, p1, p2
    that are not zero: such a model is another one and is not cut short.
    """
    read_text(path)  # for the plain faults, in plain words
    try:
        storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    except (cv2.error, SystemError) as error:
        raise InputError(f"{path}: is not an OpenCV FileStorage") from error
    try:
        size = [_number(path, storage, key) for key in ("image_width", "image_height")]
        cameras = [_camera(path, storage, size, index) for index in (1, 2)]
        R, t = _read(path, storage, "R", 9).reshape(3, 3), _read(path, storage, "T", 3)
        T_cam1_cam0 = rigid_transform(make_T(R, t))
        return Rig(tuple(cameras), world_from_camchain(T_cam1_cam0))
    except ValueError as error:
        raise InputError(f"{path}: {error}") from error
    finally:
        storage.release()


def _matrix(name: str, values: FloatArray) -> list[str]:
    numbers = ", ".join(repr(float(value)) for value in values.ravel())
    rows, columns = values.shape
    return [
        f"{name}: !!opencv-matrix",
        f"   rows: {rows}",
        f"   cols: {columns}",
        "   dt: d",
        f"   data: [ {numbers} ]",
    ]


def _number(path: Path, storage: cv2.FileStorage, key: str) -> int:
    node = storage.getNode(key)
    if not node.isInt():
        raise InputError(f"{path}: {key} is missing or not a whole number")
    return int(node.real())


def _read(path: Path, storage: cv2.FileStorage, key: str, least: int) -> FloatArray:
    node = storage.getNode(key)
    matrix = None if node.empty() or not node.isMap() else node.mat()
    if matrix is None:
        raise InputError(f"{path}: {key} is missing or not a matrix")
    values = np.asarray(matrix, dtype=np.float64).ravel()
    if len(values) < least or not np.isfinite(values).all():
        raise InputError(f"{path}: {key} is not a matrix of {least} numbers")
    return values


def _camera(path: Path, storage: cv2.FileStorage, size: list[int], index: int) -> CameraModel:
    K = _read(path, storage, f"M{index}", 9)
    distortion = _read(path, storage, f"D{index}", _TERMS)
    if np.any(distortion[_TERMS:] != 0.0):
        terms = int(np.flatnonzero(distortion)[-1]) + 1
        raise InputError(f"{path}: D{index} has {terms} terms; only k1, k2, p1, p2 are supported")
    if np.any(K.reshape(3, 3)[[0, 1, 2, 2, 2], [1, 0, 0, 1, 2]] != (0.0, 0.0, 0.0, 0.0, 1.0)):
        raise InputError(f"{path}: M{index} is not an intrinsic matrix without skew")
    width, height = size
    return CameraModel(width, height, K[0], K[4], K[2], K[5], distortion[:_TERMS])
