"""The camera rig: one or two calibrated cameras, their place in the world W, and the rectified frame they share."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import ArrayLike

from rvdnav.camera import CameraModel
from rvdnav.conventions import rigid_transform
from rvdnav.errors import InputError
from rvdnav.files import write_text_atomically
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import inverse_T, make_T
from rvdnav.yamlio import Section, read_yaml

CAMCHAIN = "camchain.yaml"
RIG = "rig.yaml"
MIN_BASELINE_M = 1e-3
"""Below this two camera centres count as one."""
_AGREEMENT = 1e-6
_MIN_FORWARD = 0.5
"""Least cosine between an axis of a camera and the rig's: 60 degrees."""


def _transforms(values: Iterable[ArrayLike]) -> tuple[FloatArray, ...]:
    return tuple(rigid_transform(value) for value in values)


def _cameras(values: Iterable[CameraModel]) -> tuple[CameraModel, ...]:
    return tuple(values)


def _same_transforms(a: tuple[FloatArray, ...], b: tuple[FloatArray, ...]) -> bool:
    return len(a) == len(b) and all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


@attrs.frozen
class Rig:
    """One camera, or a stereo pair with the left camera first.

    cameras: the models, of one image size.  T_world_cam: for each the transform (4, 4) from its frame to W, m.
    With two cameras W has its origin in the right camera's centre and z_W towards the left one's.

    The rectified frame of a camera has its centre and the axes of `R_world_rect`, the focal length `focal_rect`, and
    coordinates in px relative to its principal point.

    Raises ValueError when the sizes differ, a transform is not rigid, or two cameras do not form a stereo pair in W.
    """

    cameras: tuple[CameraModel, ...] = attrs.field(converter=_cameras)
    T_world_cam: tuple[FloatArray, ...] = attrs.field(converter=_transforms, eq=attrs.cmp_using(eq=_same_transforms))

    def __attrs_post_init__(self) -> None:
        if len(self.cameras) not in (1, 2):
            raise ValueError(f"a rig has one or two cameras, not {len(self.cameras)}")
        if len(self.T_world_cam) != len(self.cameras):
            raise ValueError(f"{len(self.cameras)} cameras but {len(self.T_world_cam)} transforms")
        if self.is_stereo:
            self._check_stereo()

    def _check_stereo(self) -> None:
        left, right = self.cameras
        if (left.width, left.height) != (right.width, right.height):
            raise ValueError(f"the resolutions differ: {left.width}x{left.height} and {right.width}x{right.height}")
        T_left, T_right = self.T_world_cam
        if T_left[2, 3] - T_right[2, 3] < MIN_BASELINE_M:
            raise ValueError("the baseline is zero or cam0 does not lie towards z_W")
        if np.abs(T_right[:3, 3]).max() > _AGREEMENT or np.abs(T_left[:2, 3]).max() > _AGREEMENT:
            raise ValueError("the world's origin is not cam1's centre with z_W towards cam0's")
        for index in range(2):
            x, _, z = np.diag(self.R_rect_cam(index))
            if z < _MIN_FORWARD:
                raise ValueError(f"cam{index} does not look the way of the rig (more than 60 degrees off x_W)")
            if x < _MIN_FORWARD:
                raise ValueError("cam0 is not the left camera (swapped, or rolled by more than 60 degrees)")

    @property
    def is_stereo(self) -> bool:
        """Whether there are two cameras."""
        return len(self.cameras) == 2

    @property
    def baseline(self) -> float:
        """Distance between the camera centres, m; 0 with one camera."""
        return float(np.linalg.norm(self.T_world_cam[0][:3, 3] - self.T_world_cam[-1][:3, 3]))

    @property
    def width(self) -> int:
        """Of the images, px."""
        return self.cameras[0].width

    @property
    def height(self) -> int:
        """Of the images, px."""
        return self.cameras[0].height

    @property
    def focal_rect(self) -> float:
        """Focal length of the rectified views, px: the mean of fx and fy of all cameras."""
        return float(np.mean([(camera.fx, camera.fy) for camera in self.cameras]))

    @property
    def R_world_rect(self) -> FloatArray:
        """Rotation (3, 3) from the rectified axes to W.

        With two cameras x = -z_W, y = y_W, z = x_W, so that epipolar lines are rows.  A single camera has no epipolar
        lines; its rectified axes are its own.
        """
        if not self.is_stereo:
            return self.T_world_cam[0][:3, :3]
        return np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])

    def R_rect_cam(self, camera: int) -> FloatArray:
        """Rotation (3, 3) from a camera's axes to the rectified ones."""
        rotation: FloatArray = self.R_world_rect.T @ self.T_world_cam[camera][:3, :3]
        return rotation

    def project(self, camera: int, p_W: FloatArray) -> FloatArray:
        """Raw pixels (..., 2) of points (..., 3) in W, m; NaN where `CameraModel.project` says so."""
        T = self.T_world_cam[camera]
        return self.cameras[camera].project((np.asarray(p_W) - T[:3, 3]) @ T[:3, :3])

    def project_rect(self, camera: int, p_W: FloatArray) -> FloatArray:
        """Rectified coordinates (..., 2), px, of points (..., 3) in W, m; NaN for a point that is not in front."""
        return self._to_rect((np.asarray(p_W) - self.T_world_cam[camera][:3, 3]) @ self.R_world_rect)

    def raw_to_rect(self, camera: int, uv: FloatArray) -> FloatArray:
        """Rectified coordinates (..., 2), px, of raw pixels (..., 2); NaN where no ray is imaged to the pixel."""
        return self._to_rect(self.cameras[camera].unproject(uv) @ self.R_rect_cam(camera).T)

    def rect_to_raw(self, camera: int, xy: FloatArray) -> FloatArray:
        """Raw pixels (..., 2) of rectified coordinates (..., 2), px; the inverse of `raw_to_rect`."""
        xy = np.asarray(xy, dtype=np.float64)
        rays = np.concatenate([xy, np.full_like(xy[..., :1], self.focal_rect)], axis=-1)
        return self.cameras[camera].project(rays @ self.R_rect_cam(camera))

    def projection_matrix(self, camera: int) -> FloatArray:
        """The paper's M_l or M_r (3, 4) of eq. (1) for a rectified view: homogeneous p_W, m, to homogeneous xy, px.

        Its third row gives the depth z along x_W, m.
        """
        K = np.diag([self.focal_rect, self.focal_rect, 1.0])
        T_rect_world = inverse_T(make_T(self.R_world_rect, self.T_world_cam[camera][:3, 3]))
        matrix: FloatArray = K @ T_rect_world[:3]
        return matrix

    def _to_rect(self, p_rect: FloatArray) -> FloatArray:
        z = np.where(p_rect[..., 2:] > 0.0, p_rect[..., 2:], np.nan)
        xy: FloatArray = self.focal_rect * p_rect[..., :2] / z
        return xy


def world_from_camchain(T_cam1_cam0: FloatArray) -> tuple[FloatArray, FloatArray]:
    """T_world_cam0 and T_world_cam1 (4, 4) from the pose (4, 4) of the left camera in the right one's frame.

    W: origin in the right camera's centre, z_W from there to the left one's, x_W along the sum of both optical axes
    made orthogonal to z_W, y_W = z_W x x_W.
    Raises ValueError when the centres coincide or the sum of the optical axes lies along the baseline.
    """
    R, center0 = T_cam1_cam0[:3, :3], T_cam1_cam0[:3, 3]
    baseline = float(np.linalg.norm(center0))
    if not baseline >= MIN_BASELINE_M:
        raise ValueError(f"the baseline is zero ({baseline:.1e} m)")
    z = center0 / baseline
    axes = R[:, 2] + (0.0, 0.0, 1.0)
    x = axes - (axes @ z) * z
    if np.linalg.norm(x) < 0.1:
        raise ValueError("the cameras look along the baseline or against each other")
    x /= np.linalg.norm(x)
    R_world_cam1 = np.stack([x, np.cross(z, x), z])
    T_world_cam0 = make_T(R_world_cam1 @ R, np.array([0.0, 0.0, baseline]))
    return T_world_cam0, make_T(R_world_cam1, np.zeros(3))


def load_rig(folder: str | Path) -> Rig:
    """The rig that `camchain.yaml` (Kalibr; pinhole with radtan) and, if it is there, `rig.yaml` of a folder describe.

    Without `rig.yaml` the world of two cameras is derived (`world_from_camchain`) and that of one is its own frame.
    Raises InputError naming the file when it is missing or malformed, holds a model other than ours, or no usable rig,
    or when the two files disagree by more than 1e-6.
    """
    chain = read_yaml(Path(folder) / CAMCHAIN)
    if len([key for key in chain if re.fullmatch("cam[0-9]+", key)]) > 2:
        raise InputError(f"{chain.path}: more than two cameras")
    names = ["cam0", "cam1"] if "cam1" in chain else ["cam0"]
    cameras = [_read_camera(chain.section(name)) for name in names]
    derived: tuple[FloatArray, ...] = (np.eye(4),)
    if len(cameras) == 2:
        T_cam1_cam0 = _read_transform(chain.section("cam1"), "T_cn_cnm1")
        try:
            derived = world_from_camchain(T_cam1_cam0)
            Rig(cameras, derived)
        except ValueError as error:
            raise InputError(f"{chain.path}: {error}") from error
    if not (chain.path.parent / RIG).exists():
        return Rig(cameras, derived)
    placed = read_yaml(chain.path.parent / RIG)
    T_world_cam = [_read_transform(placed, f"T_world_{name}") for name in names]
    if len(cameras) == 2:
        _check_agreement(placed.path, T_world_cam, derived)
    return Rig(cameras, T_world_cam)


def _read_camera(section: Section) -> CameraModel:
    for key, ours in (("camera_model", "pinhole"), ("distortion_model", "radtan")):
        if section.text(key) != ours:
            raise section.fault(key, f"{section.text(key)!r} is not supported, only {ours!r}")
    width, height = section.numbers("resolution", 2)
    if width != int(width) or height != int(height):
        raise section.fault("resolution", "is not two whole numbers")
    fx, fy, cx, cy = section.numbers("intrinsics", 4).tolist()
    distortion = section.numbers("distortion_coeffs", 4)
    try:
        return CameraModel(int(width), int(height), fx, fy, cx, cy, distortion)
    except ValueError as error:
        raise InputError(f"{section.path}: {section.prefix[:-1]}: {error}") from error


def _read_transform(section: Section, key: str) -> FloatArray:
    values = section.numbers(key, 4, 4)
    try:
        return rigid_transform(values)
    except ValueError as error:
        raise section.fault(key, f"is not a rigid transform: {error}") from error


def _check_agreement(path: Path, given: list[FloatArray], derived: tuple[FloatArray, ...]) -> None:
    relative = np.abs(inverse_T(given[1]) @ given[0] - inverse_T(derived[1]) @ derived[0]).max()
    if relative > _AGREEMENT:
        raise InputError(f"{path}: disagrees with {CAMCHAIN} on cam0's pose in cam1 by {relative:.1e}")
    absolute = max(np.abs(a - b).max() for a, b in zip(given, derived, strict=True))
    if absolute > _AGREEMENT:
        raise InputError(f"{path}: the world is not the one that {CAMCHAIN} implies, by {absolute:.1e}")


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
    write_text_atomically(Path(folder) / CAMCHAIN, "\n".join([*chain, ""]))
    write_text_atomically(Path(folder) / RIG, "\n".join([*placed, ""]))


def _matrix_lines(T: FloatArray, indent: str) -> list[str]:
    return [f"{indent}- {row}" for row in T.tolist()]
