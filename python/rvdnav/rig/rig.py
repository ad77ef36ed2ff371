"""The camera rig: one or two calibrated cameras, their place in the world W, and the rectified frame they share."""

from __future__ import annotations

import operator
from collections.abc import Iterable
from functools import cached_property
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike

from rvdnav.camera import CameraModel
from rvdnav.conventions import rigid_transform
from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray, float_array
from rvdnav.pose.so3 import exp, inverse_T, make_T
from rvdnav.rig.covariance import (
    CAMERA_PARAMETERS,
    calibration_covariance,
    calibration_parameters,
    hand_calibration_covariance,
)
from rvdnav.rig.timing import LONGEST_NS, SCANS, row_delays_ns

MIN_BASELINE_M = 1e-3
"""Below this two camera centres count as one."""
AGREEMENT = 1e-6
"""Difference up to which statements of one transform or of W agree."""
_MIN_FORWARD = 0.5
"""Least cosine between an axis of a camera and the rig's: 60 degrees."""


def _transforms(values: Iterable[ArrayLike]) -> tuple[FloatArray, ...]:
    return tuple(rigid_transform(value) for value in values)


def _cameras(values: Iterable[CameraModel]) -> tuple[CameraModel, ...]:
    return tuple(values)


def _same_transforms(a: tuple[FloatArray, ...], b: tuple[FloatArray, ...]) -> bool:
    return len(a) == len(b) and all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


def _same_covariance(a: FloatArray | None, b: FloatArray | None) -> bool:
    return a is b if a is None or b is None else np.array_equal(a, b)


def _duration(_: Any, attribute: attrs.Attribute[Any], value: int) -> None:
    if not 0 <= value <= LONGEST_NS:
        raise ValueError(f"{attribute.name} is not from 0 to {LONGEST_NS} ns")


def _duration_field() -> Any:
    return attrs.field(default=0, converter=operator.index, validator=_duration)


@attrs.frozen
class Rig:
    """One camera, or a stereo pair with the left camera first.

    cameras: the models, of one image size.  T_world_cam: for each the transform (4, 4) from its frame to W, m.
    With two cameras W has its origin in the right camera's centre and z_W towards the left one's.
    calibration_covariance: of the parameters of `calibration_parameters` (8, 8) or (22, 22), where it is known.
    exposure_ns: of a row.  line_delay_ns: from a row to the next one of its field.  scan: one of `SCANS`.
    field_delay_ns: from the first row of the first field to the first one of the second.  An image's stamp is the
    middle of the exposure of the row that is exposed first; all cameras are alike in this.

    The rectified frame of a camera has its centre and the axes of `R_world_rect`, the focal length `focal_rect`, and
    coordinates in px relative to its principal point.

    Raises ValueError when the sizes differ, a transform is not rigid, two cameras do not form a stereo pair in W, the
    covariance is none, or the rows' timing makes no sense.
    """

    cameras: tuple[CameraModel, ...] = attrs.field(converter=_cameras)
    T_world_cam: tuple[FloatArray, ...] = attrs.field(converter=_transforms, eq=attrs.cmp_using(eq=_same_transforms))
    calibration_covariance: FloatArray | None = attrs.field(default=None, eq=attrs.cmp_using(eq=_same_covariance))
    exposure_ns: int = _duration_field()
    line_delay_ns: int = _duration_field()
    scan: str = attrs.field(default="progressive", validator=attrs.validators.in_(SCANS))
    field_delay_ns: int = _duration_field()

    def __attrs_post_init__(self) -> None:
        if len(self.cameras) not in (1, 2):
            raise ValueError(f"a rig has one or two cameras, not {len(self.cameras)}")
        if len(self.T_world_cam) != len(self.cameras):
            raise ValueError(f"{len(self.cameras)} cameras but {len(self.T_world_cam)} transforms")
        if self.is_stereo:
            self._check_stereo()
        if self.calibration_covariance is not None:
            checked = calibration_covariance(self.calibration_covariance, len(self.cameras))
            object.__setattr__(self, "calibration_covariance", checked)
        if self.field_delay_ns and self.scan == "progressive":
            raise ValueError("field_delay_ns belongs to an interlaced scan")

    def _check_stereo(self) -> None:
        left, right = self.cameras
        if (left.width, left.height) != (right.width, right.height):
            raise ValueError(f"the resolutions differ: {left.width}x{left.height} and {right.width}x{right.height}")
        T_left, T_right = self.T_world_cam
        if T_left[2, 3] - T_right[2, 3] < MIN_BASELINE_M:
            raise ValueError("the baseline is zero or cam0 does not lie towards z_W")
        if np.abs(T_right[:3, 3]).max() > AGREEMENT or np.abs(T_left[:2, 3]).max() > AGREEMENT:
            raise ValueError("the world's origin is not cam1's centre with z_W towards cam0's")
        for index in range(2):
            x, _, z = np.diag(self.R_rect_cam(index))
            if z < _MIN_FORWARD:
                raise ValueError(f"cam{index} does not look the way of the rig (more than 60 degrees off x_W)")
            if x < _MIN_FORWARD:
                raise ValueError("cam0 is not the left camera (swapped, or rolled by more than 60 degrees)")

    @property
    def calibration_or_default(self) -> FloatArray:
        """The calibration's covariance; where it is not known, that of a calibration made by hand."""
        if self.calibration_covariance is not None:
            return self.calibration_covariance
        return hand_calibration_covariance(self.focal_rect, self.baseline, len(self.cameras))

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
    def row_delays_ns(self) -> IntArray:
        """Middle of each raw row's exposure (height,) after the image's stamp, ns."""
        return row_delays_ns(self.height, self.scan, self.line_delay_ns, self.field_delay_ns)

    @cached_property
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

    def on_image(self, uv: FloatArray) -> BoolArray:
        """Whether raw pixels (..., 2) lie within the image, between the centres of its border pixels; NaN does not."""
        return np.asarray(((uv > 0.0) & (uv < (self.width - 1, self.height - 1))).all(axis=-1))

    def projection_matrix(self, camera: int) -> FloatArray:
        """The paper's M_l or M_r (3, 4) of eq. (1) for a rectified view: homogeneous p_W, m, to homogeneous xy, px.

        Its third row gives the depth z along x_W, m.
        """
        K = np.diag([self.focal_rect, self.focal_rect, 1.0])
        T_rect_world = inverse_T(make_T(self.R_world_rect, self.T_world_cam[camera][:3, 3]))
        matrix: FloatArray = K @ T_rect_world[:3]
        return matrix

    def perturbed(self, delta: FloatArray) -> Rig:
        """The rig whose calibration differs by delta (8,) or (22,), in the order of `calibration_parameters`.

        With two cameras W is derived from the changed ones (`world_from_camchain`); one camera stays where it is in W.
        Raises ValueError for a rig that is none.
        """
        delta = float_array(delta, len(calibration_parameters(len(self.cameras))))
        size = len(CAMERA_PARAMETERS)
        cameras = [_changed(camera, delta[i * size : (i + 1) * size]) for i, camera in enumerate(self.cameras)]
        T_world_cam = self.T_world_cam
        if self.is_stereo:
            T = inverse_T(self.T_world_cam[1]) @ self.T_world_cam[0]
            turn, shift = delta[2 * size : 2 * size + 3], delta[2 * size + 3 :]
            T_world_cam = world_from_camchain(make_T(exp(turn) @ T[:3, :3], T[:3, 3] + shift))
        return attrs.evolve(self, cameras=cameras, T_world_cam=T_world_cam)

    def reduced(self, factor: int) -> Rig:
        """The rig of images reduced by area: each pixel is the mean of factor x factor, what is left over is cut off.

        Its calibration's covariance is this rig's, or what stands for it.  Raises ValueError for images that are too
        small.
        """
        if factor == 1:
            return self
        cameras = [
            attrs.evolve(
                camera,
                width=camera.width // factor,
                height=camera.height // factor,
                fx=camera.fx / factor,
                fy=camera.fy / factor,
                cx=(camera.cx + 0.5) / factor - 0.5,
                cy=(camera.cy + 0.5) / factor - 0.5,
            )
            for camera in self.cameras
        ]
        in_pixels = [name.partition(".")[2][0] in "fc" for name in calibration_parameters(len(self.cameras))]
        scale = np.where(in_pixels, 1.0 / factor, 1.0)
        covariance = self.calibration_or_default * np.outer(scale, scale)
        return attrs.evolve(
            self,
            cameras=cameras,
            calibration_covariance=covariance,
            line_delay_ns=factor * self.line_delay_ns,
        )

    def _to_rect(self, p_rect: FloatArray) -> FloatArray:
        z = np.where(p_rect[..., 2:] > 0.0, p_rect[..., 2:], np.nan)
        xy: FloatArray = self.focal_rect * p_rect[..., :2] / z
        return xy


def _changed(camera: CameraModel, delta: FloatArray) -> CameraModel:
    fx, fy, cx, cy = np.array([camera.fx, camera.fy, camera.cx, camera.cy]) + delta[:4]
    return CameraModel(camera.width, camera.height, fx, fy, cx, cy, camera.distortion + delta[4:])


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
