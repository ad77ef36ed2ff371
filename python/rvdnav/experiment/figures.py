"""Figures of the experiment: counterparts of the paper's figures 12 to 14, and the comparison of its section 3.1."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import plotly.graph_objects as go
from plotly.subplots import make_subplots

from rvdnav.evaluation import PAPER_ATTITUDE_RAD, PAPER_POSITION_M
from rvdnav.experiment.chart import CONTRASTS, LEVELS
from rvdnav.experiment.sobel import EdgeTrial
from rvdnav.report.style import GOOD, LIMIT, MEASURED, PREDICTED, TRUE, elapsed_s, styled

if TYPE_CHECKING:
    from rvdnav.experiment.paper import Run

_COLOURS = (MEASURED, GOOD, PREDICTED)


def axis_figure(run: Run, axis: int) -> go.Figure:
    """One coordinate of the target in W over time, measured and true, m; axis 0 x to 2 z."""
    solutions, truth = run.solutions, run.sequence.truth
    time = elapsed_s(solutions, [s.timestamp_ns for s in solutions])
    true = [None if truth is None else truth.at(s.timestamp_ns) for s in solutions]
    figure = go.Figure(
        [
            go.Scatter(
                x=time,
                y=[None if T is None else T[axis, 3] for T in true],
                name="true",
                mode="lines",
                line={"color": TRUE, "width": 2},
            ),
            go.Scatter(
                x=time,
                y=[None if s.T_world_target is None else s.T_world_target[axis, 3] for s in solutions],
                name="measured",
                mode="markers",
                marker={"color": MEASURED, "size": 6},
            ),
        ]
    )
    figure.update_yaxes(title=f"{'xyz'[axis]}<sub>W</sub>, m")
    figure.update_xaxes(title="time since the first frame, s")
    return styled(figure, 320)


def errors_figure(run: Run) -> go.Figure:
    """The errors' components against the range, with the paper's limits beside them."""
    evaluation = run.evaluation
    figure = make_subplots(rows=1, cols=2, horizontal_spacing=0.09)
    kinds = (
        ("position error, mm", 1e3 * evaluation.components[:, :3], "xyz", 1e3 * PAPER_POSITION_M),
        (
            "attitude error, °",
            np.degrees(evaluation.components[:, 3:]),
            ("about x", "about y", "about z"),
            float(np.degrees(PAPER_ATTITUDE_RAD)),
        ),
    )
    for column, (title, errors, names, limit) in enumerate(kinds, start=1):
        for component, colour in enumerate(_COLOURS):
            figure.add_trace(
                go.Scatter(
                    x=evaluation.ranges_m,
                    y=errors[:, component],
                    name=names[component],
                    mode="markers",
                    marker={"color": colour, "size": 5},
                ),
                row=1,
                col=column,
            )
        for sign in (1.0, -1.0):
            figure.add_hline(y=sign * limit, line={"color": LIMIT, "dash": "dot"}, row=1, col=column)
        figure.update_yaxes(title=title, range=[-1.15 * limit, 1.15 * limit], row=1, col=column)
        figure.update_xaxes(title="true range, m", row=1, col=column)
    return styled(figure, 380)


def sobel_figure(trials: Sequence[EdgeTrial]) -> go.Figure:
    """True edges shown against noise edges: the plain operator over its thresholds, the adaptive one as a point."""
    figure = go.Figure()
    for trial, colour in zip(trials, _COLOURS, strict=True):
        noise, detail = np.array([(q.noise, q.detail) for q in trial.plain]).T
        figure.add_trace(
            go.Scatter(
                x=1e4 * np.maximum(noise, 1e-6),
                y=100.0 * detail,
                name=f"plain, noise × {trial.noise:g}",
                mode="lines",
                line={"color": colour, "width": 2},
            )
        )
        figure.add_trace(
            go.Scatter(
                x=[1e4 * max(trial.adaptive.noise, 1e-6)],
                y=[100.0 * trial.adaptive.detail],
                name=f"adaptive, noise × {trial.noise:g}",
                mode="markers",
                marker={"color": colour, "size": 13, "symbol": "star"},
            )
        )
    figure.update_xaxes(title="noise edges in 10 000 px without an edge (0.01: fewer or none)", type="log", dtick=1)
    figure.update_yaxes(title="true edges shown, %", range=[0, 103])
    return styled(figure, 420)


def detail_figure(trial: EdgeTrial) -> go.Figure:
    """The part of the edges shown by the ground's level, one panel a contrast, at equal noise."""
    figure = make_subplots(
        rows=1,
        cols=len(CONTRASTS),
        shared_yaxes=True,
        horizontal_spacing=0.03,
        subplot_titles=[f"contrast {100 * contrast:.0f} %" for contrast in CONTRASTS],
    )
    for column in range(len(CONTRASTS)):
        for row, (name, colour) in enumerate((("adaptive", MEASURED), ("plain", TRUE))):
            figure.add_trace(
                go.Bar(
                    x=[f"{level:.0f}" for level in LEVELS],
                    y=100.0 * trial.detail[row][:, column],
                    name=name,
                    legendgroup=name,
                    showlegend=column == 0,
                    marker={"color": colour},
                ),
                row=1,
                col=column + 1,
            )
    figure.update_xaxes(title="ground, grey level", type="category")
    figure.update_yaxes(title="edges shown, %", range=[0, 103], col=1)
    styled(figure, 340)
    figure.update_layout(margin={"t": 64}, legend={"y": 1.12})
    return figure
