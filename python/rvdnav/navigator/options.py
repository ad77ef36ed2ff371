"""What a navigator may be told by name: its own settings and the core's."""

from __future__ import annotations

from typing import Any, cast

import attrs

from rvdnav.core.options import CoreOptions
from rvdnav.navigator.settings import NavigatorSettings


class NavigatorOptions(CoreOptions, total=False):
    """Fields of `NavigatorSettings`, and of the core's `CoreOptions`; the default is taken for what isn't given."""

    min_edges: int
    min_bar_edges: int
    acquired_bar_edges: int
    edge_coverage: float
    min_coverage: float
    min_displaced_bars: int
    max_rms_px: float
    max_rms_tolerances: float
    max_rms_blurs: float
    max_disparity_px: float
    view_sigmas: float
    max_position_sigma: float
    max_attitude_sigma: float
    max_speed: float
    max_turn_rate: float
    motion_sigmas: float
    window_min_rho_px: float
    window_min_theta: float
    window_sigmas: float
    window_max_rho_px: float
    max_pixels: int
    noisy_sigma: float
    smoothing_px: float
    coast_seconds: float


def split_options(options: NavigatorOptions) -> tuple[NavigatorSettings, CoreOptions]:
    """The navigator's settings, and what is left for the core.  Raises ValueError for a value out of its range."""
    own = {field.name for field in attrs.fields(NavigatorSettings)}
    values: dict[str, Any] = dict(options)
    settings = NavigatorSettings(**{name: value for name, value in values.items() if name in own})
    return settings, cast("CoreOptions", {name: value for name, value in values.items() if name not in own})
