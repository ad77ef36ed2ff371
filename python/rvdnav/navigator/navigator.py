"""The navigator itself: one frame in, one solution out."""

from __future__ import annotations

import time
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.core import Core, FrameResult
from rvdnav.errors import InputError
from rvdnav.navigator.calibration import CalibrationEffect
from rvdnav.navigator.gates import failed_gates, plausible_motion
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.navigator.measurement import Measurement, measure, measured_segments
from rvdnav.navigator.repeats import RepeatDetector
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.navigator.transitions import next_state
from rvdnav.navigator.windows import predicted_windows
from rvdnav.pose import ConstantVelocityFilter, PoseError, PredictedPose
from rvdnav.rig import Rig
from rvdnav.sequence import Frame
from rvdnav.solution import TOTAL, LineResidual, Mode, Reason, Solution, State
from rvdnav.target import EDGE_NAMES, Target

# An image with less than this is no picture of the target: mean grey level, share of saturated pixels, edge pixels.
_DARK_GREY = 1.0
_SATURATED = 0.5
_MIN_EDGE_PIXELS = 50
_MISSING = (Reason.LEFT_MISSING, Reason.RIGHT_MISSING)
_UNUSABLE = (Reason.LEFT_UNUSABLE, Reason.RIGHT_UNUSABLE)


@attrs.define
class _Attempt:
    """What came of one way to measure a frame."""

    measurement: Measurement | None
    reasons: frozenset[Reason]


class Navigator:
    """Follows a bracket through stereo frames.

    rig: two cameras.  target: with a four-bar bracket of known dimensions.  Options are the fields of
    NavigatorSettings and of the core's configuration (rvdnav_config), by name.

    Every solution is this frame's own measurement or none: a pose is published only if it passed every gate.
    Raises InputError for a rig or target that it cannot work with, TypeError for an unknown option, ValueError for
    an option out of range.
    """

    def __init__(self, rig: Rig, target: Target, **options: Any) -> None:
        if not rig.is_stereo:
            raise InputError("the rig has one camera: navigation needs two")
        if target.bracket is None or not target.dimensions_known:
            raise InputError(f"target {target.name}: navigation needs a four-bar bracket of known dimensions")
        names = {field.name for field in attrs.fields(NavigatorSettings)}
        self._settings = NavigatorSettings(**{k: v for k, v in options.items() if k in names})
        self._rig = rig
        self._bracket = target.bracket
        self._core = Core(rig, target, **{k: v for k, v in options.items() if k not in names})
        self._cameras = rectified_cameras(rig)
        self._calibration = None if rig.calibration_covariance is None else CalibrationEffect.of(rig)
        self._calibration_part = np.zeros((6, 6))
        self._filter = ConstantVelocityFilter()
        self._state = State.SEARCHING
        self._repeats = RepeatDetector()
        self._last_frame_ns: int | None = None
        self._last_pose_ns = 0
        self._polarity = self._unknown_polarity()

    def process(self, frame: Frame) -> Solution:
        """The solution of the next frame.  Raises CoreError if the core refuses the frame's images."""
        start = time.perf_counter()
        times: dict[str, float] = {}
        if self._last_frame_ns is not None and frame.timestamp_ns <= self._last_frame_ns:
            return self._without_measurement(frame.timestamp_ns, frozenset({Reason.TIME_ORDER}), {}, times, start)
        self._last_frame_ns = frame.timestamp_ns
        images = tuple(None if image is None else image.pixels for image in (frame.left, frame.right))
        missing = frozenset(reason for image, reason in zip(images, _MISSING, strict=True) if image is None)
        repeated = {Reason.DUPLICATE} if self._repeats.repeated(images) else set()
        if missing or repeated:
            return self._without_measurement(frame.timestamp_ns, missing | repeated, {}, times, start)
        return self._measure(frame.timestamp_ns, images, times, start)

    def _measure(
        self, timestamp_ns: int, images: tuple[NDArray[np.uint8] | None, ...], times: dict[str, float], start: float
    ) -> Solution:
        prediction = self._prediction(timestamp_ns)
        attempt = None if prediction is None else self._track(timestamp_ns, images, prediction, times)
        if attempt is None or attempt.reasons:
            searched = self._acquire(timestamp_ns, images, prediction, times)
            # Without a result either way, tell why the tracked edges were refused: they say more than the search.
            if not searched.reasons or attempt is None or attempt.measurement is None:
                attempt = searched
        segments = {} if attempt.measurement is None else measured_segments(attempt.measurement.frame)
        if attempt.reasons or attempt.measurement is None:
            return self._without_measurement(timestamp_ns, attempt.reasons, segments, times, start)
        pose = attempt.measurement.pose
        # The calibration errs alike in all frames: the filter, which takes errors for independent, isn't told of it.
        self._update_filter(timestamp_ns, attempt.measurement)
        if self._calibration is not None:
            self._calibration_part = self._calibration.pose_covariance(pose, attempt.measurement.lines)
        self._last_pose_ns = timestamp_ns
        self._polarity = attempt.measurement.polarity
        self._state = next_state(self._state, measured=True, coast_expired=False)
        times[TOTAL] = time.perf_counter() - start
        return Solution(
            timestamp_ns=timestamp_ns,
            state=self._state,
            mode=Mode.STEREO,
            T_world_target=pose.T_world_target,
            predicted_T_world_target=None if prediction is None else prediction.T_world_target,
            smoothed_T_world_target=self._filter.smoothed.T_world_target,
            covariance=pose.covariance + self._calibration_part,
            line_residuals=line_residuals(attempt.measurement),
            sigma0=pose.sigma0,
            view_lines=segments,
            stage_times=times,
        )

    def _unknown_polarity(self) -> NDArray[np.int64]:
        return np.zeros((len(self._rig.cameras), len(EDGE_NAMES)), np.int64)

    def _prediction(self, timestamp_ns: int) -> PredictedPose | None:
        if self._state not in (State.TRACKING, State.COASTING):
            return None
        return self._filter.predict(timestamp_ns)

    def _track(
        self,
        timestamp_ns: int,
        images: tuple[NDArray[np.uint8] | None, ...],
        prediction: PredictedPose,
        times: dict[str, float],
    ) -> _Attempt | None:
        """The edges sought where they are expected; None where that says too little."""
        try:
            windows = [
                predicted_windows(
                    prediction, self._bracket.edge_points, self._cameras, camera, self._polarity[camera], self._settings
                )
                for camera in range(len(images))
            ]
        except PoseError:  # predicted out of the cameras' sight
            return None
        if windows[0] is None or windows[1] is None:
            return None
        frame = self._core.process(images[0], images[1], windows[0], windows[1])
        return self._refine(timestamp_ns, images, frame, prediction.T_world_target, self._polarity, prediction, times)

    def _acquire(
        self,
        timestamp_ns: int,
        images: tuple[NDArray[np.uint8] | None, ...],
        prediction: PredictedPose | None,
        times: dict[str, float],
    ) -> _Attempt:
        """The bracket sought in the whole images."""
        frame = self._core.process(images[0], images[1])
        bracket = frame.bracket
        if bracket is None or not bracket.found:
            _add_times(times, frame)
            reasons = _unusable_views(frame)
            if not reasons:
                reasons.add(Reason.AMBIGUOUS if bracket is not None and bracket.ambiguous else Reason.NO_TARGET)
            if frame.limits:
                reasons.add(Reason.LIMIT)
            return _Attempt(None, frozenset(reasons))
        unknown = self._unknown_polarity()
        return self._refine(timestamp_ns, images, frame, bracket.T_world_target, unknown, prediction, times)

    def _refine(
        self,
        timestamp_ns: int,
        images: tuple[NDArray[np.uint8] | None, ...],
        frame: FrameResult,
        prior: NDArray[np.float64],
        polarity: NDArray[np.int64],
        prediction: PredictedPose | None,
        times: dict[str, float],
    ) -> _Attempt:
        _add_times(times, frame)
        start = time.perf_counter()
        try:
            measurement = measure(self._core, self._rig, self._bracket, frame, images, prior, polarity)
        except PoseError:
            return _Attempt(None, frozenset({Reason.DEGENERATE}))
        finally:
            times["pose"] = times.get("pose", 0.0) + time.perf_counter() - start
        config = self._core.config
        reasons = failed_gates(
            measurement, self._bracket, self._rig, self._settings, (config.range_min, config.range_max)
        )
        seconds = (timestamp_ns - self._last_pose_ns) * 1e-9
        if prediction is not None and not plausible_motion(measurement, prediction, seconds, self._settings):
            reasons |= {Reason.MOTION}
        if reasons:  # the likely cause, where there is one
            reasons |= _unusable_views(frame)
        return _Attempt(measurement, reasons)

    def _update_filter(self, timestamp_ns: int, measurement: Measurement) -> None:
        if self._state not in (State.TRACKING, State.COASTING):
            self._filter.reset()
        self._filter.update(timestamp_ns, measurement.pose.T_world_target, measurement.pose.covariance)

    def _without_measurement(
        self,
        timestamp_ns: int,
        reasons: frozenset[Reason],
        segments: dict[int, NDArray[np.float64]],
        times: dict[str, float],
        start: float,
    ) -> Solution:
        """No pose: coast on the prediction while that is allowed."""
        since_pose = timestamp_ns - self._last_pose_ns
        expired = since_pose > self._settings.coast_seconds * 1e9
        self._state = next_state(self._state, measured=False, coast_expired=expired)
        prediction = self._filter.predict(timestamp_ns) if self._state is State.COASTING and since_pose >= 0 else None
        times[TOTAL] = time.perf_counter() - start
        return Solution(
            timestamp_ns=timestamp_ns,
            state=self._state,
            reasons=reasons,
            predicted_T_world_target=None if prediction is None else prediction.T_world_target,
            covariance=None if prediction is None else prediction.covariance + self._calibration_part,
            view_lines=segments,
            stage_times=times,
        )


def line_residuals(measurement: Measurement) -> tuple[LineResidual, ...]:
    """Residuals of every edge in every view: of its line's two endpoints against the pose."""
    lines, pose = measurement.lines, measurement.pose
    agreed = np.zeros_like(measurement.sampled.attempted)
    np.add.at(agreed, (measurement.sampled.camera[measurement.inlier], measurement.sampled.edge[measurement.inlier]), 1)
    measured = {key: i for i, key in enumerate(zip(lines.camera.tolist(), lines.edge.tolist(), strict=True))}
    residuals = []
    for camera in range(agreed.shape[0]):
        for edge, name in enumerate(EDGE_NAMES):
            i = measured.get((camera, edge))
            ends = np.zeros(2) if i is None else pose.residuals[i]
            samples = int(agreed[camera, edge])
            rms, mean = float(np.sqrt(np.mean(ends**2))), float(np.mean(ends))
            residuals.append(LineResidual(camera, name, samples > 0, samples, rms, mean))
    return tuple(residuals)


def _unusable_views(frame: FrameResult) -> set[Reason]:
    return {reason for view, reason in zip(frame.views, _UNUSABLE, strict=True) if _unusable(view)}


def _unusable(view: Any) -> bool:
    return view is None or (
        view.mean_grey < _DARK_GREY or view.saturated > _SATURATED or view.edge_count < _MIN_EDGE_PIXELS
    )


def _add_times(times: dict[str, float], frame: FrameResult) -> None:
    """The stages' times: the slower of the two views, which run at once, plus the join."""
    for stage, joined in frame.stage_ns.items():
        slowest = max((view.stage_ns[stage] for view in frame.views if view is not None), default=0)
        times[stage] = times.get(stage, 0.0) + (slowest + joined) * 1e-9
