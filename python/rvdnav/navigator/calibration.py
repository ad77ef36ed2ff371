"""What the calibration's errors do to a pose.

The measured lines stay where they are in the raw images.  Under another calibration they rectify differently, the
rectified views have another focal length and baseline, and the world W, which the rig defines, lies elsewhere.  The
refined pose follows linearly: dT = -gain dr/dc dc.
"""

from __future__ import annotations

import numpy as np
from attrs import frozen
from numpy.polynomial.chebyshev import chebvander2d

from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.pose import LineMeasurements, RefinedPose, line_residuals
from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray
from rvdnav.rig import Rig, calibration_steps

# Nodes over the raw image, along and down, from which the shifts are taken, and the degree of their polynomials.
_NODES = (24, 20)
_DEGREE = (11, 11)
_POINTS_PER_LINE = 16
_SINGULAR = 1e-10
_MAX_STRETCH = 4.0
"""Of rectified by raw pixels (Frobenius norm; 1.4 without a lens), in a lens that folds back within the image."""


@frozen(eq=False)
class CalibrationEffect:
    """Derivatives of a rig's rectified views with respect to its calibration's parameters (p of them), made once.

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
        distances, J = line_residuals(T_world_target, lines, rectified_cameras(self.rig))
        projected = distances + lines.rho[:, None]  # the endpoints' places across their lines
        by_focal = projected[:, :, None] / self.rig.focal_rect * self.focal
        by_center = np.einsum("nki,nip->nkp", J[:, :, :3], self.centers[lines.camera])
        derivatives: FloatArray = by_focal - by_center - self._line_shift(T_world_target, lines)
        return derivatives

    def disparity_derivatives(self, xy: FloatArray, disparity: FloatArray) -> FloatArray:
        """Derivatives (k, p) of what is measured of disparities less what a pose predicts for them.

        xy (k, 2): left rectified points, px; disparity (k,), px: predicted.
        """
        right = xy - np.column_stack([disparity, np.zeros(len(xy))])
        moved = [
            self._point_shift(np.array([camera]), points[None])[0][0, :, 0] for camera, points in enumerate((xy, right))
        ]
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

    def _line_shift(self, T_world_target: FloatArray, lines: LineMeasurements) -> FloatArray:
        """How far (n, 2, p), px, the lines move across themselves where their endpoints are.

        A line moves with the straight line through the shifted points that it was measured at: those of its edge that
        lie on the image.
        """
        normal = np.column_stack([np.cos(lines.theta), np.sin(lines.theta)])
        tangent = np.column_stack([-normal[:, 1], normal[:, 0]])
        points_W = lines.endpoints_C.reshape(-1, 3) @ T_world_target[:3, :3].T + T_world_target[:3, 3]
        xy = rectified_cameras(self.rig).project(np.repeat(lines.camera, 2), points_W).reshape(-1, 2, 2)
        ends = np.einsum("nki,ni->nk", xy, tangent)
        part = (np.arange(_POINTS_PER_LINE) + 0.5) / _POINTS_PER_LINE
        place = ends[:, :1] + part * (ends[:, 1:] - ends[:, :1])
        points = (lines.rho[:, None] * normal)[:, None] + place[:, :, None] * tangent[:, None]
        moved, on_image = self._point_shift(lines.camera, points)
        across = np.einsum("ni,nmip->nmp", normal, moved)
        weight = np.where(on_image.sum(axis=1, keepdims=True) >= 2, on_image, 1.0)
        weight /= weight.sum(axis=1, keepdims=True)
        middle = np.einsum("nm,nm->n", weight, place)[:, None]
        moment = weight * (place - middle)
        slope = np.einsum("nm,nmp->np", moment, across)
        slope /= np.maximum(np.einsum("nm,nm->n", moment, place - middle), 1e-9)[:, None]
        offset = np.einsum("nm,nmp->np", weight, across)
        shift: FloatArray = offset[:, None] + (ends - middle)[:, :, None] * slope[:, None]
        return shift

    def _point_shift(self, camera: IntArray, xy: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Shifts (n, m, 2, p) of rectified points xy (n, m, 2), at the border for those beyond it; 1 on the image."""
        shift = np.empty((*xy.shape, len(self.focal)))
        on_image = np.empty(xy.shape[:2])
        for i, coefficients in enumerate(self.shift):
            chosen = camera == i
            if not chosen.any():
                continue
            place = 2.0 * self.rig.rect_to_raw(i, xy[chosen]) / _last_pixel(self.rig) - 1.0
            on_image[chosen] = (np.abs(place) <= 1.0).all(axis=-1)
            shift[chosen] = np.tensordot(_basis(np.clip(np.nan_to_num(place), -1.0, 1.0)), coefficients, 1)
        return shift, on_image


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
