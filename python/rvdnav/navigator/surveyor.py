"""Ways to measure a frame: its edges tracked where they are expected, or the target sought in the whole images."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from rvdnav.core import Core, FrameResult
from rvdnav.navigator.attempt import Attempt, failed
from rvdnav.navigator.choice import best_attempt
from rvdnav.navigator.coarse import coarse_pose
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.expectation import Expectation
from rvdnav.navigator.faces import face_widths
from rvdnav.navigator.gates import failed_gates
from rvdnav.navigator.geometry import edge_normals, moved_ends, project_edges, rectified_cameras
from rvdnav.navigator.knowledge import Knowledge, Learned
from rvdnav.navigator.measurement import Measurement, measure
from rvdnav.navigator.seeker import chosen_lines, seek
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.navigator.shutter import RollingShutter
from rvdnav.navigator.stage_times import lap, now
from rvdnav.navigator.two_fold import decide
from rvdnav.navigator.views import Images, Views, look, see
from rvdnav.navigator.windows import predicted_windows
from rvdnav.pose import PoseError, PredictedPose
from rvdnav.pose.arrays import FloatArray, IntArray
from rvdnav.rig import Rig
from rvdnav.solution import Reason

# Of several poses those this much less likely than the first, as a logarithm, are not looked into once one has passed.
_UNLIKELY = 8.0
# How far a coarse pose may lie from the prior and beyond the range gate, as a part of the range; no window of the edges
# is wide enough for more.
_MAX_SHIFT = 0.5
_RANGE_MARGIN = 0.1
# A measured edge lies beside the place where the search saw it if it is more than this part of its bar's width off.  A
# pose shifted by a bar's width moves half of the edges along themselves, so that a third of them are asked.
_BESIDE = 0.5
_BESIDE_EDGES = 1.0 / 3.0
# Part of all profiles that must agree where prints far from the edges were in the windows.
_WIDE_COVERAGE = 0.8


class Surveyor:
    """Measures single frames of one target with one rig; remembers nothing.

    times: stage name -> seconds, to which every call adds what it took.
    """

    def __init__(
        self, core: Core, rig: Rig, model: EdgeModel, knowledge: Knowledge, settings: NavigatorSettings
    ) -> None:
        self._core = core
        self._rig = rig
        self._model = model
        self._knowledge = knowledge
        self._settings = settings
        self._cameras = rectified_cameras(rig)

    def track(self, images: Images, expected: Expectation, learned: Learned, times: dict[str, float]) -> Attempt | None:
        """The edges sought where they are expected; None where that says too little."""
        if self._model.bracket is None:
            return self._track_any(images, expected, learned, times)
        prediction = expected.prediction
        windows: list[Any] = [(), ()]
        try:
            offsets = self._knowledge.edge_offsets(prediction.T_world_target, self._knowledge.expected(learned))
            if learned.motion is not None:
                shutter = RollingShutter(self._rig, self._model, learned.motion)
                offsets = offsets + shutter.edge_offsets(prediction.T_world_target)
            for camera, image in enumerate(images):
                if image is None:
                    continue
                polarity = expected.polarity[camera]
                windows[camera] = predicted_windows(
                    prediction, self._model, self._cameras, camera, polarity, offsets[camera], self._settings
                )
        except PoseError:  # predicted out of the cameras' sight
            return None
        if windows[0] is None or windows[1] is None:
            return None
        frame = look(self._core, images, times, windows)
        return self._refine(frame, images, prediction.T_world_target, expected, learned, times)

    def acquire(
        self, images: Images, prediction: PredictedPose | None, learned: Learned, times: dict[str, float]
    ) -> Attempt:
        """The bracket sought in the whole images; no other target can be."""
        if self._model.bracket is None:
            return failed(self._without_lines(see(self._core, images, times)), images, Reason.NO_PRIOR)
        frame = look(self._core, images, times)
        bracket = frame.bracket
        if bracket is None or not bracket.found:
            ambiguous = bracket is not None and bracket.ambiguous
            attempt = failed(frame, images, Reason.AMBIGUOUS if ambiguous else Reason.NO_TARGET)
            return attrs.evolve(attempt, reasons=attempt.reasons | {Reason.LIMIT}) if frame.limits else attempt
        expected = None if prediction is None else Expectation(prediction, self._unknown_polarity(), None)
        return self._refine(frame, images, bracket.T_world_target, expected, learned, times)

    def _track_any(self, images: Images, expected: Expectation, learned: Learned, times: dict[str, float]) -> Attempt:
        """A target of any number of edges, each of which may be one of several lines."""
        views = see(self._core, images, times)
        try:
            found = seek(self._core, views, expected, self._model, self._cameras, self._settings, times)
        except PoseError:
            return Attempt(frozenset({Reason.DEGENERATE}), self._without_lines(views), images)
        attempts: list[Attempt] = []
        for association, frame in found:
            passed = any(attempt.passed for attempt in attempts)
            if passed and association.log_likelihood < found[0][0].log_likelihood - _UNLIKELY:
                break
            attempt = self._refine(frame, images, association.T_world_target, expected, learned, times)
            if association.half_rho > self._settings.window_max_rho_px and attempt.coverage < _WIDE_COVERAGE:
                attempt = attrs.evolve(attempt, reasons=attempt.reasons | {Reason.TOO_FEW_LINES})
            attempts.append(attempt)
        return best_attempt(attempts, self._settings)

    def _without_lines(self, views: Views) -> FrameResult:
        return chosen_lines(views, [], None, len(self._model))

    def _unknown_polarity(self) -> IntArray:
        return np.zeros((len(self._rig.cameras), len(self._model)), np.int64)

    def _refine(
        self,
        frame: FrameResult,
        images: Images,
        prior: FloatArray,
        expected: Expectation | None,
        learned: Learned,
        times: dict[str, float],
    ) -> Attempt:
        """The pose measured from a frame's lines, near the prior (4, 4), and judged."""
        polarity = self._unknown_polarity() if expected is None else expected.polarity
        start = now()
        try:
            coarse, z = coarse_pose(self._model, frame, self._cameras, prior, self._knowledge, learned)
            astray = self._astray(coarse, prior, acquired=frame.bracket is not None)
            if astray is not None:
                return Attempt(frozenset({astray}), frame, images)
            measurement = self._measure(images, coarse, polarity, learned, z)
            if len(measurement.cameras) == 1:
                prediction, odds = (None, None) if expected is None else (expected.prediction, expected.earlier_odds)
                decision = decide(measurement, self._model, self._cameras, prediction, odds)
                if decision.swapped:
                    T = decision.T_world_target
                    measurement = self._measure(images, T, polarity, learned)
                measurement = decision.widened(measurement)
        except PoseError:
            return Attempt(frozenset({Reason.DEGENERATE}), frame, images)
        finally:
            lap(times, "pose", start)
        reasons = failed_gates(
            measurement, self._model, frame, self._rig, self._knowledge, self._settings, self._core.config
        )
        if frame.bracket is not None and self._beside(measurement, prior):
            reasons |= {Reason.DISPLACED}
        return Attempt(reasons, frame, images, measurement)

    def _beside(self, measurement: Measurement, acquired: FloatArray) -> bool:
        """Whether edges were measured about a bar's width beside where the search saw them, in the first view."""
        camera = int(measurement.cameras[0])
        T, z = measurement.pose.T_world_target, measurement.pose.z[: self._knowledge.lasting]
        xy, before = (project_edges(self._cameras, camera, pose, self._model.edge_points)[0] for pose in (T, acquired))
        ends = np.tile([0.0, 1.0], (len(self._model), 1))
        xy = moved_ends(xy, ends, self._knowledge.edge_offsets(T, z)[camera])
        across = np.abs(np.einsum("mi,mi->m", (xy - before).mean(axis=1), edge_normals(before)))
        width = np.abs(face_widths(self._cameras, T, self._model)[camera])
        return bool(np.quantile(across / width, 1.0 - _BESIDE_EDGES) > _BESIDE)

    def _measure(
        self, images: Images, T: FloatArray, polarity: IntArray, learned: Learned, z: FloatArray | None = None
    ) -> Measurement:
        return measure(self._core, self._rig, self._model, self._knowledge, learned, images, T, polarity, z)

    def _astray(self, coarse: FloatArray, prior: FloatArray, acquired: bool) -> Reason | None:
        """What tells that lines which don't belong together have led the coarse pose (4, 4) away from the prior."""
        nearest, farthest = self._core.config.range_min, self._core.config.range_max
        distance = float(np.linalg.norm(coarse[:3, 3]))
        if acquired and not nearest * (1.0 - _RANGE_MARGIN) <= distance <= farthest * (1.0 + _RANGE_MARGIN):
            return Reason.RANGE_GATE
        shift = float(np.linalg.norm(coarse[:3, 3] - prior[:3, 3]))
        return None if shift <= _MAX_SHIFT * float(np.linalg.norm(prior[:3, 3])) else Reason.NOT_CONVERGED
