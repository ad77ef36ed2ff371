"""What the calibration's errors do to a pose.

The measured lines stay where they are in the raw images.  Under another calibration they rectify differently, the
rectified views have another focal length and baseline, and the world W, which the rig defines, lies elsewhere.  The
refined pose follows linearly: dT = -gain dr/dc dc.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from attrs import frozen
from numpy.polynomial.chebyshev import chebvander2d

from rvdnav.core import LineEffect
from rvdnav.navigator.geometry import rectified_cameras, rectified_ends
from rvdnav.pose import LineMeasurements, PoseError, RectifiedCameras, RefinedPose
from rvdnav.pose.arrays import BoolArray, FloatArray
from rvdnav.rig import Rig, calibration_steps

# Nodes over the raw image, along and down, from which the shifts are taken, and the degree of their polynomials.
_NODES = (24, 20)
_DEGREE = (11, 11)
_SINGULAR = 1e-10
_MAX_STRETCH = 4.0
"""Of rectified by raw pixels (Frobenius norm; 1.4 without a lens), in a lens that folds back within the image."""


@frozen(eq=False)
class CalibrationEffect:
    """Derivatives of a rig's rectified views with respect to its calibration's parameters, or to combinations of them
    (p of them), made once.

    shift (cameras, m, 2, p): of the rectified coordinates, px, of a raw pixel, as m coefficients of products of
    Chebyshev polynomials over the image; the lens bends smoothly, so few suffice.
    focal (p,): of the rectified focal length, px.  centers (cameras, 3, p): of the cameras' centres in W, m.
    """

    rig: Rig
    shift: FloatArray
    focal: FloatArray
    centers: FloatArray

    @classmethod
    def of(cls, rig: Rig) -> CalibrationEffect:
        """By central differences over rigs perturbed in one parameter at a time."""
        nodes = [np.cos(np.pi * (np.arange(count) + 0.5) / count) for count in _NODES]
        place = np.stack(np.meshgrid(*nodes), axis=-1).reshape(-1, 2)
        uv = 0.5 * (place + 1.0) * _last_pixel(rig)
        basis = _basis(place)
        steps = calibration_steps(len(rig.cameras))
        cameras = range(len(rig.cameras))
        moved, focal, centers = [], [], []
        for delta, span in zip(np.diag(steps), 2.0 * steps, strict=True):
            above, below = rig.perturbed(delta), rig.perturbed(-delta)
            moved.append([(above.raw_to_rect(i, uv) - below.raw_to_rect(i, uv)) / span for i in cameras])
            focal.append((above.focal_rect - below.focal_rect) / span)
            centers.append([(above.T_world_cam[i][:3, 3] - below.T_world_cam[i][:3, 3]) / span for i in cameras])
        shifts = np.moveaxis(np.array(moved), 0, -1)  # (cameras, n, 2, p)
        shift = np.array([_fitted(basis, shifts[i], _regular(rig, i, uv)) for i in cameras])
        return cls(rig, shift, np.array(focal), np.moveaxis(np.array(centers), 0, -1))

    def residual_derivatives(self, T_world_target: FloatArray, lines: LineMeasurements) -> FloatArray:
        """Derivatives (n, 2, p) of the lines' residuals at a pose (4, 4) with respect to the parameters.

        Raises PoseError if an endpoint is not in front of its camera.
        """
        ends = rectified_ends(self._cameras, lines.camera, T_world_target, lines.endpoints_C)
        if not (ends[:, :, 2] > 0.0).all():
            raise PoseError("an edge is not in front of the camera")
        return self.by_line.derivatives(lines.camera, lines.rho, lines.theta, ends)

    @cached_property
    def _cameras(self) -> RectifiedCameras:
        return rectified_cameras(self.rig)

    @cached_property
    def by_line(self) -> LineEffect:
        """As it shows in lines, in the core."""
        centers = np.einsum("ij,njp->nip", self.rig.R_world_rect.T, self.centers)
        return LineEffect(self.rig, self.shift, self.focal, centers)

    def of_combinations(self, directions: FloatArray) -> CalibrationEffect:
        """The derivatives with respect to the factors of combinations (p, r) of the parameters."""
        return CalibrationEffect(self.rig, self.shift @ directions, self.focal @ directions, self.centers @ directions)

    def disparity_derivatives(self, xy: FloatArray, disparity: FloatArray) -> FloatArray:
        """Derivatives (k, p) of what is measured of disparities less what a pose predicts for them.

        xy (k, 2): left rectified points, px; disparity (k,), px: predicted.
        """
        right = xy - np.column_stack([disparity, np.zeros(len(xy))])
        moved = [self._point_shift(camera, points)[:, 0] for camera, points in enumerate((xy, right))]
        apart = self.centers[0, 2] - self.centers[1, 2]
        by_rig = self.focal / self.rig.focal_rect + apart / self.rig.baseline
        derivatives: FloatArray = moved[0] - moved[1] - disparity[:, None] * by_rig
        return derivatives

    def pose_derivative(self, pose: RefinedPose, lines: LineMeasurements) -> FloatArray:
        """Derivative (6, p) of a pose refined over these lines, order (position, rotation) in W."""
        derivative: FloatArray = -np.tensordot(pose.gain, self.residual_derivatives(pose.T_world_target, lines), 2)
        return derivative

    def pose_covariance(self, pose: RefinedPose, lines: LineMeasurements) -> FloatArray:
        """Covariance (6, 6) of a pose refined over these lines by that of the rig's calibration alone.

        It is zero for a rig whose calibration has none.
        """
        if self.rig.calibration_covariance is None:
            return np.zeros((6, 6))
        D = self.pose_derivative(pose, lines)
        covariance: FloatArray = D @ self.rig.calibration_covariance @ D.T
        symmetric: FloatArray = 0.5 * (covariance + covariance.T)
        return symmetric

    def _point_shift(self, camera: int, xy: FloatArray) -> FloatArray:
        """Shifts (k, 2, p) of a view's rectified points xy (k, 2), at the border for those beyond it."""
        place = 2.0 * self.rig.rect_to_raw(camera, xy) / _last_pixel(self.rig) - 1.0
        return np.asarray(np.tensordot(_basis(np.clip(np.nan_to_num(place), -1.0, 1.0)), self.shift[camera], 1))


def _regular(rig: Rig, camera: int, uv: FloatArray) -> BoolArray:
    """The nodes uv (n, 2) to fit polynomials through: all, or, where the lens folds back inside the image, those that
    lie clear of the fold, near which the shifts are without bounds."""
    if not rig.cameras[camera].pixels_without_ray:
        return np.ones(len(uv), dtype=np.bool_)
    sides = [rig.raw_to_rect(camera, uv + step) - rig.raw_to_rect(camera, uv - step) for step in 0.5 * np.eye(2)]
    clear: BoolArray = np.linalg.norm(sides, axis=(0, 2)) < _MAX_STRETCH
    return clear


def _fitted(basis: FloatArray, shift: FloatArray, regular: BoolArray) -> FloatArray:
    """Coefficients (m, 2, p) of the shifts (n, 2, p) at the nodes."""
    if regular.all():  # the polynomials are orthogonal to each other at the nodes, so that the fit is a sum
        return np.asarray(np.tensordot((basis / np.square(basis).sum(axis=0)).T, shift, 1))
    left = basis[regular]  # and of those that are left nearly so: the normal equations lose nothing
    return np.asarray(
        np.tensordot(np.linalg.pinv(left.T @ left, rcond=_SINGULAR, hermitian=True) @ left.T, shift[regular], 1)
    )


def _last_pixel(rig: Rig) -> FloatArray:
    return np.array([rig.width - 1.0, rig.height - 1.0])


def _basis(place: FloatArray) -> FloatArray:
    """Products of Chebyshev polynomials (..., m) at places (..., 2) in the image scaled to [-1, 1]."""
    return np.asarray(chebvander2d(place[..., 0], place[..., 1], _DEGREE), np.float64)
