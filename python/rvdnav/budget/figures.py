"""The figures of a budget's page."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from rvdnav.budget.causes import CAUSES
from rvdnav.budget.sweep import Cell, Sigma, Sweep
from rvdnav.report.style import MEASURED, TRUE, styled

_COLOURS = ("#23a172", "#2f7fe0", "#9270d8", "#c2588f", "#d9a02b", "#7f8797")
_SCALES = (1e3, float(np.degrees(1.0)))
_UNITS = ("mm", "°")
_TITLES = ("position σ, mm", "attitude σ, °")
_HEAT = [[0.0, "#dce9fb"], [1.0, "#3f86dd"]]


def both(sigma: Sigma) -> tuple[float, float]:
    """As shown: position in mm and attitude in degrees."""
    return sigma.position * _SCALES[0], sigma.attitude * _SCALES[1]


def range_figure(result: Sweep) -> go.Figure:
    """Every cause over the range, head-on, on logarithmic scales."""
    figure = _pair()
    cells = [found for found in result.head_on if found is not None]
    distances = [found.distance for found in cells]
    for name, colour in zip(CAUSES, _COLOURS, strict=True):
        values = [both(found.causes[name]) for found in cells]
        _add_pair(figure, distances, values, name, {"color": colour, "width": 2})
    _add_pair(figure, distances, [both(found.total) for found in cells], "total", {"color": TRUE, "width": 4})
    figure.update_xaxes(title_text="range, m", type="log", tickvals=distances, ticktext=[f"{d:g}" for d in distances])
    for column, title in enumerate(_TITLES, start=1):
        # Three decades below the largest: what lies lower plays no part.
        largest = max(both(found.total)[column - 1] for found in cells)
        bounds = [np.log10(largest) - 3.0, np.log10(largest) + 0.15]
        figure.update_yaxes(title_text=title, type="log", range=bounds, dtick=1, row=1, col=column)
    return styled(figure, 420)


def angle_figure(result: Sweep) -> go.Figure:
    """The total over range and viewing angle."""
    figure = _pair()
    angles = [f"{np.degrees(angle):g}°" for angle in result.angles]
    ranges = [f"{distance:g}" for distance in result.ranges]
    for column in range(2):
        values = [[np.nan if c is None else both(c.total)[column] for c in row] for row in result.cells]
        texts = [["–" if np.isnan(value) else number(value) for value in row] for row in values]
        heat = go.Heatmap(x=angles, y=ranges, z=np.log10(values), text=texts, texttemplate="%{text}")
        heat.update(colorscale=_HEAT, showscale=False, xgap=2, ygap=2, textfont={"size": 12}, hoverinfo="skip")
        figure.add_trace(heat, row=1, col=column + 1)
    figure.update_yaxes(title_text="range, m", type="category")
    for column, title in enumerate(_TITLES, start=1):
        figure.update_xaxes(title_text=f"{title}, by viewing angle", type="category", row=1, col=column)
    return styled(figure, 120 + 44 * len(ranges))


def calibration_figure(found: Cell) -> go.Figure:
    """What each of the calibration's parameters does by itself."""
    figure = _pair()
    names = list(found.parameters)
    for column in range(2):
        values = [both(sigma)[column] for sigma in found.parameters.values()]
        bar = go.Bar(x=names, y=values, marker={"color": MEASURED}, name="by itself", showlegend=False)
        bar.update(hovertemplate="%{x}: %{y:.3g} " + _UNITS[column] + "<extra></extra>")
        figure.add_trace(bar, row=1, col=column + 1)
        figure.add_hline(
            y=both(found.causes["calibration"])[column],
            line={"color": TRUE, "width": 2, "dash": "dash"},
            annotation={"text": "all together", "font": {"color": TRUE}},
            row=1,
            col=column + 1,
        )
        figure.update_yaxes(title_text=_TITLES[column], row=1, col=column + 1)
    figure.update_xaxes(tickangle=-60)
    return styled(figure, 460).update_layout(margin={"b": 100})


def number(value: float) -> str:
    """Three significant digits, but no more than three decimals."""
    if value >= 100.0:
        return f"{value:.0f}"
    if value >= 10.0:
        return f"{value:.1f}"
    return f"{value:.2f}" if value >= 1.0 else f"{value:.3f}"


def _pair() -> go.Figure:
    return make_subplots(rows=1, cols=2, horizontal_spacing=0.09)


def _add_pair(
    figure: go.Figure,
    distances: Sequence[float],
    values: Sequence[tuple[float, float]],
    name: str,
    line: dict[str, object],
) -> None:
    for column in range(2):
        y = [pair[column] for pair in values]
        trace = go.Scatter(x=distances, y=y, name=name, legendgroup=name, showlegend=column == 0)
        trace.update(mode="lines+markers", line=line)
        trace.update(hovertemplate="%{x:g} m: %{y:.3g} " + _UNITS[column] + "<extra>" + name + "</extra>")
        figure.add_trace(trace, row=1, col=column + 1)
