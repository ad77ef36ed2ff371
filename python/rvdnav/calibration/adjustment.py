"""Bundle adjustment of the stereo rig over all views of the board, and the joint covariance of what it finds.

Every corner of every view is a pixel in two cameras; unknown are both cameras' intrinsics, the pose of the left camera
in the right one's frame and the board's pose in each view.  The normal equations are solved by eliminating the boards'
poses (Schur complement), which leaves 22 parameters whatever the number of views.
"""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.calibration.projection import project_with_derivatives
from rvdnav.camera import CameraModel
from rvdnav.pose.arrays import FloatArray, float_array
from rvdnav.pose.so3 import perturb, project_to_so3
from rvdnav.rig.covariance import CAMERA_PARAMETERS, calibration_parameters

N_INTRINSICS = len(CAMERA_PARAMETERS)
N_PARAMETERS = len(calibration_parameters(2))
_LEAST_SIGMA_PX = 0.02
"""Of a corner's coordinate.  What errs alike in all views (the lens beside its model, the light, the print) does not
show in the scatter, nor does it average out; corners scatter by less than this in clean pictures."""
_MAX_ITERATIONS = 50
_CONVERGED = 1e-10
"""Of the predicted decrease, as a share of the sum of squares."""


@attrs.frozen(eq=False)
class StereoModel:
    """What is estimated: the two cameras, T_cam1_cam0 (4, 4), and T_cam0_board (v, 4, 4) of each view, m."""

    cameras: tuple[CameraModel, CameraModel]
    T_cam1_cam0: FloatArray
    T_cam0_board: FloatArray


@attrs.frozen(eq=False)
class Adjustment:
    """The least-squares solution.

    residuals (v, 2, n, 2): measured minus predicted, px, NaN where nothing was measured.  normal: the normal matrix
    (22, 22) of the parameters, px^-2, the boards' poses eliminated.  covariance (22, 22): of the parameters, in the
    order of `calibration_parameters`.  sigma_px: of a coordinate of a corner, 0.02 or more.  correlation: the factor by
    which the covariance was widened because the errors of a view's corners go together; 1 where they are independent.
    """

    model: StereoModel
    residuals: FloatArray
    normal: FloatArray
    covariance: FloatArray
    sigma_px: float
    correlation: float

    @property
    def scatter_px(self) -> float:
        """Standard deviation of a residual's coordinate."""
        return float(np.sqrt(np.nanmean(self.residuals**2)))

    @property
    def rms_px(self) -> float:
        """Of the distances between measured and predicted corners over both cameras, as OpenCV states it."""
        return float(np.sqrt(np.nanmean(np.sum(self.residuals**2, axis=-1))))

    @property
    def view_rms_px(self) -> FloatArray:
        """The same for each view and camera (v, 2)."""
        rms: FloatArray = np.sqrt(np.nanmean(np.sum(self.residuals**2, axis=-1), axis=-1))
        return rms


@attrs.frozen(eq=False)
class _Linear:
    """Residuals and the normal equations by blocks: of the parameters A (v, 22, 22) for each view, of the board poses
    C (v, 6, 6), mixed B (v, 22, 6), and the right-hand sides a (v, 22), c (v, 6)."""

    residuals: FloatArray
    A: FloatArray
    B: FloatArray
    C: FloatArray
    a: FloatArray
    c: FloatArray

    @property
    def cost(self) -> float:
        return float(np.nansum(self.residuals**2))

    def reduced(self, damping: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Each view's normal matrix (v, 22, 22) and right side (v, 22) without its board pose; C (v, 6, 6), damped."""
        C = self.C + damping * np.eye(6) * np.einsum("vii->vi", self.C)[:, None]
        elimination = np.linalg.solve(C, np.swapaxes(self.B, 1, 2))  # (v, 6, 22)
        return self.A - self.B @ elimination, self.a - np.einsum("vij,vi->vj", elimination, self.c), C


def adjust(model: StereoModel, points_B: FloatArray, uv: FloatArray) -> Adjustment:
    """The rig that fits the corners best, from a start that is near it.

    points_B (n, 3): the board's corners, m.  uv (v, 2, n, 2): their pixels in view v and camera, NaN where not seen;
    each view holds enough of them in each camera.  Raises ValueError when the views do not determine the rig.
    """
    linear = _linearise(model, points_B, uv)
    damping = 1e-6
    for _ in range(_MAX_ITERATIONS):
        step, boards, decrease = _step(linear, damping)
        trial = _moved(model, step, boards)
        trial_linear = None if trial is None else _linearise(trial, points_B, uv)
        if trial is None or trial_linear is None or not trial_linear.cost <= linear.cost:
            damping = max(10.0 * damping, 1e-6)
            if decrease <= _CONVERGED * linear.cost or damping > 1e6:
                break
            continue
        model, linear, damping = trial, trial_linear, damping / 10.0
        if decrease <= _CONVERGED * linear.cost:
            break
    return _assess(model, linear)


def view_information(model: StereoModel, points_B: FloatArray, uv: FloatArray) -> FloatArray:
    """Normal matrices (v, 22, 22), px^-2, that views with these corners add to the rig's parameters.

    model: with the boards' poses in those views; uv as in `adjust`, of which only the NaN matter.
    """
    return _linearise(model, points_B, uv).reduced(0.0)[0]


def _linearise(model: StereoModel, points_B: FloatArray, uv: FloatArray) -> _Linear:
    left, right = model.cameras
    arms = points_B @ np.swapaxes(model.T_cam0_board[:, :3, :3], 1, 2)  # (v, n, 3)
    p_0 = arms + model.T_cam0_board[:, None, :3, 3]
    R, t = model.T_cam1_cam0[:3, :3], model.T_cam1_cam0[:3, 3]
    turned = p_0 @ R.T
    shape = p_0.shape[:2]
    jacobian = np.zeros((shape[0], 2, shape[1], 2, N_PARAMETERS))
    predicted = np.empty_like(uv)
    predicted[:, 0], by_point_0, jacobian[:, 0, :, :, :N_INTRINSICS] = project_with_derivatives(left, p_0)
    predicted[:, 1], by_point_1, by_right = project_with_derivatives(right, turned + t)
    jacobian[:, 1, :, :, N_INTRINSICS : 2 * N_INTRINSICS] = by_right
    jacobian[:, 1, :, :, -6:-3] = _by_rotation(by_point_1, turned)
    jacobian[:, 1, :, :, -3:] = by_point_1
    by_point = np.stack([by_point_0, by_point_1 @ R], axis=1)  # (v, 2, n, 2, 3), both by p_0
    board = np.concatenate([by_point, _by_rotation(by_point, arms[:, None])], axis=-1)
    residuals = uv - predicted
    seen = np.isfinite(residuals[..., 0]) & np.isfinite(residuals[..., 1])
    for block in (jacobian, board):
        block[~seen] = 0.0
    filled = np.where(seen[..., None], residuals, 0.0)
    views = shape[0]
    jacobian, board, filled = (block.reshape(views, -1, *block.shape[4:]) for block in (jacobian, board, filled))
    transposed, board_transposed = np.swapaxes(jacobian, 1, 2), np.swapaxes(board, 1, 2)
    return _Linear(
        residuals=residuals,
        A=transposed @ jacobian,
        B=transposed @ board,
        C=board_transposed @ board,
        a=np.einsum("vmi,vm->vi", jacobian, filled),
        c=np.einsum("vmi,vm->vi", board, filled),
    )


def _by_rotation(by_point: FloatArray, arm: FloatArray) -> FloatArray:
    """Derivative by d of a point exp([d]x) arm: g · (d x arm) = d · (arm x g)."""
    derivative: FloatArray = np.cross(arm[..., None, :], by_point)
    return derivative


def _step(linear: _Linear, damping: float) -> tuple[FloatArray, FloatArray, float]:
    """Step of the parameters (22,) and of the board poses (v, 6), and the decrease of the cost that it promises."""
    reduced, right_hand, C = linear.reduced(damping)
    normal = reduced.sum(axis=0)
    units = _units(normal)
    scaled = normal * units * units[:, None] + damping * np.eye(N_PARAMETERS)
    step = units * np.linalg.solve(scaled, units * right_hand.sum(axis=0))
    boards = np.linalg.solve(C, (linear.c - step @ linear.B)[..., None])[..., 0]
    decrease = float(step @ linear.a.sum(axis=0) + np.sum(boards * linear.c))
    return float_array(step, N_PARAMETERS), float_array(boards, None, 6), decrease


def _units(normal: FloatArray) -> FloatArray:
    """Units of the parameters in which the normal matrix has a unit diagonal."""
    diagonal = np.diagonal(normal)
    if not (diagonal > 0.0).all():
        raise ValueError("the views do not determine the rig")
    units: FloatArray = 1.0 / np.sqrt(diagonal)
    return units


def _moved(model: StereoModel, step: FloatArray, boards: FloatArray) -> StereoModel | None:
    """The model after a step, or None where that leaves what a camera can be."""
    try:
        left, right = (
            attrs.evolve(
                camera,
                fx=camera.fx + d[0],
                fy=camera.fy + d[1],
                cx=camera.cx + d[2],
                cy=camera.cy + d[3],
                distortion=camera.distortion + d[4:],
            )
            for camera, d in zip(model.cameras, step[: 2 * N_INTRINSICS].reshape(2, -1), strict=True)
        )
    except ValueError:
        return None
    rig = step[-6:]
    return StereoModel(
        cameras=(left, right),
        T_cam1_cam0=_rigid(perturb(model.T_cam1_cam0, np.concatenate([rig[3:], rig[:3]]))),
        T_cam0_board=np.stack([_rigid(perturb(T, d)) for T, d in zip(model.T_cam0_board, boards, strict=True)]),
    )


def _rigid(T: FloatArray) -> FloatArray:
    T = T.copy()
    T[:3, :3] = project_to_so3(T[:3, :3])
    return T


def _assess(model: StereoModel, linear: _Linear) -> Adjustment:
    """The covariance, from the residuals' own size and from how far the errors within a view go together.

    With independent errors of variance s², the gradient g_v of view v at the solution has the covariance
    s² (N_v - N_v N^-1 N_v), where N is the sum of the N_v.  What the gradients exceed that by, summed over the views
    and taken relative to N, widens the covariance (the cluster-robust estimate, reduced to one factor, since there are
    hardly more views than parameters).
    """
    per_view, gradients, _ = linear.reduced(0.0)
    normal = per_view.sum(axis=0)
    units = _units(normal)
    eigenvalues, eigenvectors = np.linalg.eigh(normal * units * units[:, None])
    if not eigenvalues[0] > 1e-11 * eigenvalues[-1]:
        raise ValueError("the views do not determine the rig")
    root = units[:, None] * eigenvectors / np.sqrt(eigenvalues)
    inverse = root @ root.T
    count = int(np.isfinite(linear.residuals).sum())
    freedom = count - N_PARAMETERS - 6 * len(per_view)
    if freedom <= 0:
        raise ValueError("the views do not determine the rig")
    variance = max(linear.cost / freedom, _LEAST_SIGMA_PX**2)
    shares = np.einsum("ij,vjk->vik", inverse, per_view)
    expected = float(np.einsum("vii->", shares) - np.einsum("vij,vji->", shares, shares))
    found = float(np.einsum("vi,ij,vj->", gradients, inverse, gradients))
    correlation = max(1.0, found / (variance * expected))
    return Adjustment(
        model=model,
        residuals=linear.residuals,
        normal=normal,
        covariance=inverse * (variance * correlation),
        sigma_px=float(np.sqrt(variance)),
        correlation=correlation,
    )


def T_cam_board(model: StereoModel, camera: int) -> FloatArray:
    """The boards' poses (v, 4, 4) in a camera's frame, m."""
    return model.T_cam0_board if camera == 0 else model.T_cam1_cam0 @ model.T_cam0_board
