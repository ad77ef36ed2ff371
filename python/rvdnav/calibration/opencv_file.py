"""OpenCV's FileStorage: writing a rig so that OpenCV 4 and 5 read it, and reading what they or their users wrote.

The names are those of OpenCV's stereo sample: M1, D1, M2, D2, R, T, in one file.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from rvdnav.calibration.storage import read_storage
from rvdnav.camera import CameraModel
from rvdnav.conventions import rigid_transform
from rvdnav.errors import InputError
from rvdnav.files import write_text_atomically
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import inverse_T, make_T
from rvdnav.rig import Rig, world_from_camchain
from rvdnav.yamlio import Section

OPENCV_FILE = "stereo_opencv.yaml"
_TERMS, _MOST_TERMS = 4, 14
"""Of the distortion: k1, k2, p1, p2, and all that OpenCV knows."""
_LARGEST_SIDE = 1 << 20


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
    storage = read_storage(path)
    try:
        size = [storage.whole(key, 1, _LARGEST_SIDE) for key in ("image_width", "image_height")]
        cameras = [_camera(storage, size, index) for index in (1, 2)]
        R, t = _numbers(storage, "R", 9).reshape(3, 3), _numbers(storage, "T", 3)
        T_cam1_cam0 = rigid_transform(make_T(R, t))
        return Rig(tuple(cameras), world_from_camchain(T_cam1_cam0))
    except ValueError as error:
        raise InputError(f"{path}: {error}") from error


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


def _numbers(storage: Section, key: str, least: int, most: int | None = None) -> FloatArray:
    """The numbers of a matrix, row by row; as many as `least` where no `most` is given."""
    if key not in storage:
        raise storage.fault(key, "is missing")
    try:
        values = np.array(storage.values[key]).ravel()
    except ValueError:  # rows of different lengths
        values = np.array([None])
    if values.dtype.kind not in "if" or not least <= len(values) <= (most or least) or not np.isfinite(values).all():
        raise storage.fault(key, f"is not a matrix of {least} numbers")
    return values.astype(np.float64)


def _camera(storage: Section, size: list[int], index: int) -> CameraModel:
    K = _numbers(storage, f"M{index}", 9)
    distortion = _numbers(storage, f"D{index}", _TERMS, _MOST_TERMS)
    if np.any(distortion[_TERMS:] != 0.0):
        terms = int(np.flatnonzero(distortion)[-1]) + 1
        raise storage.fault(f"D{index}", f"has {terms} terms; only k1, k2, p1, p2 are supported")
    if np.any(K.reshape(3, 3)[[0, 1, 2, 2, 2], [1, 0, 0, 1, 2]] != (0.0, 0.0, 0.0, 0.0, 1.0)):
        raise storage.fault(f"M{index}", "is not an intrinsic matrix without skew")
    width, height = size
    return CameraModel(width, height, K[0], K[4], K[2], K[5], distortion[:_TERMS])
