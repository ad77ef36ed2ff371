"""Colours and layout that all figures of the report share.

The colours are mid-tones, legible on a light and on a dark page; the page's style sheet colours text and grid lines.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray

from rvdnav.pose.arrays import FloatArray
from rvdnav.solution import Solution, State

MEASURED = "#2f7fe0"
BAND = "rgba(47, 127, 224, 0.20)"
PREDICTED_BAND = "rgba(146, 112, 216, 0.22)"
TRUE = "#e08a2e"
PREDICTED = "#9270d8"
GOOD = "#23a172"
LIMIT = "#d94f4f"
GRID = "rgba(128, 134, 150, 0.28)"
STATE_COLOURS = {
    State.SEARCHING: "#d9a02b",
    State.TRACKING: GOOD,
    State.COASTING: PREDICTED,
    State.LOST: LIMIT,
}


def elapsed_s(solutions: Sequence[Solution], timestamps_ns: Sequence[int] | NDArray[np.int64]) -> FloatArray:
    """Seconds since the run's first frame; subtracted as integers, which a float64 of absolute time could not hold."""
    start = solutions[0].timestamp_ns
    return np.array([(int(ns) - start) * 1e-9 for ns in timestamps_ns])


def set_time_axes(figure: go.Figure, solutions: Sequence[Solution]) -> None:
    """The same time axis, with a margin, in every figure of the report."""
    end = float(elapsed_s(solutions, [solutions[-1].timestamp_ns])[0])
    margin = 0.03 * end or 1.0
    figure.update_xaxes(range=[-margin, end + margin])


def styled(figure: go.Figure, height: int) -> go.Figure:
    """The figure with the report's layout, ``height`` pixels high."""
    figure.update_layout(
        template=go.layout.Template(),
        height=height,
        margin={"l": 64, "r": 16, "t": 34, "b": 44},
        paper_bgcolor="rgba(0,0,0,0)",
        plot_bgcolor="rgba(0,0,0,0)",
        font={"family": "system-ui, sans-serif", "size": 12},
        legend={"orientation": "h", "x": 0, "y": 1.0, "yanchor": "bottom", "bgcolor": "rgba(0,0,0,0)"},
        hoverlabel={"bgcolor": "#1d2433", "bordercolor": "#1d2433", "font": {"color": "#f2f4f8"}},
        modebar={"bgcolor": "rgba(0,0,0,0)", "color": "#98a1b3", "activecolor": MEASURED},
        hovermode="closest",
    )
    figure.update_xaxes(gridcolor=GRID, linecolor=GRID, zeroline=False, ticks="")
    figure.update_yaxes(gridcolor=GRID, linecolor=GRID, zerolinecolor=GRID, ticks="")
    return figure
