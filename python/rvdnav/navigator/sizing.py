"""Measures a bracket of unknown size: finds it, learns its dimensions, and navigates by what is learnt."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.bracket import EDGE_NAMES
from rvdnav.core import Core
from rvdnav.navigator.attempt import Attempt, failed
from rvdnav.navigator.bar_frames import find_bar_frames
from rvdnav.navigator.edge_model import edge_model
from rvdnav.navigator.expectation import Expectation
from rvdnav.navigator.frame_pairs import BracketCandidate, bracket_candidates, plausible
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.navigator.knowledge import Knowledge, Learned
from rvdnav.navigator.measurement import Measurement, measure
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.navigator.sizes import Sizes
from rvdnav.navigator.stage_times import lap, now
from rvdnav.navigator.surveyor import Surveyor
from rvdnav.navigator.views import Images, look, see
from rvdnav.pose import PoseError, PredictedPose, difference, refine_shape, size_derivatives
from rvdnav.pose.arrays import FloatArray
from rvdnav.rig import Rig
from rvdnav.solution import Reason
from rvdnav.target import Target
from rvdnav.trapezoid import Trapezoid

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from rvdnav.core.options import CoreOptions

# Candidates that are measured, and rounds of measuring and resizing until the sizes stay within a part of their sigma.
_MAX_MEASURED = 6
_MAX_ROUNDS = 4
_SETTLED_SIGMAS = 0.3
# The bases must differ by this many standard deviations, and by this part of the long one, to tell one from the other.
_TAPER_SIGMAS = 5.0
_LEAST_TAPER = 0.03
# A first measurement vaguer than this, as a part of the long base, is none.
_MAX_SIGMA_PART = 0.05
# Poses and shapes nearer than this are the same: m a metre of range, rad, and as a part of the long base.
_SAME_PLACE = 0.03
_SAME_TURN = 0.17
_SAME_SIZE = 0.05


class SizingSurveyor:
    """Measures single frames as `Surveyor` does, of a bracket whose size only earlier frames have told.

    sizes: what they told, None before the first; it changes only when it is set.  What a frame would add is in its
    attempt.  Until the size is known, frames need both views.
    """

    def __init__(
        self, rig: Rig, target: Target, knowledge: Knowledge, settings: NavigatorSettings, **config: Unpack[CoreOptions]
    ) -> None:
        self._rig = rig
        self._target = target
        self._knowledge = knowledge
        self._settings = settings
        self._cameras = rectified_cameras(rig)
        self._blind = Core(rig, **config)
        self._known = Core(rig, **config)  # looks for the target of the size that is known so far
        self._built: tuple[bytes, Surveyor] | None = None
        self.sizes: Sizes | None = None

    @property
    def target(self) -> Target | None:
        """With the sizes as learnt so far."""
        return None if self.sizes is None else self._target.resized(self.sizes.shape)

    def size_part(self, attempt: Attempt) -> FloatArray:
        """Covariance (6, 6) of a measured pose by that of the sizes that it was measured with."""
        sizes, measurement = attempt.sizes if attempt.anew else self.sizes, attempt.measurement
        if sizes is None or measurement is None:
            return np.zeros((6, 6))
        pose, lines = measurement.pose, measurement.lines
        by_size = size_derivatives(pose.T_world_target, sizes.mean, Trapezoid.edges_of, lines, self._cameras)
        D = np.tensordot(pose.gain, by_size, 2)
        part = D @ sizes.covariance @ D.T
        symmetric: FloatArray = 0.5 * (part + part.T)
        return symmetric

    def track(self, images: Images, expected: Expectation, learned: Learned, times: dict[str, float]) -> Attempt | None:
        """As `Surveyor.track`; None too where the size isn't known well enough for the images that there are."""
        if self.sizes is None or not self._enough(images):
            return None
        surveyor = self._surveyor(self.sizes.shape)
        attempt = surveyor.track(images, expected, learned, times)
        return None if attempt is None else self._taught(attempt)

    def acquire(
        self, images: Images, prediction: PredictedPose | None, learned: Learned, times: dict[str, float]
    ) -> Attempt:
        """As `Surveyor.acquire`, by the sizes learnt so far; or, as long as they are not known, by none."""
        if not self._enough(images):
            attempt = failed(look(self._blind, images, times), images)
            return attrs.evolve(attempt, reasons=attempt.reasons | {Reason.UNKNOWN_SIZE})
        if self.sizes is None:
            return self._first(images, learned, times)
        attempt = self._taught(self._surveyor(self.sizes.shape).acquire(images, prediction, learned, times))
        if attempt.passed or self.sizes.known:
            return attempt
        first = self._first(images, learned, times)
        return first if first.passed else attempt

    def _enough(self, images: Images) -> bool:
        """Whether there are images enough for what is known of the size."""
        both = len(images) > 1 and all(image is not None for image in images)
        return both or (self.sizes is not None and self.sizes.known)

    def _surveyor(self, shape: Trapezoid) -> Surveyor:
        key = shape.sizes.tobytes()
        if self._built is None or self._built[0] != key:
            target = self._target.resized(shape)
            self._known.set_target(target)
            self._built = (
                key,
                Surveyor(self._known, self._rig, edge_model(target).exact, self._knowledge, self._settings),
            )
        return self._built[1]

    def _taught(self, attempt: Attempt) -> Attempt:
        """With what it adds to the sizes, where it saw the target with both cameras and agrees with them."""
        sizes, measurement = self.sizes, attempt.measurement
        if sizes is None or measurement is None or not attempt.passed or len(measurement.cameras) < 2:
            return attempt
        frame = self._sizes_of(measurement, sizes.mean)
        if frame is None or not sizes.admits(frame):
            return attempt
        return attrs.evolve(attempt, sizes=sizes.combined(frame))

    def _sizes_of(self, measurement: Measurement, start: FloatArray) -> Sizes | None:
        """The sizes that a measurement's lines give by themselves; None where they give none."""
        T, lines = measurement.pose.T_world_target, measurement.lines
        try:
            fit = refine_shape(T, start, Trapezoid.edges_of, lines, self._cameras)
        except (PoseError, ZeroDivisionError):
            return None
        if not plausible(Trapezoid.of(fit.sizes)):
            return None
        pixel = float(np.linalg.norm(fit.T_world_target[:3, 3])) / self._cameras.focal
        return Sizes.of(fit.sizes, fit.covariance[6:, 6:], pixel)

    def _first(self, images: Images, learned: Learned, times: dict[str, float]) -> Attempt:
        """A bracket of any size sought in both images."""
        frame = look(self._blind, images, times)
        attempt = failed(frame, images)
        if attempt.reasons:
            return attempt
        views = see(self._blind, images, times)
        start = now()
        left, right = (
            find_bar_frames(self._segments(i, view.edgels)) for i, view in enumerate(views) if view is not None
        )
        config = self._blind.config
        gate = (config.range_min, config.range_max)
        candidates = bracket_candidates(left, right, self._cameras, self._rig.baseline, gate)
        lap(times, "bar frames", start)
        measured = [
            self._measured(candidate, images, learned, times) for candidate in candidates.brackets[:_MAX_MEASURED]
        ]
        passed = [attempt for attempt in measured if attempt is not None and attempt.passed]
        if not passed:
            reasons = {Reason.LIMIT} if frame.limits or candidates.cut else set()
            alike = any(attempt is not None and Reason.AMBIGUOUS in attempt.reasons for attempt in measured)
            reasons.add(Reason.AMBIGUOUS if alike or candidates.untold else Reason.NO_TARGET)
            return Attempt(frozenset(reasons), frame, images)
        if any(not _same(passed[0], other) for other in passed[1:]):
            return Attempt(frozenset({Reason.AMBIGUOUS}), frame, images)
        return passed[0]

    def _segments(self, camera: int, edgels: NDArray[np.void]) -> NDArray[np.void]:
        core = self._blind
        return core.extract_segments(camera, edgels, core.hough_peaks(core.hough_vote(edgels)))

    def _measured(
        self, candidate: BracketCandidate, images: Images, learned: Learned, times: dict[str, float]
    ) -> Attempt | None:
        """The candidate measured and resized until its sizes stay, then acquired by them as any known target is."""
        start = now()
        try:
            sizes = self._settled(candidate, images, learned)
        except PoseError:
            sizes = None
        lap(times, "pose", start)
        if sizes is None:
            return None
        attempt = self._surveyor(sizes.shape).acquire(images, None, learned, times)
        measurement = attempt.measurement
        if measurement is None or not _near(measurement.pose.T_world_target, candidate.T_world_target):
            return None
        if not _tapers(sizes):
            return attrs.evolve(attempt, reasons=attempt.reasons | {Reason.AMBIGUOUS})
        return attrs.evolve(attempt, sizes=sizes, anew=True)

    def _settled(self, candidate: BracketCandidate, images: Images, learned: Learned) -> Sizes | None:
        """The sizes that the grey values around a candidate give; None where they do not bear it out.

        Raises PoseError where the measured geometry determines no pose.
        """
        T, shape = candidate.T_world_target, candidate.shape
        unknown = np.zeros((len(images), len(EDGE_NAMES)), np.int64)
        for _ in range(_MAX_ROUNDS):
            model = edge_model(self._target.resized(shape)).exact
            measurement = measure(self._blind, self._rig, model, self._knowledge, learned, images, T, unknown)
            sizes = self._sizes_of(measurement, shape.sizes)
            if sizes is None or measurement.total_coverage < self._settings.min_coverage:
                return None
            sigmas = np.sqrt(np.diag(sizes.covariance))
            if sigmas.max() > _MAX_SIGMA_PART * shape.long_base:
                return None
            if (np.abs(sizes.mean - shape.sizes) < _SETTLED_SIGMAS * sigmas).all():
                return sizes
            T, shape = measurement.pose.T_world_target, sizes.shape
        return None


def _tapers(sizes: Sizes) -> bool:
    """Whether the long base is told from the short one: otherwise the bracket is the same turned by half a turn."""
    by_size = np.array([1.0, -1.0, 0.0, 0.0, 0.0, 0.0])
    taper, sigma = float(by_size @ sizes.mean), float(np.sqrt(by_size @ sizes.covariance @ by_size))
    return taper > max(_TAPER_SIGMAS * sigma, _LEAST_TAPER * float(sizes.mean[0]))


def _near(T: FloatArray, other: FloatArray) -> bool:
    error = difference(T, other)
    place = float(np.linalg.norm(error[:3])) < _SAME_PLACE * float(np.linalg.norm(T[:3, 3]))
    return place and float(np.linalg.norm(error[3:])) < _SAME_TURN


def _same(attempt: Attempt, other: Attempt) -> bool:
    """Whether two attempts that passed found the same bracket."""
    assert attempt.measurement is not None
    assert other.measurement is not None
    assert attempt.sizes is not None
    assert other.sizes is not None
    apart = float(np.abs(attempt.sizes.mean - other.sizes.mean).max())
    alike = apart < _SAME_SIZE * float(attempt.sizes.mean[0])
    return alike and _near(attempt.measurement.pose.T_world_target, other.measurement.pose.T_world_target)
