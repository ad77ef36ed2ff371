"""The navigator itself: one frame in, one solution out."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from rvdnav.core import Core
from rvdnav.errors import CoreError, InputError
from rvdnav.navigator.attempt import Attempt
from rvdnav.navigator.edge_model import edge_model
from rvdnav.navigator.expectation import Expectation
from rvdnav.navigator.fields import Fields, declared_fields, noticed_fields
from rvdnav.navigator.gates import contradicted, plausible_motion, too_far_apart
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.navigator.initial_pose import checked_pose, pose_covariance
from rvdnav.navigator.intake import take_in
from rvdnav.navigator.knowledge import Knowledge, Learned
from rvdnav.navigator.measurement import Measurement
from rvdnav.navigator.memory import Memory
from rvdnav.navigator.options import NavigatorOptions, split_options
from rvdnav.navigator.residuals import edge_residuals
from rvdnav.navigator.shutter import Motion
from rvdnav.navigator.sizing import SizingSurveyor
from rvdnav.navigator.stage_times import lap, now
from rvdnav.navigator.surveyor import Surveyor
from rvdnav.navigator.transitions import next_state
from rvdnav.navigator.views import Images, noise_sigma, reduced, smoothed
from rvdnav.pose import ConstantVelocityFilter, PoseError, PredictedPose
from rvdnav.pose.arrays import FloatArray
from rvdnav.rig import Rig
from rvdnav.sequence import Frame
from rvdnav.solution import TOTAL, LearnedDimensions, Mode, Reason, Solution, State
from rvdnav.target import Target

if TYPE_CHECKING:
    from typing_extensions import Unpack

_MIN_EDGES = 4
# What no gate foresaw: numbers that determine no pose.
_UNDETERMINED = (PoseError, np.linalg.LinAlgError, CoreError, ArithmeticError, ValueError)
# What noise or blur may have done to a target that is there: fewer pixels may show it.
_HIDDEN = frozenset(
    {
        Reason.NO_TARGET,
        Reason.LIMIT,
        Reason.AMBIGUOUS,
        Reason.TOO_FEW_LINES,
        Reason.NOT_CONVERGED,
        Reason.COVARIANCE,
        Reason.DEGENERATE,
    }
)
# What errors of target or calibration do to a frame that is refused.
_MISFIT = frozenset({Reason.RESIDUALS, Reason.CROSS_VIEW})
_MONO = (Mode.MONO_LEFT, Mode.MONO_RIGHT)


class Navigator:
    """Follows a target through frames of two cameras or of one.

    rig: one camera or two.  target: with straight edges; a four-bar bracket's dimensions may be unknown, two cameras
    measure them.  initial_pose (4, 4): T_world_target at the first frame, good to about 1 % of the range and 1.5
    degrees; only a four-bar bracket is found without it.  options: see `NavigatorOptions`.

    Every solution is this frame's own measurement or none: a pose is published only if it passed every gate.  A frame
    with one usable image is measured by that alone, from the target's known size.
    Raises InputError for a target or an initial pose that it cannot work with, TypeError for an unknown option,
    ValueError for an option out of range.
    """

    def __init__(
        self,
        rig: Rig,
        target: Target,
        *,
        initial_pose: FloatArray | None = None,
        **options: Unpack[NavigatorOptions],
    ) -> None:
        model = edge_model(target)
        if len(model) < _MIN_EDGES:
            raise InputError(f"target {target.name}: navigation needs {_MIN_EDGES} edges or more")
        if not (target.dimensions_known or (rig.is_stereo and target.bracket is not None)):
            raise InputError(f"target {target.name}: measuring its unknown dimensions needs a bracket and two cameras")
        self._settings, config = split_options(options)
        self._rig = rig
        self._model = model
        self._knowledge = Knowledge(rig, model if target.dimensions_known else model.exact)
        self._reduction = self._settings.reduction(rig.width, rig.height)
        seen = rig.reduced(self._reduction)
        knowledge = self._knowledge if self._reduction == 1 else self._knowledge.reduced(seen)
        self._sizing = None
        if not target.dimensions_known:
            self._sizing = SizingSurveyor(seen, target, knowledge, self._settings, **config)
        self._surveyor = self._sizing or Surveyor(Core(seen, target, **config), seen, model, knowledge, self._settings)
        self._filter = ConstantVelocityFilter()
        given = None if initial_pose is None else checked_pose(initial_pose, model, rectified_cameras(rig))
        self._memory = attrs.evolve(
            Memory.blank(len(rig.cameras), len(model), self._knowledge.lasting), initial_pose=given
        )

    @property
    def memory(self) -> Memory:
        """What it carries to the next frame; set it to go on where another navigator left off.

        Setting it raises ValueError where it is of another number of cameras or edges.
        """
        sizes = None if self._sizing is None else self._sizing.sizes
        return attrs.evolve(self._memory, filter_state=self._filter.state, sizes=sizes)

    @memory.setter
    def memory(self, memory: Memory) -> None:
        memory.check_fits(len(self._rig.cameras), len(self._model), self._knowledge.lasting)
        self._memory = memory
        self._filter.state = memory.filter_state
        if self._sizing is not None:
            self._sizing.sizes = memory.sizes

    @property
    def learned_target(self) -> Target | None:
        """Of a target of unknown dimensions: with those learnt so far, None before there are any."""
        return None if self._sizing is None else self._sizing.target

    def process(self, frame: Frame) -> Solution:
        """The solution of the next frame, whatever its images show.

        Raises ValueError for an image that hasn't the rig's size; whatever it raises, the memory is as it was before.
        """
        self._check_sizes(frame)
        start = now()
        times: dict[str, float] = {}
        before = self.memory
        try:
            solution = self._solution(frame, times)
        except BaseException:
            self.memory = before
            raise
        times[TOTAL] = now() - start
        return attrs.evolve(solution, stage_times=times)

    def _solution(self, frame: Frame, times: dict[str, float]) -> Solution:
        """The solution but for its times, to which the stages add theirs."""
        last_ns = self._memory.last_frame_ns
        if last_ns is not None and frame.timestamp_ns <= last_ns:
            return self._without_pose(frame.timestamp_ns, frozenset({Reason.TIME_ORDER}), None)
        self._remember(last_frame_ns=frame.timestamp_ns)
        self._take_up_initial_pose(frame.timestamp_ns)
        images, notes, digests = take_in(frame, self._memory.image_digests)
        self._remember(image_digests=digests)
        if all(image is None for image in images):
            return self._without_pose(frame.timestamp_ns, notes, None)
        start = now()
        fields = self._fields(images)
        lap(times, "fields", start)
        if fields.noticed:
            notes |= {Reason.INTERLACED}
        unmeasured = self.memory
        try:
            attempt, unusable = self._measure(frame.timestamp_ns, fields.first, times)
            notes |= unusable
            if attempt.reasons or attempt.measurement is None:
                return self._without_pose(frame.timestamp_ns, notes | attempt.reasons, attempt)
            measurement = attempt.measurement
            if fields.second is not None:
                other, _ = self._measure(frame.timestamp_ns, fields.second, times)
                if other.reasons or other.measurement is None:
                    return self._without_pose(frame.timestamp_ns, notes | other.reasons, other)
                if too_far_apart(measurement, other.measurement, self._settings):
                    return self._without_pose(frame.timestamp_ns, notes | {Reason.COVARIANCE}, attempt)
                measurement = measurement.among([other.measurement])
            return self._published(frame.timestamp_ns, notes, attempt, measurement)
        except _UNDETERMINED:
            self.memory = unmeasured
            return self._without_pose(frame.timestamp_ns, notes | {Reason.DEGENERATE}, None)

    def _fields(self, images: Images) -> Fields:
        """The images as they are measured: of interlaced ones the fields."""
        if self._rig.scan != "progressive":
            return declared_fields(images, self._rig.scan)
        fields, odds = noticed_fields(images, self._memory.interlaced)
        self._remember(interlaced=odds)
        return fields

    def _check_sizes(self, frame: Frame) -> None:
        width, height = self._rig.width, self._rig.height
        for image in (frame.left, frame.right)[: len(self._rig.cameras)]:
            if image is not None and image.pixels.shape != (height, width):
                size = "x".join(str(length) for length in image.pixels.shape[::-1])
                raise ValueError(f"an image of {size} px, but the rig's are {width}x{height}")

    def _remember(self, **changes: Any) -> None:
        self._memory = attrs.evolve(self._memory, **changes)

    def _take_up_initial_pose(self, timestamp_ns: int) -> None:
        """Begin at the first frame as if the given pose had been predicted for it."""
        T = self._memory.initial_pose
        if T is not None and not self._filter.initialised:
            self._filter.update(timestamp_ns, T, pose_covariance(T))
            self._remember(state=State.COASTING, last_pose_ns=timestamp_ns)

    def _measure(self, timestamp_ns: int, images: Images, times: dict[str, float]) -> tuple[Attempt, frozenset[Reason]]:
        """The best attempt at a frame, and the cameras whose images turned out to be no pictures of the target."""
        attempt = self._search(timestamp_ns, images, times)
        unusable = attempt.unusable
        if attempt.passed or not unusable:
            return attempt, frozenset()
        notes = attempt.unusable_reasons
        left_over = tuple(None if camera in unusable else image for camera, image in enumerate(images))
        if all(image is None for image in left_over):
            return attrs.evolve(attempt, reasons=notes, measurement=None), notes
        return self._search(timestamp_ns, left_over, times), notes

    def _search(self, timestamp_ns: int, images: Images, times: dict[str, float]) -> Attempt:
        """The target in the images as they are or, where noise or blur hide it, smoothed; first smoothed if there is
        much noise."""
        images = reduced(images, self._reduction)
        noise = max(noise_sigma(image) for image in images if image is not None)
        sigma = self._settings.smoothing_px * max(1.0, math.sqrt(noise / self._settings.noisy_sigma))
        orders: tuple[float, ...] = (sigma, 0.0) if noise > self._settings.noisy_sigma else (0.0, sigma)
        if self._model.bracket is None and noise <= self._settings.noisy_sigma:
            # Smoothing joins an edge and the prints beside it, and what fits both is no pose.
            orders = (0.0,)
        attempts: list[Attempt] = []
        for smoothing in orders:
            before = self._filter.state
            attempts.append(self._searched(timestamp_ns, smoothed(images, smoothing), times))
            if attempts[-1].passed or attempts[-1].unusable or not attempts[-1].reasons <= _HIDDEN:
                return attempts[-1]
            self._filter.state = before
        return attempts[0]

    def _searched(self, timestamp_ns: int, images: Images, times: dict[str, float]) -> Attempt:
        """Tracked where there is a prediction, else or failing that sought in the whole images."""
        prediction = self._prediction(timestamp_ns)
        tracked = None
        if prediction is not None:
            tracked = self._surveyor.track(images, self._expected(prediction), self._learned, times)
            if tracked is not None:
                tracked = self._against(prediction, timestamp_ns, tracked)
                if self._model.bracket is None:
                    return self._track_loosely(timestamp_ns, images, tracked, times)
                if tracked.passed or Reason.AMBIGUOUS in tracked.reasons or tracked.unusable:
                    return tracked
        # What the images have not confirmed yet doesn't speak against what they show elsewhere.
        unconfirmed = self._memory.held_odds is not None or self._memory.initial_pose is not None
        following = None if unconfirmed else prediction
        searched = self._surveyor.acquire(images, following, self._learned, times)
        if following is not None:
            searched = self._against(following, timestamp_ns, searched)
        # Without a result either way, tell why the tracked edges were refused: they say more than the search.
        if not searched.passed and tracked is not None and tracked.measurement is not None:
            return tracked
        return searched

    @property
    def _learned(self) -> Learned:
        """What earlier frames have taught; with the target's motion where the shutter rolls."""
        motion = Motion.of(self._filter.state) if self._rig.line_delay_ns > 0 else None
        return attrs.evolve(self._memory.learned, motion=motion)

    def _track_loosely(self, timestamp_ns: int, images: Images, tracked: Attempt, times: dict[str, float]) -> Attempt:
        """What cannot be sought in the whole images is sought farther around, whatever its velocity was."""
        if tracked.passed or tracked.unusable:
            return tracked
        before = self._filter.state
        self._filter.loosen()
        prediction = self._filter.predict(timestamp_ns)
        attempt = self._surveyor.track(images, self._expected(prediction), self._learned, times)
        if attempt is not None:
            attempt = self._against(prediction, timestamp_ns, attempt)
            if attempt.passed:
                return attempt
        self._filter.state = before
        return tracked

    def _against(self, prediction: PredictedPose, timestamp_ns: int, attempt: Attempt) -> Attempt:
        """The attempt, refused where the target cannot have come to its pose."""
        if attempt.measurement is None:
            return attempt
        seconds = (timestamp_ns - self._memory.last_pose_ns) * 1e-9
        acquired = attempt.acquisition is not None
        lasting = np.zeros((6, 6))
        if self._rig.is_stereo and len(attempt.measurement.cameras) == 1:
            # One view errs otherwise than two do, also by what errs alike in all frames.
            lasting = self._memory.lasting_part + attempt.measurement.pose.covariance
        if plausible_motion(attempt.measurement, acquired, prediction, lasting, seconds, self._settings):
            return attempt
        return attrs.evolve(attempt, reasons=attempt.reasons | {Reason.MOTION})

    def _prediction(self, timestamp_ns: int) -> PredictedPose | None:
        followed = self._memory.state in (State.TRACKING, State.COASTING) or self._memory.held_odds is not None
        return self._filter.predict(timestamp_ns) if followed else None

    def _expected(self, prediction: PredictedPose) -> Expectation:
        return Expectation(prediction, self._memory.polarity, self._memory.held_odds)

    def _published(
        self, timestamp_ns: int, notes: frozenset[Reason], attempt: Attempt, measurement: Measurement
    ) -> Solution:
        predicted = self._prediction(timestamp_ns)
        # Calibration and learnt sizes err alike in all frames: the filter, which takes errors for independent, isn't
        # told of them.
        self._update_filter(timestamp_ns, measurement.pose.T_world_target, measurement.own_covariance)
        lasting = measurement.pose.covariance - measurement.own_covariance
        if self._sizing is not None:
            lasting += self._sizing.size_part(attempt)
            self._sizing.sizes = attempt.sizes or self._sizing.sizes
        state = next_state(self._memory.state, measured=True, coast_expired=False)
        self._remember(state=state, lasting_part=lasting, learned=measurement.learned)
        self._remember(last_pose_ns=timestamp_ns, polarity=measurement.polarity, held_odds=None, initial_pose=None)
        cameras = measurement.cameras
        corrections = self._knowledge.corrections(measurement.pose, measurement.learned)
        return Solution(
            timestamp_ns=timestamp_ns,
            state=state,
            mode=Mode.STEREO if len(cameras) > 1 else _MONO[cameras[0]],
            reasons=notes | contradicted(corrections),
            T_world_target=measurement.pose.T_world_target,
            predicted_T_world_target=None if predicted is None else predicted.T_world_target,
            smoothed_T_world_target=self._filter.smoothed.T_world_target,
            rival_T_world_target=measurement.rival,
            covariance=measurement.own_covariance + self._memory.lasting_part,
            acquisition=attempt.acquisition,
            dimensions=self._learned_dimensions(),
            corrections=corrections,
            line_residuals=edge_residuals(measurement, self._model, self._reduction),
            sigma0=measurement.pose.sigma0,
            view_lines=self._drawn(attempt),
        )

    def _drawn(self, attempt: Attempt) -> dict[int, FloatArray]:
        """Its segments in px of the images as they came."""
        return {camera: self._reduction * ends for camera, ends in attempt.segments.items()}

    def _learned_dimensions(self) -> LearnedDimensions | None:
        sizes = None if self._sizing is None else self._sizing.sizes
        return None if sizes is None else sizes.report()

    def _update_filter(self, timestamp_ns: int, T_world_target: FloatArray, covariance: FloatArray) -> None:
        if self._prediction(timestamp_ns) is None or self._memory.initial_pose is not None:
            self._filter.reset()
        self._filter.update(timestamp_ns, T_world_target, covariance)

    def _without_pose(self, timestamp_ns: int, reasons: frozenset[Reason], attempt: Attempt | None) -> Solution:
        """No pose: coast on the prediction while that is allowed."""
        since_pose = timestamp_ns - self._memory.last_pose_ns
        expired = since_pose > self._settings.coast_seconds * 1e9
        state = next_state(self._memory.state, measured=False, coast_expired=expired)
        rival = self._hold(timestamp_ns, state, attempt)
        self._remember(state=state)
        if attempt is not None and attempt.measurement is not None and attempt.reasons <= _MISFIT:
            measurement = attempt.measurement
            reasons |= contradicted(self._knowledge.corrections(measurement.pose, measurement.learned))
        if state is State.LOST:
            self._remember(initial_pose=None)
        prediction = self._filter.predict(timestamp_ns) if state is State.COASTING and since_pose >= 0 else None
        return Solution(
            timestamp_ns=timestamp_ns,
            state=state,
            reasons=reasons,
            predicted_T_world_target=None if prediction is None else prediction.T_world_target,
            rival_T_world_target=rival,
            covariance=None if prediction is None else prediction.covariance + self._memory.lasting_part,
            acquisition=None if attempt is None else attempt.acquisition,
            dimensions=self._learned_dimensions(),
            view_lines={} if attempt is None else self._drawn(attempt),
        )

    def _hold(self, timestamp_ns: int, state: State, attempt: Attempt | None) -> FloatArray | None:
        """While searching with one view, follow the likelier of two poses until later frames decide; its rival."""
        held = None
        rival = None
        if state is State.SEARCHING and attempt is not None and attempt.reasons == {Reason.AMBIGUOUS}:
            measurement = attempt.measurement
            if measurement is not None:
                self._update_filter(timestamp_ns, measurement.pose.T_world_target, measurement.own_covariance)
                held, rival = measurement.log_odds, measurement.rival
                self._remember(polarity=measurement.polarity)
        self._remember(held_odds=held)
        return rival
