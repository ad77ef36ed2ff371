"""Figures over time: the pose, its errors and their 3-sigma band."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from rvdnav.evaluation import Evaluation, TruePoses
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.euler import euler_from_rotation
from rvdnav.report.style import BAND, MEASURED, PREDICTED, TRUE, elapsed_s, set_time_axes, styled
from rvdnav.solution import Solution

_TIME_TITLE = "time since the first frame, s"


def pose_figure(solutions: Sequence[Solution], truth: TruePoses | None) -> go.Figure:
    """Position in W and attitude angles: published, predicted while coasting, and true where known."""
    figure = _grid(("x<sub>W</sub>, m", "y<sub>W</sub>, m", "z<sub>W</sub>, m"), ("φ, °", "θ, °", "ψ, °"))
    time = elapsed_s(solutions, [s.timestamp_ns for s in solutions])
    if truth is not None:
        true_poses = [truth.at(s.timestamp_ns) for s in solutions]
        _add_six(figure, time, _six_rows(true_poses), "true", mode="lines", line={"color": TRUE, "width": 2})
    coasted = [None if s.published else s.predicted_T_world_target for s in solutions]
    if any(pose is not None for pose in coasted):
        marker = {"color": PREDICTED, "size": 6, "symbol": "circle-open"}
        _add_six(figure, time, _six_rows(coasted), "predicted (not published)", mode="markers", marker=marker)
    measured = [s.T_world_target for s in solutions]
    _add_six(figure, time, _six_rows(measured), "measured", mode="markers", marker={"color": MEASURED, "size": 5})
    set_time_axes(figure, solutions)
    return styled(figure, 640)


def error_figure(solutions: Sequence[Solution], evaluation: Evaluation | None) -> go.Figure:
    """The six components' 3-sigma band, and the errors in it where the truth is known."""
    figure = _grid(
        ("δx<sub>W</sub>, mm", "δy<sub>W</sub>, mm", "δz<sub>W</sub>, mm"),
        ("about x<sub>W</sub>, °", "about y<sub>W</sub>, °", "about z<sub>W</sub>, °"),
    )
    scale = np.array([1e3] * 3 + [float(np.degrees(1.0))] * 3)
    time = elapsed_s(solutions, [s.timestamp_ns for s in solutions])
    bands = np.full((len(solutions), 6), np.nan)
    for row, solution in zip(bands, solutions, strict=True):
        if solution.published and solution.covariance is not None:
            row[:] = 3.0 * np.sqrt(np.diag(solution.covariance))
    for component in range(6):
        x, y = _band_outline(time, bands[:, component] * scale[component])
        band = go.Scatter(x=x, y=y, fill="toself", fillcolor=BAND, line={"color": BAND, "width": 1}, mode="lines")
        band.update(name="± 3σ", legendgroup="band", showlegend=component == 0, hoverinfo="skip")
        figure.add_trace(band, row=component % 3 + 1, col=component // 3 + 1)
    if evaluation is not None:
        errors = evaluation.components * scale
        error_time = elapsed_s(solutions, evaluation.timestamps_ns)
        marker = {"color": MEASURED, "size": 5}
        _add_six(figure, error_time, errors, "measured − true", mode="markers", marker=marker)
    set_time_axes(figure, solutions)
    return styled(figure, 640)


def _grid(left: Sequence[str], right: Sequence[str]) -> go.Figure:
    figure = make_subplots(rows=3, cols=2, shared_xaxes=True, vertical_spacing=0.045, horizontal_spacing=0.1)
    for row, (first, second) in enumerate(zip(left, right, strict=True), start=1):
        figure.update_yaxes(title_text=first, row=row, col=1)
        figure.update_yaxes(title_text=second, row=row, col=2)
    figure.update_xaxes(title_text=_TIME_TITLE, row=3)
    return figure


def _six_rows(poses: Sequence[FloatArray | None]) -> FloatArray:
    """(n, 6) position in metres and angles in degrees; NaN where there is no pose."""
    rows = np.full((len(poses), 6), np.nan)
    for row, pose in zip(rows, poses, strict=True):
        if pose is not None:
            row[:3] = pose[:3, 3]
            row[3:] = np.degrees(euler_from_rotation(pose[:3, :3]))
    return rows


def _add_six(figure: go.Figure, time: FloatArray, rows: FloatArray, name: str, **style: object) -> None:
    for component in range(6):
        trace = go.Scatter(x=time, y=rows[:, component], name=name, legendgroup=name, showlegend=component == 0)
        trace.update(hovertemplate="%{x:.3f} s: %{y:.4f}<extra>" + name + "</extra>", **style)
        figure.add_trace(trace, row=component % 3 + 1, col=component // 3 + 1)


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
