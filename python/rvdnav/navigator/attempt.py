"""Ways to measure a frame: its edges tracked where they are expected, or the target sought in the whole images."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from rvdnav.core import Core, FrameResult
from rvdnav.navigator.coarse import coarse_pose, measured_segments
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.gates import failed_gates
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.navigator.measurement import Measurement, measure
from rvdnav.navigator.seeker import lines_of, seek
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.navigator.sizes import Sizes
from rvdnav.navigator.stage_times import add_frame_times, lap, now
from rvdnav.navigator.two_fold import decide
from rvdnav.navigator.views import Images, Views, see
from rvdnav.navigator.windows import predicted_windows
from rvdnav.pose import PoseError, PredictedPose, difference
from rvdnav.pose.arrays import FloatArray, IntArray
from rvdnav.rig import Rig
from rvdnav.solution import Acquisition, Reason

# An image with less than this is no picture of the target: mean grey level, share of saturated pixels, edge pixels.
_DARK_GREY = 1.0
_SATURATED = 0.5
_MIN_EDGE_PIXELS = 50
# Of several poses: those this much less likely than the first are not looked into once one has passed, as a logarithm;
# coverage by which one is better than another; and how far apart they must be, in standard deviations, to be two.
_UNLIKELY = 8.0
_AS_WELL_COVERED = 0.08
_APART_SIGMAS = 5.0
# Part of all profiles that must agree where prints far from the edges were in the windows.
_WIDE_COVERAGE = 0.8
_UNREFUTED = frozenset({Reason.COVARIANCE, Reason.AMBIGUOUS, Reason.NOT_CONVERGED})
UNUSABLE = (Reason.LEFT_UNUSABLE, Reason.RIGHT_UNUSABLE)
"""Of the left and of the right camera."""


@attrs.frozen(eq=False)
class Attempt:
    """What came of one way to measure a frame: published only without reasons."""

    reasons: frozenset[Reason]
    frame: FrameResult
    images: Images
    measurement: Measurement | None = None
    sizes: Sizes | None = None
    """Of a target of unknown size: what would be known of it with this frame."""
    anew: bool = False
    """The sizes are from this frame alone, and the target was measured by them."""

    @property
    def passed(self) -> bool:
        """Whether nothing speaks against the measurement."""
        return not self.reasons and self.measurement is not None

    @property
    def segments(self) -> dict[int, FloatArray]:
        """Of the measurement, see `measured_segments`; none without one."""
        return {} if self.measurement is None else measured_segments(self.frame)

    @property
    def unusable(self) -> tuple[int, ...]:
        """Cameras whose image is there but no picture of a target."""
        views = zip(self.images, self.frame.views, strict=False)
        return tuple(camera for camera, (image, view) in enumerate(views) if image is not None and _unusable(view))

    @property
    def acquisition(self) -> Acquisition | None:
        """What the search of the whole images found; None if they were not searched."""
        found = self.frame.bracket
        return None if found is None else Acquisition(found.score, found.runner_up, found.hypotheses)


class Surveyor:
    """Measures single frames of one target with one rig; remembers nothing.

    times: stage name -> seconds, to which every call adds what it took.
    """

    def __init__(self, core: Core, rig: Rig, model: EdgeModel, settings: NavigatorSettings) -> None:
        self._core = core
        self._rig = rig
        self._model = model
        self._settings = settings
        self._cameras = rectified_cameras(rig)

    def track(
        self,
        images: Images,
        prediction: PredictedPose,
        polarity: IntArray,
        earlier_odds: float | None,
        times: dict[str, float],
    ) -> Attempt | None:
        """The edges sought where they are expected; None where that says too little.

        polarity (cameras, edges): as last published.  earlier_odds: see `two_fold.decide`.
        """
        if self._model.bracket is None:
            return self._track_any(images, prediction, polarity, earlier_odds, times)
        windows: list[Any] = [(), ()]
        try:
            for camera, image in enumerate(images):
                if image is None:
                    continue
                windows[camera] = predicted_windows(
                    prediction, self._model.edge_points, self._cameras, camera, polarity[camera], self._settings
                )
        except PoseError:  # predicted out of the cameras' sight
            return None
        if windows[0] is None or windows[1] is None:
            return None
        frame = self._process(images, windows, times)
        return self._refine(frame, images, prediction.T_world_target, polarity, prediction, earlier_odds, times)

    def acquire(self, images: Images, prediction: PredictedPose | None, times: dict[str, float]) -> Attempt:
        """The bracket sought in the whole images; no other target can be."""
        if self._model.bracket is None:
            attempt = self._nothing(see(self._core, images, times), images, Reason.NO_PRIOR)
            reasons = {UNUSABLE[camera] for camera in attempt.unusable}
            return attrs.evolve(attempt, reasons=frozenset(reasons)) if reasons else attempt
        frame = self._process(images, [(), ()], times)
        bracket = frame.bracket
        if bracket is None or not bracket.found:
            reasons = {UNUSABLE[camera] for camera in Attempt(frozenset(), frame, images).unusable}
            if not reasons:
                reasons.add(Reason.AMBIGUOUS if bracket is not None and bracket.ambiguous else Reason.NO_TARGET)
            if frame.limits:
                reasons.add(Reason.LIMIT)
            return Attempt(frozenset(reasons), frame, images)
        unknown = np.zeros((len(self._rig.cameras), len(self._model)), np.int64)
        return self._refine(frame, images, bracket.T_world_target, unknown, prediction, None, times)

    def _track_any(
        self,
        images: Images,
        prediction: PredictedPose,
        polarity: IntArray,
        earlier_odds: float | None,
        times: dict[str, float],
    ) -> Attempt:
        """A target of any number of edges, each of which may be one of several lines."""
        views = see(self._core, images, times)
        try:
            found = seek(self._core, views, prediction, self._model, self._cameras, polarity, self._settings, times)
        except PoseError:
            return self._nothing(views, images, Reason.DEGENERATE)
        attempts: list[Attempt] = []
        for association, frame in found:
            passed = any(attempt.passed for attempt in attempts)
            if passed and association.log_likelihood < found[0][0].log_likelihood - _UNLIKELY:
                break
            prior = association.T_world_target
            attempt = self._refine(frame, images, prior, polarity, prediction, earlier_odds, times)
            if association.half_rho > self._settings.window_max_rho_px and _covered(attempt) < _WIDE_COVERAGE:
                attempt = attrs.evolve(attempt, reasons=attempt.reasons | {Reason.TOO_FEW_LINES})
            attempts.append(attempt)
        return likeliest(attempts)

    def _nothing(self, views: Views, images: Images, reason: Reason) -> Attempt:
        return Attempt(frozenset({reason}), lines_of(views, [], None, len(self._model)), images)

    def _process(self, images: Images, windows: list[Any], times: dict[str, float]) -> FrameResult:
        frame = self._core.process(images[0], images[1] if len(images) > 1 else None, *windows)
        add_frame_times(times, frame)
        return frame

    def _refine(
        self,
        frame: FrameResult,
        images: Images,
        prior: FloatArray,
        polarity: IntArray,
        prediction: PredictedPose | None,
        earlier_odds: float | None,
        times: dict[str, float],
    ) -> Attempt:
        start = now()
        try:
            coarse = coarse_pose(self._model, frame, self._cameras, prior)
            measurement = measure(self._core, self._rig, self._model, images, coarse, polarity)
            if len(measurement.cameras) == 1:
                decision = decide(measurement, self._model, self._cameras, prediction, earlier_odds)
                if decision.swapped:
                    T = decision.T_world_target
                    measurement = measure(self._core, self._rig, self._model, images, T, polarity)
                measurement = decision.widened(measurement)
        except PoseError:
            return Attempt(frozenset({Reason.DEGENERATE}), frame, images)
        finally:
            lap(times, "pose", start)
        config = self._core.config
        gate = (config.range_min, config.range_max)
        reasons = failed_gates(measurement, self._model, frame, self._rig, self._settings, gate)
        return Attempt(reasons, frame, images, measurement)


def likeliest(attempts: list[Attempt]) -> Attempt:
    """Of attempts at the same images from different poses, the likeliest first: the passed one that the images cover
    most; ambiguous if another pose is covered as well, refused for one that is covered better but can't be published.
    The first if none passed."""
    standing = [attempt for attempt in attempts if attempt.reasons <= _UNREFUTED]
    passed = [attempt for attempt in standing if attempt.passed]
    if not passed:
        return attempts[0]
    best, chosen = max(standing, key=_covered), max(passed, key=_covered)
    if _covered(best) - _covered(chosen) > _AS_WELL_COVERED:
        return best
    for other in standing:
        if _covered(chosen) - _covered(other) < _AS_WELL_COVERED and _apart(chosen, other):
            return attrs.evolve(chosen, reasons=frozenset({Reason.AMBIGUOUS}))
    return chosen


def _covered(attempt: Attempt) -> float:
    return 0.0 if attempt.measurement is None else attempt.measurement.total_coverage


def _apart(a: Attempt, b: Attempt) -> bool:
    """Whether two measurements are of different poses."""
    if a.measurement is None or b.measurement is None:
        return False
    error = difference(a.measurement.pose.T_world_target, b.measurement.pose.T_world_target)
    covariance = a.measurement.pose.covariance + b.measurement.pose.covariance
    return float(error @ np.linalg.solve(covariance, error)) > _APART_SIGMAS**2


def _unusable(view: Any) -> bool:
    return view is None or (
        view.mean_grey < _DARK_GREY or view.saturated > _SATURATED or view.edge_count < _MIN_EDGE_PIXELS
    )
