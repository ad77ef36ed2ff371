"""The files of a rig: `camchain.yaml` (Kalibr) and `rig.yaml`."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from rvdnav.camera import CameraModel
from rvdnav.conventions import rigid_transform
from rvdnav.errors import InputError, one_line
from rvdnav.files import write_text_atomically
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import inverse_T
from rvdnav.rig.chain import CameraChain, check_side, within_reach
from rvdnav.rig.covariance import calibration_parameters
from rvdnav.rig.rig import AGREEMENT, Rig
from rvdnav.rig.timing import LONGEST_NS, SCANS
from rvdnav.yamlio import Section, read_yaml

CAMCHAIN = "camchain.yaml"
RIG = "rig.yaml"
_COVARIANCE = "calibration_covariance"
_EXACT = "exact"
"""In its place: of rendered images."""
_CAMERA_KEYS = ("camera_model", "intrinsics", "distortion_model", "distortion_coeffs", "resolution", "T_cn_cnm1")
_OTHERS_KEYS = ("rostopic", "cam_overlaps", "T_cam_imu", "T_imu_cam", "timeshift_cam_imu", "line_delay")
"""What Kalibr and those who read its files write besides; no concern of ours."""
_DURATIONS = ("exposure_ns", "line_delay_ns", "field_delay_ns")


def load_rig(folder: str | Path, notices: list[str] | None = None) -> Rig:
    """The rig that `camchain.yaml` (Kalibr; pinhole with radtan) and, if it is there, `rig.yaml` of a folder describe.

    Without `rig.yaml` the world of two cameras is derived (`world_from_camchain`), that of one is its own frame, and
    the calibration's covariance is not known.  Keys of `camchain.yaml` that nobody knows are told to `notices`.
    Raises InputError naming the file when it is missing or malformed, holds a model other than ours, no usable rig,
    or a key that looks mistyped, or when the two files disagree by more than 1e-6.
    """
    notices = [] if notices is None else notices
    return place_rig(_read_camchain(Path(folder) / CAMCHAIN, notices), folder, notices)


def place_rig(chain: CameraChain, folder: str | Path, notices: list[str]) -> Rig:
    """The rig of calibrated cameras as `rig.yaml` of a folder places it, or as `load_rig` does without that file.

    Raises InputError naming the file that is at fault.
    """
    notices += chain.folds()
    rig = chain.rig
    if not os.path.lexists(Path(folder) / RIG):
        return within_reach(chain.path, rig)
    names = [f"cam{index}" for index in range(len(chain.cameras))]
    placed = read_yaml(Path(folder) / RIG)
    placed.only("T_world_cam0", "T_world_cam1", _COVARIANCE, "scan", *_DURATIONS)
    T_world_cam = [_read_transform(placed, f"T_world_{name}") for name in names]
    if rig.is_stereo:
        _check_agreement(placed.path, chain.path.name, T_world_cam, rig.T_world_cam)
    rig = within_reach(placed.path, Rig(chain.cameras, T_world_cam))
    return _with_timing(_with_covariance(rig, placed), placed)


def _read_camchain(path: Path, notices: list[str]) -> CameraChain:
    chain = read_yaml(path)
    if len([key for key in chain if re.fullmatch("cam[0-9]+", key)]) > 2:
        raise InputError(f"{chain.path}: more than two cameras")
    unknown = chain.others("cam0", "cam1", likeness=0.7)  # short names, of which none is like another
    names = ["cam0", "cam1"] if "cam1" in chain else ["cam0"]
    for name in names:
        section = chain.section(name)
        unknown += [f"{name}.{key}" for key in section.others(*_CAMERA_KEYS, *_OTHERS_KEYS)]
    notices += [f"{CAMCHAIN}: {key} is not known and not read" for key in map(one_line, unknown)]
    cameras = tuple(_read_camera(chain.section(name)) for name in names)
    stereo = len(cameras) == 2
    return CameraChain(path, cameras, _read_transform(chain.section("cam1"), "T_cn_cnm1") if stereo else None)


def _read_camera(section: Section) -> CameraModel:
    for key, ours in (("camera_model", "pinhole"), ("distortion_model", "radtan")):
        if section.text(key) != ours:
            raise section.fault(key, f"{section.text(key)!r} is not supported, only {ours!r}")
    try:
        width, height = check_side(*section.numbers("resolution", 2).tolist())
    except ValueError as error:
        raise section.fault("resolution", str(error)) from error
    fx, fy, cx, cy = section.numbers("intrinsics", 4).tolist()
    distortion = section.numbers("distortion_coeffs", 4)
    try:
        return CameraModel(width, height, fx, fy, cx, cy, distortion)
    except ValueError as error:
        raise InputError(f"{section.path}: {section.prefix[:-1]}: {error}") from error


def _read_transform(section: Section, key: str) -> FloatArray:
    values = section.numbers(key, 4, 4)
    try:
        return rigid_transform(values)
    except ValueError as error:
        raise section.fault(key, f"is not a rigid transform: {error}") from error


def _with_covariance(rig: Rig, placed: Section) -> Rig:
    if _COVARIANCE not in placed:
        return rig
    if placed.values[_COVARIANCE] == _EXACT:
        size = len(calibration_parameters(len(rig.cameras)))
        return attrs.evolve(rig, calibration_covariance=np.zeros((size, size)))
    section = placed.section(_COVARIANCE)
    section.only("parameters", "matrix")
    names = calibration_parameters(len(rig.cameras))
    given = section.texts("parameters")
    if len(given) != len(names):
        raise section.fault("parameters", f"has {len(given)} names, not {len(names)}")
    for index, (name, wanted) in enumerate(zip(given, names, strict=True)):
        if name != wanted:
            raise section.fault(f"parameters[{index}]", f"is {name!r}, not {wanted!r}")
    matrix = section.numbers("matrix", len(names), len(names))
    try:
        return attrs.evolve(rig, calibration_covariance=matrix)
    except ValueError as error:
        raise section.fault("matrix", f"is not a covariance: {error}") from error


def _with_timing(rig: Rig, placed: Section) -> Rig:
    timing: dict[str, Any] = {key: placed.whole(key, 0, LONGEST_NS) for key in _DURATIONS if key in placed}
    if "scan" in placed:
        timing["scan"] = placed.text("scan")
        if timing["scan"] not in SCANS:
            raise placed.fault("scan", f"{timing['scan']!r} is none of {', '.join(SCANS)}")
    try:
        return attrs.evolve(rig, **timing)
    except ValueError as error:
        raise InputError(f"{placed.path}: {error}") from error


def _check_agreement(path: Path, other: str, given: list[FloatArray], derived: tuple[FloatArray, ...]) -> None:
    relative = np.abs(inverse_T(given[1]) @ given[0] - inverse_T(derived[1]) @ derived[0]).max()
    if relative > AGREEMENT:
        raise InputError(f"{path}: disagrees with {other} on cam0's pose in cam1 by {relative:.1e}")
    absolute = max(np.abs(a - b).max() for a, b in zip(given, derived, strict=True))
    if absolute > AGREEMENT:
        raise InputError(f"{path}: the world is not the one that {other} implies, by {absolute:.1e}")


def save_rig(rig: Rig, folder: str | Path) -> None:
    """Write a rig as `camchain.yaml` and `rig.yaml` of an existing folder, so that `load_rig` gives it back.

    Raises InputError naming the file when it cannot be written.
    """
    chain = ["# Kalibr camchain; cam0 = left, cam1 = right; lengths in metres"]
    for index, camera in enumerate(rig.cameras):
        chain += [
            f"cam{index}:",
            "  camera_model: pinhole",
            f"  intrinsics: {[camera.fx, camera.fy, camera.cx, camera.cy]}",
            "  distortion_model: radtan",
            f"  distortion_coeffs: {camera.distortion.tolist()}",
            f"  resolution: {[camera.width, camera.height]}",
            f"  rostopic: /cam{index}/image_raw",
        ]
    if rig.is_stereo:
        chain += ["  T_cn_cnm1:", *_matrix_lines(inverse_T(rig.T_world_cam[1]) @ rig.T_world_cam[0], "  ")]
    placed = ["# T_world_cam maps camera coordinates to the world W, metres"]
    for index, T in enumerate(rig.T_world_cam):
        placed += [f"T_world_cam{index}:", *_matrix_lines(T, "")]
    if rig.calibration_covariance is not None and not rig.calibration_covariance.any():
        placed.append(f"{_COVARIANCE}: {_EXACT}")
    elif rig.calibration_covariance is not None:
        placed += [
            "# of the calibration, px, rad, m; R_cam1_cam0 = exp([rx ry rz]x) R_hat",
            f"{_COVARIANCE}:",
            f"  parameters: [{', '.join(calibration_parameters(len(rig.cameras)))}]",
            "  matrix:",
            *_matrix_lines(rig.calibration_covariance, "  "),
        ]
    if rig.scan != "progressive":
        placed.append(f"scan: {rig.scan}")
    placed += [f"{key}: {getattr(rig, key)}" for key in _DURATIONS if getattr(rig, key)]
    write_text_atomically(Path(folder) / CAMCHAIN, "\n".join([*chain, ""]))
    write_text_atomically(Path(folder) / RIG, "\n".join([*placed, ""]))


def _matrix_lines(matrix: FloatArray, indent: str) -> list[str]:
    return [f"{indent}- [{', '.join(map(_number, row))}]" for row in matrix.tolist()]


def _number(value: float) -> str:
    """All digits of a number as YAML 1.1 knows one: not without a point, which Python leaves out of 1e-05."""
    text = repr(value)
    return text.replace("e", ".0e") if "e" in text and "." not in text else text
