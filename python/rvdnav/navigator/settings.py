"""What the navigator demands of a measurement before it publishes it, and how it follows the target."""

from __future__ import annotations

import itertools
import math
import statistics
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np

_LEAST_STEP_M = 0.005
"""The target may move so far between two frames of a camera of a usual rate; at 1 m/s that is 200 frames/s."""


def _setting(default: float, low: float, high: float, unit: str, meaning: str) -> Any:
    """A field that checks its range, and tells it with its unit and meaning; of whole numbers if its default is one."""
    whole = isinstance(default, int)
    kinds = (int, np.integer) if whole else (int, float, np.integer, np.floating)

    def check(_settings: Any, field: attrs.Attribute[float], value: Any) -> None:
        if isinstance(value, bool) or not isinstance(value, kinds) or not low <= value <= high:
            kind = "a whole number" if whole else "a number"
            raise ValueError(f"{field.name} = {value!r} is not {kind} from {low:g} to {high:g}")

    metadata = {"unit": unit, "low": low, "high": high, "meaning": meaning}
    return attrs.field(default=default, validator=check, metadata=metadata)


@attrs.frozen(kw_only=True)
class NavigatorSettings:
    """Thresholds of the gates, search windows and the time a lost target is coasted.

    Raises ValueError for a value outside its range.
    """

    min_edges: int = _setting(5, 1, 1000, "", "Edges of the target that each view must show")
    min_bar_edges: int = _setting(
        2, 1, 4, "", "Of a bar's up to four edges on the images, over the views, those that must be shown"
    )
    acquired_bar_edges: int = _setting(
        3, 1, 4, "", "The same for a target found without a prediction, which nothing else vouches for"
    )
    edge_coverage: float = _setting(
        0.35, 0.01, 1.0, "", "Part of an edge's length that must agree with the pose for it to count as shown"
    )
    min_coverage: float = _setting(
        0.5, 0.01, 1.0, "", "Part of all edges' length, over the views, that must agree with the pose"
    )
    min_displaced_bars: int = _setting(
        2, 1, 8, "", "Bars, counted in each view, that look displaced by a bar's width: a pose is refused"
    )
    max_rms_px: float = _setting(0.4, 0.01, 100.0, "px", "Weighted RMS of the edge samples against the pose")
    max_rms_tolerances: float = _setting(
        1.5, 0.01, 100.0, "", "What the tolerance of the target's points adds to it, of its size in the image"
    )
    max_rms_blurs: float = _setting(
        0.15, 0.01, 100.0, "", "What defocus or motion adds to it, of the blur beyond a sharp image's"
    )
    max_disparity_px: float = _setting(
        1.5, 0.01, 100.0, "px", "Disparity that most of the correlated points must not be off by"
    )
    view_sigmas: float = _setting(
        3.0, 0.1, 1000.0, "sigma", "Largest distance between the poses that each view gives by itself"
    )
    max_position_sigma: float = _setting(
        0.006, 1e-6, 10.0, "m", "Largest standard deviation of the position along any direction"
    )
    max_attitude_sigma: float = _setting(
        math.radians(0.65), 1e-6, math.pi, "rad", "Of the attitude about any axis, times 1 + range / 1 m"
    )
    max_speed: float = _setting(
        1.0, 1e-3, 1000.0, "m/s", "Largest plausible speed of the target relative to the chaser"
    )
    max_turn_rate: float = _setting(math.radians(60.0), 1e-3, 100.0, "rad/s", "Largest plausible angular speed")
    motion_sigmas: float = _setting(
        6.0, 0.1, 1000.0, "sigma", "Distance from the prediction from which a motion is not plausible"
    )
    window_min_rho_px: float = _setting(2.5, 0.5, 100.0, "px", "Least half-width of a tracking window across its edge")
    window_min_theta: float = _setting(
        math.radians(2.0), 1e-3, math.pi / 4.0, "rad", "Least half-width of a tracking window in angle"
    )
    window_sigmas: float = _setting(
        3.0, 0.1, 100.0, "sigma", "Half-width of the windows in those of the prediction, beyond the least"
    )
    window_max_rho_px: float = _setting(
        14.0, 1.0, 1e5, "px", "Half-width from which windows say too little: the whole images are searched"
    )
    max_pixels: int = _setting(
        1_500_000, 10_000, 4096 * 4096, "px", "Larger images are reduced by area, by a power of two"
    )
    noisy_sigma: float = _setting(
        16.0, 0.1, 255.0, "grey levels", "White noise from which a target is sought in smoothed images first"
    )
    smoothing_px: float = _setting(
        1.0, 0.1, 10.0, "px", "Standard deviation of that smoothing; more is taken where there is more noise"
    )
    coast_seconds: float = _setting(
        2.0, 0.01, 3600.0, "s", "How long a target without a measurement is predicted before it is lost"
    )

    def reduction(self, width: int, height: int) -> int:
        """By which factor images of a size, px, are reduced."""
        factor = 1
        while (width // factor) * (height // factor) > self.max_pixels:
            factor *= 2
        return factor

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
