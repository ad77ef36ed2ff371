"""The `sensor.yaml` of a camera in the EuRoC/ASL layout."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rvdnav.camera import CameraModel
from rvdnav.conventions import rigid_transform
from rvdnav.errors import InputError
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import inverse_T
from rvdnav.rig.chain import CameraChain, check_side
from rvdnav.yamlio import Section, read_yaml

SENSOR = "sensor.yaml"


def read_sensors(paths: Sequence[Path]) -> CameraChain:
    """What the files of one camera, or of the left and the right one, say: pinholes with radial-tangential distortion.

    Raises InputError naming the file when it is malformed or holds another model.
    """
    sections = [read_yaml(path) for path in paths]
    cameras = tuple(_read_camera(section) for section in sections)
    if len(sections) == 1:
        return CameraChain(paths[0], cameras, None)
    T_body_cam0, T_body_cam1 = (_read_placed(section) for section in sections)
    return CameraChain(paths[1], cameras, inverse_T(T_body_cam1) @ T_body_cam0)


def _read_camera(section: Section) -> CameraModel:
    for key, known in (("camera_model", ("pinhole",)), ("distortion_model", ("radial-tangential", "radtan"))):
        if section.text(key) not in known:
            raise section.fault(key, f"{section.text(key)!r} is not supported, only {known[0]!r}")
    try:
        width, height = check_side(*section.numbers("resolution", 2).tolist())
    except ValueError as error:
        raise section.fault("resolution", str(error)) from error
    fx, fy, cx, cy = section.numbers("intrinsics", 4).tolist()
    try:
        return CameraModel(width, height, fx, fy, cx, cy, section.numbers("distortion_coefficients", 4))
    except ValueError as error:
        raise InputError(f"{section.path}: {error}") from error


def _read_placed(section: Section) -> FloatArray:
    """T_BS, which maps the camera's coordinates to the body's: as OpenCV writes a matrix, with its tag or without."""
    if isinstance(section.values.get("T_BS"), dict):
        values = section.section("T_BS").numbers("data", 16).reshape(4, 4)
    else:
        values = section.numbers("T_BS", 4, 4)
    try:
        return rigid_transform(values)
    except ValueError as error:
        raise section.fault("T_BS", f"is not a rigid transform: {error}") from error
