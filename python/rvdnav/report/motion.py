"""Figures over time: the pose, its errors and their 3-sigma band."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from rvdnav.evaluation import TruePoses, pose_error
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.euler import euler_from_rotation
from rvdnav.report.style import BAND, MEASURED, PREDICTED, PREDICTED_BAND, TRUE, elapsed_s, set_time_axes, styled
from rvdnav.solution import Solution

POSE_COLOURS = {"measured": MEASURED, "true": TRUE, "predicted (not published)": PREDICTED}
ERROR_COLOURS = {
    "measured − true": MEASURED,
    "± 3σ": BAND,
    "predicted − true": PREDICTED,
    "± 3σ, coasting": PREDICTED_BAND,
}

_POSE_TITLES = ("x_W, m", "φ, °", "y_W, m", "θ, °", "z_W, m", "ψ, °")
_ERROR_TITLES = ("δx_W, mm", "about x_W, °", "δy_W, mm", "about y_W, °", "δz_W, mm", "about z_W, °")
# Of position and attitude in turn: the order in which they stand in rows of two.
_COMPONENTS = (0, 3, 1, 4, 2, 5)
_TO_MM_AND_DEGREES = np.array([1e3] * 3 + [float(np.degrees(1.0))] * 3)


def pose_figures(solutions: Sequence[Solution], truth: TruePoses | None) -> list[tuple[str, go.Figure]]:
    """Position in W and attitude angles, each with its title: published, predicted while coasting, true where known."""
    time = elapsed_s(solutions, [s.timestamp_ns for s in solutions])
    true_poses = [] if truth is None else [truth.at(s.timestamp_ns) for s in solutions]
    coasted = [None if s.published else s.predicted_T_world_target for s in solutions]
    rows = {
        "true": _six_rows(true_poses),
        "predicted (not published)": _six_rows(coasted),
        "measured": _six_rows([s.T_world_target for s in solutions]),
    }
    figures = []
    for title, component in zip(_POSE_TITLES, _COMPONENTS, strict=True):
        figure = go.Figure()
        for name, values in rows.items():
            if len(values) and np.isfinite(values).any():
                _add(figure, time, values[:, component], name, POSE_COLOURS[name], line=name == "true")
        figures.append((title, _finished(figure, solutions)))
    return figures


def error_figures(solutions: Sequence[Solution], truth: TruePoses | None) -> list[tuple[str, go.Figure]]:
    """The components' 3-sigma bands, of poses and of predictions, and the errors in them where the truth is known."""
    time = elapsed_s(solutions, [s.timestamp_ns for s in solutions])
    bands = {"± 3σ": [s.covariance if s.published else None for s in solutions]}
    bands["± 3σ, coasting"] = [None if s.published else s.covariance for s in solutions]
    errors = {
        "predicted − true": [_error(s, truth) if not s.published else None for s in solutions],
        "measured − true": [_error(s, truth) if s.published else None for s in solutions],
    }
    figures = []
    for title, component in zip(_ERROR_TITLES, _COMPONENTS, strict=True):
        scale = _TO_MM_AND_DEGREES[component]
        figure = go.Figure()
        for name, covariances in bands.items():
            half = [np.nan if c is None else 3.0 * scale * np.sqrt(c[component, component]) for c in covariances]
            x, y = _band_outline(time, np.array(half))
            if x:
                colour = ERROR_COLOURS[name]
                line = {"color": colour, "width": 1}
                figure.add_scatter(
                    x=x, y=y, fill="toself", fillcolor=colour, line=line, mode="lines", name=name, hoverinfo="skip"
                )
        for name, rows in errors.items():
            values = np.array([np.nan if row is None else scale * row[component] for row in rows])
            if np.isfinite(values).any():
                _add(figure, time, values, name, ERROR_COLOURS[name])
        _show_published(figure, [t for t in figure.data if t.name in ("± 3σ", "measured − true")])
        figures.append((title, _finished(figure, solutions)))
    return figures


def _show_published(figure: go.Figure, traces: Sequence[go.Scatter]) -> None:
    """Scale the figure to what is published: what a prediction grows to would flatten it."""
    values = np.abs(np.array([y for trace in traces for y in trace.y if y is not None], dtype=float))
    if np.isfinite(values).any():
        largest = 1.15 * float(np.nanmax(values))
        figure.update_yaxes(range=[-largest, largest])


def _error(solution: Solution, truth: TruePoses | None) -> FloatArray | None:
    pose = solution.T_world_target if solution.published else solution.predicted_T_world_target
    true = None if truth is None else truth.at(solution.timestamp_ns)
    return None if pose is None or true is None else pose_error(pose, true)


def _six_rows(poses: Sequence[FloatArray | None]) -> FloatArray:
    """(n, 6) position in metres and angles in degrees; NaN where there is no pose."""
    rows = np.full((len(poses), 6), np.nan)
    for row, pose in zip(rows, poses, strict=True):
        if pose is not None:
            row[:3] = pose[:3, 3]
            row[3:] = np.degrees(euler_from_rotation(pose[:3, :3]))
    return rows


def _add(figure: go.Figure, time: FloatArray, values: FloatArray, name: str, colour: str, line: bool = False) -> None:
    style = {"line": {"color": colour, "width": 2}} if line else {"marker": {"color": colour, "size": 5}}
    hover = "%{x:.3f} s: %{y:.4f}<extra>" + name + "</extra>"
    figure.add_scatter(x=time, y=values, name=name, mode="lines" if line else "markers", hovertemplate=hover, **style)


def _finished(figure: go.Figure, solutions: Sequence[Solution]) -> go.Figure:
    set_time_axes(figure, solutions)
    styled(figure, 200)
    figure.update_xaxes(ticksuffix=" s")
    return figure.update_layout(margin={"l": 52, "r": 8, "t": 8, "b": 28}, showlegend=False)


def _band_outline(time: FloatArray, half: FloatArray) -> tuple[list[float | None], list[float | None]]:
    """Closed outlines of [-half, half] over each unbroken run of finite values, with gaps between them."""
    x: list[float | None] = []
    y: list[float | None] = []
    finite = np.flatnonzero(np.isfinite(half))
    for run in np.split(finite, np.flatnonzero(np.diff(finite) > 1) + 1):
        if run.size:
            x += [*time[run].tolist(), *time[run[::-1]].tolist(), None]
            y += [*half[run].tolist(), *(-half[run[::-1]]).tolist(), None]
    return x, y
