"""Figures of the run itself: the state over time and where the wall time goes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from rvdnav.report.style import MEASURED, STATE_COLOURS, elapsed_s, set_time_axes, styled
from rvdnav.solution import Mode, Solution, State
from rvdnav.summary import stage_medians

_MODE_SYMBOLS = {Mode.STEREO: "square", Mode.MONO_LEFT: "triangle-left", Mode.MONO_RIGHT: "triangle-right"}


def timeline_figure(solutions: Sequence[Solution]) -> go.Figure:
    """State (row and colour) and mode (symbol) of every frame; the reasons appear on hovering."""
    figure = go.Figure()
    for state in State:
        for mode in (None, *Mode):
            chosen = [s for s in solutions if s.state is state and s.mode is mode]
            if not chosen:
                continue
            label = state.name if mode is None else f"{state.name}, {mode.name}"
            figure.add_scatter(
                x=elapsed_s(solutions, [s.timestamp_ns for s in chosen]),
                y=[state.name] * len(chosen),
                mode="markers",
                name=label,
                marker={
                    "color": STATE_COLOURS[state],
                    "size": 9,
                    "symbol": "square" if mode is None else _MODE_SYMBOLS[mode],
                },
                customdata=[_reason_text(s) for s in chosen],
                hovertemplate="%{x:.3f} s: " + label + "%{customdata}<extra></extra>",
            )
    figure.update_yaxes(categoryorder="array", categoryarray=[s.name for s in reversed(State)], range=[-0.6, 3.6])
    figure.update_xaxes(title_text="time since the first frame, s")
    set_time_axes(figure, solutions)
    styled(figure, 250)
    figure.update_layout(margin={"l": 96}, showlegend=True)
    return figure


def stage_figure(solutions: Sequence[Solution]) -> go.Figure:
    """Median wall time of each stage over the frames that ran it."""
    medians = stage_medians(solutions)
    figure = go.Figure(
        go.Bar(
            x=[seconds * 1e3 for seconds in medians.values()],
            y=list(medians),
            orientation="h",
            marker={"color": MEASURED},
            text=[f"{seconds * 1e3:.2f}" for seconds in medians.values()],
            textposition="outside",
            cliponaxis=False,
            hovertemplate="%{y}: %{x:.3f} ms<extra></extra>",
        )
    )
    longest = max(medians.values(), default=0.0) * 1e3
    figure.update_yaxes(autorange="reversed", ticksuffix="  ")
    figure.update_xaxes(
        title_text="median of the frames that ran the stage, ms",
        range=[0, 1.12 * longest if np.isfinite(longest) and longest else 1],
    )
    styled(figure, 110 + 26 * max(len(medians), 1))
    figure.update_layout(margin={"l": 120, "t": 10}, bargap=0.35)
    return figure


def _reason_text(solution: Solution) -> str:
    return "".join(f"<br>{name}" for name in sorted(reason.name for reason in solution.reasons))
