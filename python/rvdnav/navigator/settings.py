"""What the navigator demands of a measurement before it publishes it, and how it follows the target."""

from __future__ import annotations

import itertools
import math
import statistics
from collections.abc import Sequence

import attrs

_LEAST_STEP_M = 0.005
"""The target may move so far between two frames of a camera of a usual rate; at 1 m/s that is 200 frames/s."""


@attrs.frozen(kw_only=True)
class NavigatorSettings:
    """Thresholds of the gates, search windows and the time a lost target is coasted.

    Raises ValueError for a value that is not positive.
    """

    min_edges: int = attrs.field(default=5)
    """Edges of the target that each view must show."""
    min_bar_edges: int = attrs.field(default=2)
    """Edges that each bar must show over the views together, of the up to four that lie on the images."""
    acquired_bar_edges: int = attrs.field(default=3)
    """The same for a target found without a prediction, which nothing else vouches for."""
    edge_coverage: float = 0.35
    """Part of an edge's length that must agree with the pose for it to count as shown."""
    min_coverage: float = 0.5
    """Part of all edges' length, over the views together, that must agree with the pose."""
    min_displaced_bars: int = attrs.field(default=2)
    """Bars, counted in each view, that look measured a bar's width beside themselves, from which a pose is refused."""
    max_rms_px: float = 0.4
    """Weighted RMS of the edge samples against the pose, pixels."""
    max_rms_tolerances: float = 1.5
    """What the tolerance of the target's points adds to that, as a part of its size in the image."""
    max_rms_blurs: float = 0.15
    """What an image out of focus or moved adds to that, as a part of the blur beyond a sharp image's."""
    max_disparity_px: float = 1.5
    """Disagreement with the pose, pixels, that most of the correlated points' disparities must not exceed."""
    view_sigmas: float = 3.0
    """Largest distance between the poses that each view gives by itself, in standard deviations of both."""
    max_position_sigma: float = 0.006
    """Largest standard deviation of the position along any direction, metres."""
    max_attitude_sigma: float = math.radians(0.65)
    """Largest standard deviation of the attitude about any axis, radians a metre of range beyond the first added."""
    max_speed: float = 1.0
    """Largest plausible speed of the target relative to the chaser, m/s."""
    max_turn_rate: float = math.radians(60.0)
    """Largest plausible angular speed, rad/s."""
    motion_sigmas: float = 6.0
    """Distance from the prediction, in standard deviations of both, from which a motion is not plausible."""
    window_min_rho_px: float = 2.5
    """Least half-width of a tracking window across its edge, pixels."""
    window_min_theta: float = math.radians(2.0)
    """Least half-width of a tracking window in angle, radians."""
    window_sigmas: float = 3.0
    """Half-width of the windows in standard deviations of the prediction, beyond the least."""
    window_max_rho_px: float = 14.0
    """From this half-width on a window says too little, and the frame is searched without a prior."""
    max_pixels: int = attrs.field(default=1_500_000)
    """Images with more pixels are reduced by area, by the least power of two that brings them to this."""
    noisy_sigma: float = 16.0
    """White noise, grey levels, from which a target is sought in smoothed images first."""
    smoothing_px: float = 1.0
    """Standard deviation of that smoothing, also where the images as they are show no target; more if there is more
    noise."""
    coast_seconds: float = 2.0
    """How long a target without a measurement is predicted before it is lost."""

    def reduction(self, width: int, height: int) -> int:
        """By which factor images of a size, px, are reduced."""
        factor = 1
        while (width // factor) * (height // factor) > self.max_pixels:
            factor *= 2
        return factor

    def __attrs_post_init__(self) -> None:
        for name, value in attrs.asdict(self).items():
            if not (math.isfinite(value) and value > 0):
                raise ValueError(f"{name} must be positive, not {value}")

    def rate_notice(self, timestamps_ns: Sequence[int]) -> str | None:
        """What a user should know of the rate of frames with these stamps, by the median; None for a usual one."""
        gaps = [after - before for before, after in itertools.pairwise(timestamps_ns)]
        seconds = statistics.median(gaps) * 1e-9 if gaps else None
        if seconds is None or (self.max_speed * seconds >= _LEAST_STEP_M and seconds <= self.coast_seconds):
            return None
        apart = f"the frames lie {seconds * 1e3:.3g} ms apart"
        if seconds > self.coast_seconds:
            return f"{apart}: a target is followed for {self.coast_seconds:g} s without one and then searched anew"
        step = f"{1e3 * self.max_speed * seconds:.3g} mm"
        return f"{apart}, in which the target may move {step} ({self.max_speed:g} m/s): are the stamps right?"
