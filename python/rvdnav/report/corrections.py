"""What a run's frames say of a calibration and a target that are known to a tolerance only."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import plotly.graph_objects as go

from rvdnav.corrections import Corrections
from rvdnav.report.html import note_html, table_html
from rvdnav.report.style import BAND, MEASURED, PREDICTED, TRUE, elapsed_s, set_time_axes, styled
from rvdnav.solution import Solution
from rvdnav.summary import correction_rows, tolerance_alarms

_DRAWN = 3
_COLOURS = (MEASURED, TRUE, PREDICTED)


def correction_table(corrections: Corrections, solutions: Sequence[Solution]) -> str:
    """All corrections as known with the last published frame, and the alarms of the run."""
    note = (
        f"To be added to what the files say, as known with the last published frame; {corrections.frames} taught it. "
        f"All together the errors seem to be {corrections.calibration_scale:.2f} (calibration) and "
        f"{corrections.target_scale:.2f} times (target) as large as stated."
    )
    alarms = "".join(
        note_html(f"{reason.name} in {count} of {len(solutions)} frames: {reason.description}.")
        for reason, count in tolerance_alarms(solutions)
    )
    headings = ("", "correction", "1σ", "stated, 1σ")
    return alarms + note_html(note) + table_html(headings, correction_rows(corrections))


def correction_figure(corrections: Corrections, solutions: Sequence[Solution]) -> go.Figure:
    """The largest corrections over time, in stated standard deviations, with the band of one."""
    taught = [(s.timestamp_ns, s.corrections) for s in solutions if s.corrections is not None]
    time = elapsed_s(solutions, [timestamp_ns for timestamp_ns, _ in taught])
    curves: list[tuple[str, list[float]]] = []
    parameters = sorted(corrections.calibration, key=lambda name: -corrections.calibration[name].in_stated)
    for name in parameters[:_DRAWN]:
        own = [told.calibration[name] for _, told in taught]
        curves.append((name, [one.value / one.stated for one in own]))
    for name in sorted(corrections.points, key=lambda name: -corrections.points[name].in_stated)[:_DRAWN]:
        axis = int(np.argmax(np.abs(corrections.points[name].value)))
        at = [told.points[name] for _, told in taught]
        curves.append((f"{name}.{'xyz'[axis]}", [one.value[axis] / one.stated for one in at]))
    figure = go.Figure()
    for number, (name, values) in enumerate(curves):
        style = {
            "color": _COLOURS[number % _DRAWN],
            "width": 2,
            "dash": "solid" if name in corrections.calibration else "dot",
        }
        figure.add_scatter(x=time, y=values, name=name, mode="lines", line=style)
        figure.data[-1].update(hovertemplate="%{x:.3f} s: %{y:.2f}<extra>" + name + "</extra>")
    figure.add_hrect(y0=-1.0, y1=1.0, fillcolor=BAND, line_width=0, layer="below")
    figure.update_yaxes(title_text="correction, stated σ")
    figure.update_xaxes(title_text="time since the first frame, s")
    set_time_axes(figure, solutions)
    return styled(figure, 300)
