"""The camera: a pinhole with radial and tangential lens distortion."""

from __future__ import annotations

import operator
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from rvdnav.pose.arrays import FloatArray, float_array

_NEWTON_STEPS = 50
_NEWTON_TOLERANCE = 1e-12
# What is beyond these is a slip of the pen: a field of view under half a degree or over 157, pixels three times as long
# as wide, and a region of no image that there is.
_FOCAL_SPAN = (0.1, 100.0)  # of the image's longer side
_MAX_ASPECT = 3.0
_MAX_OFF_AXIS = 4096.0  # px, from the image's middle
_MAX_RADIAL, _MAX_TANGENTIAL = 1e9, 1e3
_MAX_WITHOUT_RAY = 0.05  # of the pixels
_MOST_COUNTED = 100_000


def _distortion(values: ArrayLike) -> FloatArray:
    coefficients: FloatArray = float_array(values, 4).copy()
    coefficients.setflags(write=False)
    return coefficients


def _finite(_: Any, attribute: attrs.Attribute[Any], value: float) -> None:
    if not np.isfinite(value):
        raise ValueError(f"{attribute.name} is not finite")


def _positive(_: Any, attribute: attrs.Attribute[Any], value: float) -> None:
    if not value > 0:
        raise ValueError(f"{attribute.name} is not positive")


@attrs.frozen
class CameraModel:
    """A pinhole camera with Brown's distortion ("radtan"), the model of Kalibr and OpenCV.

    width, height: of the image, px.  fx, fy: focal lengths, px.  cx, cy: principal point, px; pixel (0, 0) is the
    centre of the top-left pixel.  distortion: k1, k2, p1, p2 (4,).  Camera frame: x right, y down, z forward, m.

    Where the distortion folds back some pixels inside the image these have no ray: `pixels_without_ray`.

    Raises ValueError, naming the parameter and its value, for a size that is not positive, a number that is not
    finite, a focal length that is not 0.1 to 100 times the image's longer side or three times the other, a principal
    point more than 4096 px from the image's middle, a distortion beyond all bounds, and one that leaves more than 5 %
    of the pixels without a ray.
    Model: D. C. Brown, "Close-range camera calibration", Photogrammetric Engineering 37 (1971).
    """

    width: int = attrs.field(converter=operator.index, validator=_positive)
    height: int = attrs.field(converter=operator.index, validator=_positive)
    fx: float = attrs.field(converter=float, validator=[_finite, _positive])
    fy: float = attrs.field(converter=float, validator=[_finite, _positive])
    cx: float = attrs.field(converter=float, validator=_finite)
    cy: float = attrs.field(converter=float, validator=_finite)
    distortion: FloatArray = attrs.field(converter=_distortion, eq=attrs.cmp_using(eq=np.array_equal))

    _fold_radius2: float = attrs.field(init=False, eq=False, repr=False)

    @_fold_radius2.default
    def _find_fold(self) -> float:
        """Square of the ideal radius at which the distorted one, r (1 + k1 r² + k2 r⁴), stops growing."""
        k1, k2 = self.distortion[:2]
        # 1 + 3 k1 s + 5 k2 s² = 0 for s = r²; in t = 1/s it is monic, so that a vanishing k2 does no harm.
        discriminant = (3.0 * k1) ** 2 - 20.0 * k2
        t = (-3.0 * k1 + np.sqrt(discriminant)) / 2.0 if discriminant >= 0.0 else 0.0
        return float(1.0 / t) if t > 1e-12 else float(np.inf)

    pixels_without_ray: int = attrs.field(init=False, eq=False, repr=False, default=0)

    def __attrs_post_init__(self) -> None:
        longer = max(self.width, self.height)
        for name, focal in (("fx", self.fx), ("fy", self.fy)):
            if not _FOCAL_SPAN[0] * longer <= focal <= _FOCAL_SPAN[1] * longer:
                span = f"{_FOCAL_SPAN[0] * longer:g} to {_FOCAL_SPAN[1] * longer:g} px"
                raise ValueError(f"{name} = {focal:g} is not {span} (0.1 to 100 times the image's longer side)")
        if not 1.0 / _MAX_ASPECT <= self.fx / self.fy <= _MAX_ASPECT:
            raise ValueError(f"fx = {self.fx:g} and fy = {self.fy:g} differ by more than a factor of {_MAX_ASPECT:g}")
        for name, centre, size in (("cx", self.cx, self.width), ("cy", self.cy, self.height)):
            if abs(centre - 0.5 * (size - 1)) > _MAX_OFF_AXIS:
                raise ValueError(f"{name} = {centre:g} lies more than {_MAX_OFF_AXIS:g} px from the image's middle")
        for name, k in zip(("k1", "k2", "p1", "p2"), self.distortion, strict=True):
            most = _MAX_RADIAL if name.startswith("k") else _MAX_TANGENTIAL
            if abs(k) > most:
                raise ValueError(f"{name} = {k:g} is not within -{most:g} to {most:g}")
        if not np.isfinite(self.unproject(self._border())).all():
            object.__setattr__(self, "pixels_without_ray", self._count_without_ray())
        share = self.pixels_without_ray / (self.width * self.height)
        if share > _MAX_WITHOUT_RAY:
            raise ValueError(
                f"the distortion folds back inside the image: {100.0 * share:.0f} % of its pixels have no ray"
            )

    @property
    def K(self) -> FloatArray:
        """The intrinsic matrix (3, 3), px."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def project(self, p_C: FloatArray) -> FloatArray:
        """Pixels (..., 2) of points (..., 3) in the camera frame.

        A point that is not in front of the camera, or so far aside that the distortion has folded back, gives NaN.
        """
        p_C = np.asarray(p_C, dtype=np.float64)
        z = np.where(p_C[..., 2:] > 0.0, p_C[..., 2:], np.nan)
        xy = p_C[..., :2] / z
        xy = np.where(self._unfolded(xy), xy, np.nan)
        return self._distort(xy) * (self.fx, self.fy) + (self.cx, self.cy)

    def unproject(self, uv: FloatArray) -> FloatArray:
        """Rays (..., 3) with z = 1 in the camera frame of pixels (..., 2): the inverse of `project`.

        A pixel that no ray is imaged to gives NaN.
        """
        target = (np.asarray(uv, dtype=np.float64) - (self.cx, self.cy)) / (self.fx, self.fy)
        places = target.reshape(-1, 2)
        found = places.copy()
        left = np.arange(len(places))  # those still on their way: a pixel without a ray keeps no other waiting
        with np.errstate(all="ignore"):  # where Newton's method runs away it ends in NaN, which is the answer
            for _ in range(_NEWTON_STEPS):
                error = self._distort(found[left]) - places[left]
                coarse = (np.abs(error) > _NEWTON_TOLERANCE).any(axis=-1)
                if not coarse.any():
                    break
                left = left[coarse]
                found[left] -= self._newton_step(found[left], error[coarse])
            xy = found.reshape(target.shape)
            solved = (np.abs(self._distort(xy) - target) <= 10.0 * _NEWTON_TOLERANCE).all(axis=-1, keepdims=True)
            xy = np.where(solved & self._unfolded(xy), xy, np.nan)
        return np.concatenate([xy, np.ones_like(xy[..., :1])], axis=-1)

    def _distort(self, xy: FloatArray) -> FloatArray:
        """Distorted normalised coordinates (..., 2) of ideal ones."""
        k1, k2, p1, p2 = self.distortion
        x, y = xy[..., 0], xy[..., 1]
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * k2)
        u = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x)
        v = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y
        return np.stack([u, v], axis=-1)

    def _newton_step(self, xy: FloatArray, error: FloatArray) -> FloatArray:
        """Change of xy (..., 2) that changes its distorted position by error, to first order."""
        k1, k2, p1, p2 = self.distortion
        x, y = xy[..., 0], xy[..., 1]
        r2 = x * x + y * y
        radial = 1.0 + r2 * (k1 + r2 * k2)
        slope = 2.0 * k1 + 4.0 * k2 * r2  # d radial / dx = slope x, d radial / dy = slope y
        u_x = radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x
        v_y = radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x
        cross = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y  # both du/dy and dv/dx
        e_u, e_v = error[..., 0], error[..., 1]
        determinant = u_x * v_y - cross * cross
        step: FloatArray = (
            np.stack([v_y * e_u - cross * e_v, u_x * e_v - cross * e_u], axis=-1) / determinant[..., None]
        )
        return step

    def _unfolded(self, xy: FloatArray) -> NDArray[np.bool_]:
        """Whether xy (..., 2) lies where the distorted radius still grows with the true one; shape (..., 1)."""
        unfolded: NDArray[np.bool_] = np.sum(xy * xy, axis=-1, keepdims=True) < self._fold_radius2
        return unfolded

    def _border(self) -> FloatArray:
        """Points (n, 2) along the outermost pixels of the image, px."""
        t = np.linspace(0.0, 1.0, 33)
        sides = [np.stack([t, np.full_like(t, end)], axis=-1) for end in (0.0, 1.0)]
        unit = np.concatenate([*sides, *(side[:, ::-1] for side in sides)])
        return unit * (self.width - 1, self.height - 1)

    def _count_without_ray(self) -> int:
        """Pixels that no ray is imaged to; every n-th counts for all where the image is large."""
        step = int(np.ceil(np.sqrt(self.width * self.height / _MOST_COUNTED)))
        uv = np.stack(np.meshgrid(np.arange(0.0, self.width, step), np.arange(0.0, self.height, step)), axis=-1)
        radius = np.linalg.norm((uv - (self.cx, self.cy)) / (self.fx, self.fy), axis=-1)
        counted = int((~np.isfinite(self.unproject(uv[radius >= self._sure_radius()])).all(axis=-1)).sum())
        return max(counted * step * step, 1)

    def _sure_radius(self) -> float:
        """A distorted radius within which every point is the image of a ray: the circle at which the lens folds is
        imaged outside it, since the tangential distortion moves no point by more than 3 (|p1| + |p2|) r²."""
        k1, k2, p1, p2 = (float(k) for k in self.distortion)
        s = self._fold_radius2
        if not np.isfinite(s):
            return 0.0
        return float(np.sqrt(s) * (1.0 + s * (k1 + s * k2)) - 3.0 * (abs(p1) + abs(p2)) * s)
