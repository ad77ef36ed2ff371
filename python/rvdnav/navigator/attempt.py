"""What came of one way to measure a frame."""

from __future__ import annotations

import attrs

from rvdnav.core import FrameResult, ViewResult
from rvdnav.navigator.coarse import measured_segments
from rvdnav.navigator.measurement import Measurement
from rvdnav.navigator.sizes import Sizes
from rvdnav.navigator.views import Images
from rvdnav.pose.arrays import FloatArray
from rvdnav.solution import Acquisition, Reason

# An image with less than this is no picture of the target: mean grey level, share of saturated pixels, edge pixels.
_DARK_GREY = 1.0
_SATURATED = 0.5
_MIN_EDGE_PIXELS = 50
_UNUSABLE = (Reason.LEFT_UNUSABLE, Reason.RIGHT_UNUSABLE)


@attrs.frozen(eq=False)
class Attempt:
    """A frame's measurement, if there is one, and what speaks against it: it may be published only without reasons."""

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
    def coverage(self) -> float:
        """Part of all profiles across edges that agree with the measured pose; 0 without one."""
        return 0.0 if self.measurement is None else self.measurement.total_coverage

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
    def unusable_reasons(self) -> frozenset[Reason]:
        """The same as reasons."""
        return frozenset(_UNUSABLE[camera] for camera in self.unusable)

    @property
    def acquisition(self) -> Acquisition | None:
        """What the search of the whole images found; None if they were not searched."""
        found = self.frame.bracket
        return None if found is None else Acquisition(found.score, found.runner_up, found.hypotheses)


def failed(frame: FrameResult, images: Images, *reasons: Reason) -> Attempt:
    """An attempt that measured nothing: for unusable images if there are any, else for the given reasons."""
    attempt = Attempt(frozenset(reasons), frame, images)
    return attrs.evolve(attempt, reasons=attempt.unusable_reasons or attempt.reasons)


def _unusable(view: ViewResult | None) -> bool:
    return view is None or (
        view.mean_grey < _DARK_GREY or view.saturated > _SATURATED or view.edge_count < _MIN_EDGE_PIXELS
    )
