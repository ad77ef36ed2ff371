"""The report of a campaign: one self-contained HTML page."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import plotly.graph_objects as go
import pyarrow as pa
import pyarrow.compute as pc
from plotly.subplots import make_subplots

from rvdnav.campaign.summary import CONFIDENCE, Group, Summary
from rvdnav.evaluation import PAPER_ATTITUDE_RAD, PAPER_POSITION_M
from rvdnav.pose.arrays import FloatArray
from rvdnav.report.html import figure_html, note_html, section, table_html
from rvdnav.report.page import write_page
from rvdnav.report.style import LIMIT, MEASURED, TRUE, styled

REPORT = "campaign.html"
_BAR_HEIGHT = 26
_MAX_POINTS = 20_000
"""More make a page slow; of more every so many-th is drawn."""


def write_campaign_report(path: Path, name: str, summary: Summary, rows: pa.Table) -> None:
    """Write the report of a campaign's summary and rows; the same input gives the same page."""
    overall = summary.overall
    sections = []
    if np.isfinite(overall.position_m).all():
        limits = note_html("Dotted: the paper's limits, 20 mm and 2°.")
        sections.append(section("Error against range", figure_html(_error_figure(rows), "errors") + limits))
        sections.append(section("By range", _table("range", summary.by_range)))
    sections.append(section("Availability", figure_html(_availability_figure(summary.by_fault), "availability")))
    sections.append(section("By fault", _table("fault", summary.by_fault)))
    sections.append(section("By source", _table("source", summary.by_source)))
    if summary.reasons:
        title = f"Why {overall.frames - overall.published} of {overall.frames} frames were not published"
        reasons = [(reason.name, str(count), reason.description) for reason, count in summary.reasons]
        sections.append(section(title, table_html(("reason", "frames", ""), reasons)))
    subtitle = f"{overall.trials} trials, {overall.frames} frames"
    write_page(path, name, subtitle, _tiles(summary), sections)


def _tiles(summary: Summary) -> list[tuple[str, str, str]]:
    overall = summary.overall
    tiles = [
        ("available", f"{100 * overall.availability:.1f} %", f"{overall.published} of {overall.frames} frames"),
        (
            "wrong poses",
            f"{overall.wrong} of {overall.judged}",
            f"of the published with a true pose; rate below {100 * overall.wrong_bound:.2g} % with "
            f"{100 * CONFIDENCE:.0f} % confidence, frames taken for independent",
        ),
        (
            "trials with a wrong pose",
            f"{overall.trials_wrong} of {overall.trials}",
            f"rate below {100 * summary.trials_wrong_bound:.2g} % with {100 * CONFIDENCE:.0f} % confidence",
        ),
    ]
    if np.isfinite(overall.position_m).all():
        median, most = (f"{1e3 * value:.3g}" for value in overall.position_m[:2])
        tiles.append(("position error", f"{median} mm", f"median; 95 %: {most} mm"))
        median, most = (f"{value:.3g}" for value in np.degrees(overall.attitude_rad[:2]))
        tiles.append(("attitude error", f"{median}°", f"median; 95 %: {most}°"))
        tiles.append(("mean NEES / 6", f"{overall.mean_nees_ratio:.2f}", "1 for honest covariances"))
    return tiles


def _error_figure(rows: pa.Table) -> go.Figure:
    judged = rows.filter(pc.is_valid(rows.column("position_error_m")))
    judged = judged.take(np.arange(0, len(judged), max(1, -(-len(judged) // _MAX_POINTS))))
    ranges = judged.column("range_m").to_numpy(zero_copy_only=False)
    struck = np.array(judged.column("fault").to_pylist()) != "none"
    figure = make_subplots(rows=1, cols=2, horizontal_spacing=0.09)
    kinds = (
        ("position_error_m", 1e3, "position error, mm", 1e3 * PAPER_POSITION_M),
        ("attitude_error_rad", float(np.degrees(1.0)), "attitude error, deg", float(np.degrees(PAPER_ATTITUDE_RAD))),
    )
    for column, (name, scale, title, paper) in enumerate(kinds, start=1):
        errors = scale * judged.column(name).to_numpy(zero_copy_only=False)
        for chosen, label, colour in ((~struck, "no fault", MEASURED), (struck, "with faults", TRUE)):
            figure.add_trace(
                go.Scattergl(
                    x=ranges[chosen],
                    y=errors[chosen],
                    mode="markers",
                    marker={"size": 4, "color": colour, "opacity": 0.55},
                    name=label,
                    legendgroup=label,
                    showlegend=column == 1 and bool(chosen.any()),
                    hovertemplate="%{x:.2f} m: %{y:.3f}",
                ),
                row=1,
                col=column,
            )
        figure.add_hline(y=paper, line={"color": LIMIT, "dash": "dot"}, row=1, col=column)
        figure.update_yaxes(type="log", dtick=1, title=title, row=1, col=column)
        figure.update_xaxes(title="true range, m", row=1, col=column)
    return styled(figure, 380)


def _availability_figure(groups: Sequence[Group]) -> go.Figure:
    shown = groups[::-1]
    figure = go.Figure(
        go.Bar(
            x=[100 * group.availability for group in shown],
            y=[group.name for group in shown],
            orientation="h",
            marker={"color": MEASURED},
            hovertemplate="%{y}: %{x:.1f} %",
        )
    )
    figure.update_xaxes(title="published frames, %", range=[0, 100])
    figure.update_yaxes(automargin=True)
    return styled(figure, 110 + _BAR_HEIGHT * len(shown))


def _table(what: str, groups: Sequence[Group]) -> str:
    headings = (what, "trials", "frames", "published", "position, mm", "attitude, °", "NEES / 6", "wrong", "rate below")
    return table_html(headings, map(_row, groups)) + note_html(
        "Errors: median / 95 % / largest of the published frames with a true pose. Wrong: more than "
        f"20 mm or 2° (1 + range / 1 m). Rate below: upper bound with {100 * CONFIDENCE:.0f} % confidence."
    )


def _row(group: Group) -> tuple[str, ...]:
    published = f"{100 * group.availability:.1f} %" if group.frames else "–"
    nees = f"{group.mean_nees_ratio:.2f}" if np.isfinite(group.mean_nees_ratio) else "–"
    bound = f"{100 * group.wrong_bound:.2g} %"
    return (
        group.name,
        str(group.trials),
        str(group.frames),
        published,
        _errors(1e3 * group.position_m),
        _errors(np.degrees(group.attitude_rad)),
        nees,
        f"{group.wrong} of {group.judged}",
        bound,
    )


def _errors(values: FloatArray) -> str:
    return " / ".join(f"{value:.3g}" for value in values) if np.isfinite(values).all() else "–"
