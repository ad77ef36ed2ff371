"""What is known of target and rig only to a tolerance, and what the frames so far have taught of it.

The target's points may lie off by their tolerance, the rig's calibration by its covariance, and every frame's steps
may be displaced towards their bright or their dark side by the camera's response, and edges in all views alike by what
lies beside them.  All are estimated with the pose (`rvdnav.pose.systematics`): the first two are the same in all frames
and learnt, the others are each frame's own.
"""

from __future__ import annotations

import math
from copy import copy

import attrs
import numpy as np

from rvdnav.core import Errors, RowMotion
from rvdnav.corrections import Corrections, ParameterCorrection, PointCorrection
from rvdnav.navigator.calibration import CalibrationEffect
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import project_edges, rectified_cameras, rectified_ends
from rvdnav.navigator.shutter import Motion, row_seconds
from rvdnav.pose import LineMeasurements, PoseError, RefinedPose
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.systematics import Group, Systematics
from rvdnav.rig import Rig, calibration_parameters

TARGET, CALIBRATION, STEPS, EDGES, MOTION = 0, 1, 2, 3, 4
"""The groups, in their order."""

# How many independent errors the stated standard deviations are worth against those that the lines show: a maker who
# says 0.3 mm may mean 0.1 or 1; of a calibration fewer parameters show in the images; what the filter says stands.
_WEIGHTS = (1.0, 4.0, 1.0, 1.0, math.inf)
# The largest scales: how far what was said can be from what is, before the frame is not to be believed.
_LARGEST = (5.0, 5.0, 20.0, 25.0, 1.0)
_DOUBTFUL = (True, True, False, False, False)
# Part of what was learnt that still counts in the next frame: lens remains, light and sampling displace the lines of
# neighbouring frames alike, so their errors don't average out.
_KEPT = 0.7
# Directions of the calibration's covariance below this part of the largest are none.
_NEGLIGIBLE = 1e-12


@attrs.frozen(eq=False)
class Learned:
    """What frames have taught of the lasting parameters (p,): target first, then calibration.

    information (p, p), vector (p,): information times mean, in stated standard deviations.  scales (5,): of what was
    stated, by group.  frames: how many.  motion: of the target, where the rows are exposed one after the other.
    """

    information: FloatArray
    vector: FloatArray
    scales: FloatArray
    frames: int
    motion: Motion | None = None

    @classmethod
    def nothing(cls, parameters: int) -> Learned:
        """Before the first frame."""
        return cls(np.zeros((parameters, parameters)), np.zeros(parameters), np.ones(len(_WEIGHTS)), 0)

    def with_frame(self, information: FloatArray, vector: FloatArray, scales: FloatArray) -> Learned:
        """With what a frame tells by itself, and the scales that it shows."""
        return Learned(_KEPT * self.information + information, _KEPT * self.vector + vector, scales, self.frames + 1)


class Knowledge:
    """The systematic errors of one rig and target as they show in measured lines."""

    def __init__(self, rig: Rig, model: EdgeModel) -> None:
        self._cameras = rectified_cameras(rig)
        self._model = model
        self._uncertain = np.repeat(model.point_sigmas > 0.0, 3)
        self._point_sigma = np.repeat(model.point_sigmas, 3)[self._uncertain]
        covariance = rig.calibration_or_default
        self._directions = _root(covariance)
        self._effect = CalibrationEffect.of(rig).of_combinations(self._directions) if covariance.any() else None
        self._calibration_sigma = np.sqrt(np.diagonal(covariance))
        self._views = len(rig.cameras)

    def reduced(self, rig: Rig) -> Knowledge:
        """The same errors, parameter by parameter, as they show in a rig's reduced images (`Rig.reduced`)."""
        knowledge = copy(self)
        factor = self._cameras.focal / rig.focal_rect
        in_pixels = [name.partition(".")[2][0] in "fc" for name in calibration_parameters(len(rig.cameras))]
        knowledge._directions = self._directions / np.where(in_pixels, factor, 1.0)[:, None]
        knowledge._cameras = rectified_cameras(rig)
        if self._effect is not None:
            knowledge._effect = CalibrationEffect.of(rig).of_combinations(knowledge._directions)
        return knowledge

    @property
    def lasting(self) -> int:
        """How many parameters are the same in all frames."""
        return len(self._point_sigma) + int(self._directions.shape[1])

    def errors(self, learned: Learned, rig: Rig) -> Errors:
        """As the core takes them, of frames of this rig."""
        motion = learned.motion
        return Errors(
            effect=None if self._effect is None else self._effect.by_line,
            scales=learned.scales,
            information=learned.information,
            vector=learned.vector,
            motion=None if motion is None else RowMotion(row_seconds(rig), motion.velocity, motion.covariance),
        )

    def of_coarse_lines(self, T_world_target: FloatArray, lines: LineMeasurements, learned: Learned) -> Systematics:
        """The lasting parameters of lines near a pose (4, 4), the calibration as far off as it can be: lines tell it at
        once, while the edges are not measured where it is not followed.  Raises PoseError as `systematics`."""
        stated = self.systematics(self.derivative(T_world_target, lines), learned)
        scales = stated.scales.copy()
        scales[CALIBRATION] = _LARGEST[CALIBRATION]
        return attrs.evolve(stated, scales=scales)

    def systematics(self, derivative: FloatArray, learned: Learned) -> Systematics:
        """Of lines with these derivatives (n, 2, p) by the lasting parameters, or by all of a frame."""
        sizes = self._sizes(derivative.shape[2])
        groups = tuple(map(Group, sizes, _WEIGHTS, _LARGEST, _DOUBTFUL))
        information = np.zeros((derivative.shape[2],) * 2)
        vector = np.zeros(derivative.shape[2])
        information[: self.lasting, : self.lasting] = learned.information
        vector[: self.lasting] = learned.vector
        return Systematics(derivative, groups, learned.scales, information, vector)

    def _sizes(self, parameters: int) -> tuple[int, ...]:
        """Of the groups, of the lasting parameters alone or of all."""
        lasting = (len(self._point_sigma), int(self._directions.shape[1]))
        of_frame = (self._views, len(self._model)) if parameters > self.lasting else (0, 0)
        return (*lasting, *of_frame, parameters - sum(lasting) - sum(of_frame))

    def derivative(self, T_world_target: FloatArray, lines: LineMeasurements) -> FloatArray:
        """(n, 2, p), px: of the lines' residuals with respect to the lasting parameters."""
        parts = []
        if len(self._point_sigma) > 0:
            parts.append(self._by_points(T_world_target, lines)[:, :, self._uncertain] * self._point_sigma)
        if self._effect is not None:
            parts.append(self._effect.residual_derivatives(T_world_target, lines))
        return np.concatenate([np.zeros((len(lines), 2, 0)), *parts], axis=2)

    def _by_points(self, T: FloatArray, lines: LineMeasurements) -> FloatArray:
        """(n, 2, 3 k), px/m: with respect to the positions of the target's k points in C."""
        by_end = self._by_ends(T, lines)
        part = self._model.parts(lines.edge, lines.endpoints_C)
        derivative = np.zeros((len(lines), 2, len(self._model.point_sigmas), 3))
        row = np.arange(len(lines))
        ends = self._model.ends[lines.edge]
        derivative[row, :, ends[:, 0]] = (1.0 - part)[:, :, None] * by_end
        derivative[row, :, ends[:, 1]] += part[:, :, None] * by_end
        return derivative.reshape(len(lines), 2, 3 * len(self._model.point_sigmas))

    def _by_ends(self, T: FloatArray, lines: LineMeasurements) -> FloatArray:
        """(n, 2, 3), px/m: with respect to the positions of the lines' own ends in C."""
        ends = rectified_ends(self._cameras, lines.camera, T, lines.endpoints_C)
        depth = ends[:, :, 2]
        if not (depth > 0.0).all():
            raise PoseError("an edge is not in front of the camera")
        normal = np.stack([np.cos(lines.theta), np.sin(lines.theta)], axis=1)[:, None]
        along = np.einsum("nek,nek->ne", normal, ends[:, :, :2]) / depth
        gradient = np.concatenate([np.repeat(normal, 2, axis=1), -along[:, :, None]], axis=2)
        by_ends: FloatArray = (self._cameras.focal / depth)[:, :, None] * gradient
        return by_ends @ (self._cameras.R_rect_world @ T[:3, :3])

    def expected(self, learned: Learned) -> FloatArray:
        """The lasting parameters (p,) as the frames so far tell them."""
        return self.systematics(np.zeros((0, 2, self.lasting)), learned).mean

    def edge_offsets(self, T_world_target: FloatArray, z: FloatArray) -> FloatArray:
        """How far (cameras, edges, 2), px, the ends of the edges are seen beside their projections, towards the normal
        (-dy, dx), with lasting parameters z (p,).  Raises PoseError for a target that is not in front of the
        cameras."""
        count, views = len(self._model), self._views
        if not z.any():
            return np.zeros((views, count, 2))
        xy = np.stack(
            [project_edges(self._cameras, k, T_world_target, self._model.edge_points)[0] for k in range(views)]
        )
        span = xy[:, :, 1] - xy[:, :, 0]
        theta = np.arctan2(span[..., 0], -span[..., 1]).ravel()
        rho = (np.cos(theta) * xy[:, :, 0, 0].ravel()) + (np.sin(theta) * xy[:, :, 0, 1].ravel())
        edge = np.tile(np.arange(count), views)
        no_covariance = np.zeros((len(edge), 2, 2))
        camera = np.repeat(np.arange(views), count)
        lines = LineMeasurements(camera, edge, self._model.edge_points[edge], rho, theta, no_covariance)
        offsets: FloatArray = (self.derivative(T_world_target, lines) @ z).reshape(views, count, 2)
        return offsets

    def disparity_corrections(
        self, xy: FloatArray, disparity: FloatArray, pose: RefinedPose
    ) -> tuple[FloatArray, FloatArray]:
        """What to add (k,), px, to disparities that were measured less those that a refined pose predicts, for what its
        frame tells of the calibration, and the standard deviations (k,) of that.

        xy (k, 2): left rectified points, px; disparity (k,), px: predicted.
        """
        if self._effect is None:
            return np.zeros(len(xy)), np.zeros(len(xy))
        derivatives = self._effect.disparity_derivatives(xy, disparity)
        own = slice(len(self._point_sigma), self.lasting)
        covariance = pose.joint_covariance[6:, 6:][own, own]
        return derivatives @ pose.z[own], np.sqrt(np.einsum("ki,ij,kj->k", derivatives, covariance, derivatives))

    def corrections(self, pose: RefinedPose, learned: Learned) -> Corrections | None:
        """What a refined pose, and what was learnt with it, tell of target and rig; None where both are exact.

        Of the rig as it was given, not of one for reduced images.
        """
        if self.lasting == 0:
            return None
        points = len(self._point_sigma)
        z, covariance = pose.z[: self.lasting], pose.joint_covariance[6:, 6:][: self.lasting, : self.lasting]
        moved = (self._point_sigma * z[:points]).reshape(-1, 3).tolist()
        moved_sigma = (self._point_sigma * np.sqrt(np.diagonal(covariance)[:points])).reshape(-1, 3).tolist()
        names = [name for name, s in zip(self._model.point_names, self._model.point_sigmas, strict=True) if s > 0.0]
        stated = self._point_sigma[::3].tolist()
        changed = (self._directions @ z[points:]).tolist()
        root = self._directions @ covariance[points:, points:]
        sigma = np.sqrt(np.einsum("ij,ij->i", root, self._directions)).tolist()
        parameters = calibration_parameters(self._views)
        rows = zip(parameters, changed, sigma, self._calibration_sigma.tolist(), strict=True)
        return Corrections(
            calibration={name: ParameterCorrection(v, s, own) for name, v, s, own in rows if own > 0.0},
            points=dict(zip(names, map(PointCorrection, moved, moved_sigma, stated), strict=True)),
            calibration_scale=float(pose.scales[CALIBRATION]),
            target_scale=float(pose.scales[TARGET]),
            calibration_distance=_distance(z[points:], covariance[points:, points:]),
            target_distance=_distance(z[:points], covariance[:points, :points]),
            frames=learned.frames,
        )


def _distance(z: FloatArray, covariance: FloatArray) -> float:
    """The largest of z (p,) along the principal axes of its covariance (p, p)."""
    return float(np.abs(np.linalg.eigh(covariance)[1].T @ z).max(initial=0.0))


def _root(covariance: FloatArray) -> FloatArray:
    """(n, r) whose square is a covariance (n, n) of rank r; of correlations, so that units don't matter."""
    sigma = np.sqrt(np.diagonal(covariance))
    units = np.where(sigma > 0.0, sigma, 1.0)
    eigenvalues, vectors = np.linalg.eigh(covariance / np.outer(units, units))
    kept = eigenvalues > max(_NEGLIGIBLE * float(eigenvalues[-1]), 0.0)
    root: FloatArray = units[:, None] * vectors[:, kept] * np.sqrt(eigenvalues[kept])
    return root
