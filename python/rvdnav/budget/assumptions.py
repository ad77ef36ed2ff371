"""What a budget assumes of the errors: all standard deviations."""

from __future__ import annotations

import math

import attrs


@attrs.frozen(kw_only=True)
class Assumptions:
    """Sizes of the errors that a budget starts from.  Raises ValueError for one that is negative or not finite."""

    noise: float = 1.5
    """Of a pixel, grey levels."""
    contrast: float = attrs.field(default=100.0, validator=attrs.validators.gt(0.0))
    """Step of an edge, grey levels."""
    blur: float = attrs.field(default=0.7, validator=attrs.validators.gt(0.0))
    """Of the image: standard deviation of the blur of an edge, px."""
    displacement: float = 0.02
    """Of a line as a whole, both its offset and its tilt (at the ends), px: lens remains, sampling, light."""
    side_part: float = 0.7
    """Of a side face's width in the image, where it is in sight: how far beside the front edge the step may stand."""
    dimensions: float = 5e-5
    """Of each coordinate of each corner of the target, m."""
    timing: float = 1e-4
    """Of the time between the two exposures, s."""
    speed: float = 0.1
    """Relative speed of the target, in any direction, m/s."""
    turn_rate: float = math.radians(1.0)
    """Relative turn rate of the target, about any axis, rad/s."""

    def __attrs_post_init__(self) -> None:
        for name, value in attrs.asdict(self).items():
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"{name} is not a number from 0 on")

    @property
    def profile_sigma(self) -> float:
        """Of the edge's place found in one profile, px.

        The bound that pixel noise sets to the place of a step blurred by a normal distribution, sampled once a pixel:
        the inverse root of the sum of the squared slopes, noise / contrast * sqrt(2 sqrt(pi) blur).
        """
        return self.noise / self.contrast * math.sqrt(2.0 * math.sqrt(math.pi) * self.blur)
