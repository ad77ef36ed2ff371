"""Corners of a chessboard to a few hundredths of a pixel: a model of the grey values fitted around each of them.

Two straight edges, each a step blurred by a Gaussian, cross in the corner:

    I(q) = (m + c s1 s2) (1 + g · q),   s_i = erf(d_i / (sqrt(2) sigma_i)),   d_i: signed distance to edge i, px

with the illumination's slope g.  Edges and window are symmetric about the corner, so that neither the shape of the blur
nor a rounded tip moves the result.  A lens bends the edges by up to a tenth of a pixel within the window; once the
camera is known, the window is straightened first.
Cf. A. Datta, J.-S. Kim, T. Kanade, "Accurate camera calibration using iterative refinement of control points" (2009).
"""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.camera import CameraModel
from rvdnav.images import PixelArray
from rvdnav.pose.arrays import BoolArray, FloatArray

_WINDOW = 0.6
"""Half width of the window, in squares; at 1 the next edges stand."""
_MARGIN_PX = 2.0
"""Least distance of the window from the next edges, px, so that their blur stays outside."""
_MIN_WINDOW = 0.4
_MAX_RADIUS = 20
"""px; beyond it more pixels no longer pay."""
_BAND_PX = 3.0
"""Half width of the band along the edges whose pixels are taken: the others hardly tell of the corner."""
_MIN_BAND_PX = 1.0
_ITERATIONS = 25
_CONVERGED_PX = 1e-4
_BLUR_PX = (0.3, 6.0)
_PARAMETERS = 10  # x, y, theta1, theta2, log sigma1, log sigma2, m, c, gx, gy
_MIN_INSIDE = 0.85
"""Share of the window that must lie in the image."""
_MAX_SHIFT = 0.3
"""Largest way from the start, in squares."""
_MIN_EXPLAINED = 0.8
"""Least share of the window's variance that the model must explain."""


@attrs.frozen(eq=False)
class CornerFits:
    """uv (n, 2): the corners, px, NaN where none was found.  blur (n,): sigma of the edges, the wider one's, px.
    inside (n,): whether the window lies in the image."""

    uv: FloatArray
    blur: FloatArray
    inside: BoolArray


def fit_corners(
    image: PixelArray, uv: FloatArray, steps: FloatArray, *, camera: CameraModel | None, clearance: float = np.inf
) -> CornerFits:
    """Corners near uv (n, 2), px, of an image.

    steps (n, 2, 2): the ways, px, to the next corner of the row and of the column.  camera: whose distortion bends the
    edges, where it is known.  clearance: how far from the edges the squares are plain, in squares: markers lie beyond.
    """
    offsets, inside = _windows(image, uv, steps)
    pixels = np.rint(uv)
    q = offsets - (uv - pixels)[:, None, :]
    window = _within(q, steps, clearance)
    weights = window & inside
    whole = weights.sum(axis=1) >= _MIN_INSIDE * window.sum(axis=1)
    offsets, q, weights = _compressed(window, np.broadcast_to(offsets, q.shape), q, weights)
    u, v = (pixels[:, None, :] + offsets).astype(np.intp).transpose(2, 0, 1)
    grey = image[np.clip(v, 0, image.shape[0] - 1), np.clip(u, 0, image.shape[1] - 1)].astype(np.float64)
    if camera is not None:
        q = _straightened(camera, uv, q)
    parameters, explained = _fit(q, grey, weights.astype(np.float64), steps)
    size = np.linalg.norm(steps, axis=2).min(axis=1)
    shift = np.linalg.norm(parameters[:, :2], axis=1)
    found = whole & (explained > _MIN_EXPLAINED) & (shift < _MAX_SHIFT * size)
    return CornerFits(
        uv=np.where(found[:, None], uv + parameters[:, :2], np.nan),
        blur=np.exp(parameters[:, 4:6].max(axis=1)),
        inside=whole,
    )


def _windows(image: PixelArray, uv: FloatArray, steps: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Whole-pixel offsets (1, m, 2) of a square that holds every corner's window, and which lie in the image (n, m)."""
    reach = int(np.clip(np.ceil(np.abs(steps).sum(axis=1).max() * _WINDOW), 2, _MAX_RADIUS))
    grid = np.arange(-reach, reach + 1.0)
    offsets = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(1, -1, 2)
    pixels = np.rint(uv)[:, None, :] + offsets
    height, width = image.shape
    inside = ((pixels >= 0) & (pixels <= (width - 1, height - 1))).all(axis=2)
    return offsets, inside


def _within(q: FloatArray, steps: FloatArray, clearance: float) -> BoolArray:
    """Which offsets q (n, m, 2) from the corners lie in their windows.

    A window is a cross along the edges, cut by a parallelogram along the squares and by a disc.
    """
    sizes = np.linalg.norm(steps, axis=2)
    limits = np.clip(1.0 - _MARGIN_PX / sizes, _MIN_WINDOW, _WINDOW)[:, None, :]
    along = np.abs(q @ np.linalg.inv(steps))  # in squares: q = along @ steps
    # A clearance keeps a margin from the markers, as from the next edges, where the squares are large enough for it.
    least = sizes.min(axis=1)
    band = np.minimum(np.maximum(clearance * least - _MARGIN_PX, _MIN_BAND_PX), _BAND_PX)
    in_disc: BoolArray = np.hypot(q[..., 0], q[..., 1]) <= _MAX_RADIUS
    in_cross: BoolArray = _edge_distance(q, steps) <= band[:, None]
    near: BoolArray = (along <= limits).all(axis=2)
    return in_disc & in_cross & near


def _edge_distance(q: FloatArray, steps: FloatArray) -> FloatArray:
    """Distances (n, m), px, of offsets q (n, m, 2) from the nearer of the two edges along steps (n, 2, 2)."""
    normals = (
        np.stack([-steps[:, :, 1], steps[:, :, 0]], axis=1) / np.linalg.norm(steps, axis=2)[:, None]
    )  # (n, 2, edge)
    distance: FloatArray = np.abs(q @ normals).min(axis=2)
    return distance


def _compressed(window: BoolArray, *arrays: NDArray[Any]) -> list[Any]:
    """Arrays (n, m, ...) with the windows' pixels alone, padded by others to one number of them for all corners."""
    most = int(window.sum(axis=1).max())
    order = np.argsort(~window, axis=1, kind="stable")[:, :most]
    return [np.take_along_axis(a, order.reshape(*order.shape, *[1] * (a.ndim - 2)), axis=1) for a in arrays]


def _straightened(camera: CameraModel, uv: FloatArray, q: FloatArray) -> FloatArray:
    """Offsets (n, m, 2) as they would be if the lens were as at the corner throughout the window.

    To first order they are q itself, so that a position found in them is one in pixels.
    """
    centre = camera.unproject(uv)[:, None, :2]
    h = 0.5
    slope = np.stack(
        [camera.unproject(uv + step)[:, :2] - camera.unproject(uv - step)[:, :2] for step in np.eye(2) * h], axis=1
    )  # (n, 2, 2): rows d ray / du, d ray / dv, over 2 h px
    rays = camera.unproject(uv[:, None, :] + q)[..., :2] - centre
    straight: FloatArray = rays @ np.linalg.inv(slope / (2.0 * h))
    return np.where(np.isfinite(straight), straight, q)


def _fit(q: FloatArray, grey: FloatArray, weights: FloatArray, steps: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Levenberg-Marquardt on all corners at once: parameters (n, 10) and the share of variance explained (n,)."""
    n = len(q)
    parameters = np.zeros((n, _PARAMETERS))
    parameters[:, 2:4] = np.arctan2(steps[:, :, 1], steps[:, :, 0])
    parameters[:, 4:6] = np.log(0.9)
    scale = np.maximum(weights.sum(axis=1), 1.0)
    mean = (weights * grey).sum(axis=1) / scale
    variance = (weights * (grey - mean[:, None]) ** 2).sum(axis=1) / scale
    parameters[:, 6] = mean
    shape = _model(parameters + np.eye(_PARAMETERS)[7], q)[0] - _model(parameters, q)[0]
    parameters[:, 7] = np.sign((weights * shape * (grey - mean[:, None])).sum(axis=1)) * np.sqrt(variance)
    damping = np.full(n, 1e-3)
    values, jacobian = _model(parameters, q)
    cost = (weights * (grey - values) ** 2).sum(axis=1)
    for _ in range(_ITERATIONS):
        weighted = jacobian * weights[..., None]
        transposed = np.swapaxes(weighted, 1, 2)
        normal = transposed @ jacobian
        gradient = (transposed @ (grey - values)[..., None])[..., 0]
        diagonal = np.einsum("nii->ni", normal)
        normal += (
            np.eye(_PARAMETERS) * (damping[:, None] * diagonal + 1e-9 * diagonal.max(axis=1)[:, None] + 1e-9)[:, None]
        )
        step = np.linalg.solve(normal, gradient[..., None])[..., 0]
        trial = parameters + step
        trial[:, 4:6] = np.clip(trial[:, 4:6], *np.log(_BLUR_PX))
        trial_values, trial_jacobian = _model(trial, q)
        trial_cost = (weights * (grey - trial_values) ** 2).sum(axis=1)
        better = trial_cost <= cost
        parameters[better], values[better], jacobian[better] = (
            trial[better],
            trial_values[better],
            trial_jacobian[better],
        )
        cost[better] = trial_cost[better]
        damping = np.where(better, damping * 0.2, damping * 10.0).clip(1e-9, 1e6)
        if (np.abs(step[:, :2]).max(axis=1) < _CONVERGED_PX).all():
            break
    return parameters, 1.0 - cost / scale / np.maximum(variance, 1e-9)


def _model(parameters: FloatArray, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Grey values (n, m) at offsets q (n, m, 2) and their derivatives (n, m, 10)."""
    x, y, theta1, theta2, blur1, blur2, m, c, gx, gy = (column[:, None] for column in parameters.T)
    rx, ry = q[..., 0] - x, q[..., 1] - y
    s1, by_x1, by_y1, by_theta1, by_blur1 = _step(rx, ry, theta1, np.exp(blur1))
    s2, by_x2, by_y2, by_theta2, by_blur2 = _step(rx, ry, theta2, np.exp(blur2))
    light = 1.0 + gx * q[..., 0] + gy * q[..., 1]
    pattern = m + c * s1 * s2
    scaled = c * light
    jacobian = np.stack(
        [
            scaled * (by_x1 * s2 + s1 * by_x2),
            scaled * (by_y1 * s2 + s1 * by_y2),
            scaled * by_theta1 * s2,
            scaled * s1 * by_theta2,
            scaled * by_blur1 * s2,
            scaled * s1 * by_blur2,
            light,
            light * s1 * s2,
            pattern * q[..., 0],
            pattern * q[..., 1],
        ],
        axis=-1,
    )
    return pattern * light, jacobian


def _step(
    rx: FloatArray, ry: FloatArray, theta: FloatArray, sigma: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray]:
    """A blurred step across the line at angle theta through the corner, and its derivatives.

    With respect to the corner's x and y, theta and log sigma.  erf(z / sqrt(2)) as a hyperbolic tangent, to 4e-4.
    """
    sine, cosine = np.sin(theta), np.cos(theta)
    z = np.clip((cosine * ry - sine * rx) / sigma, -6.0, 6.0)
    value = np.tanh(z * (0.7978846 + 0.0356624 * z * z))
    slope = (1.0 - value * value) * (0.7978846 + 0.1069872 * z * z) / sigma
    return value, slope * sine, -slope * cosine, slope * (-cosine * rx - sine * ry), -slope * z * sigma
