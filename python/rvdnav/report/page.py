"""Puts the figures, tables and pictures of a run into one HTML page that needs no network."""

from __future__ import annotations

import string
from collections.abc import Sequence
from html import escape
from importlib import resources
from pathlib import Path

import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from rvdnav.evaluation import Evaluation, TruePoses
from rvdnav.report.health import stage_figure, timeline_figure
from rvdnav.report.motion import error_figure, pose_figure
from rvdnav.report.strip import Picture
from rvdnav.report.tables import headline_tiles, picture_caption, range_table
from rvdnav.solution import Solution


def write_report(
    path: Path,
    name: str,
    solutions: Sequence[Solution],
    *,
    truth: TruePoses | None,
    evaluation: Evaluation | None,
    pictures: Sequence[Picture] = (),
) -> None:
    """Write the report of a run over the sequence called ``name``; ``solutions`` holds at least one frame.

    Two runs of the same input give the same page apart from the wall times in it.
    """
    errors_title = "Errors and 3σ band" if evaluation is not None else "Uncertainty (3σ)"
    sections = [
        _section("Position and attitude", _figure(pose_figure(solutions, truth), "pose")),
        _section(errors_title, _figure(error_figure(solutions, evaluation), "errors")),
        _section("State", _figure(timeline_figure(solutions), "timeline")),
    ]
    if evaluation is not None:
        sections.insert(0, _section("Errors by range", range_table(evaluation)))
    if any(solution.stage_times for solution in solutions):
        sections.append(_section("Time per stage", _figure(stage_figure(solutions), "stages")))
    if pictures:
        sections.append(_section("Frames", _strip(pictures, solutions)))
    template = string.Template(resources.files("rvdnav.report").joinpath("page.html").read_text(encoding="utf-8"))
    page = template.substitute(
        title=escape(name),
        subtitle=escape(_subtitle(solutions)),
        tiles=headline_tiles(solutions, evaluation),
        plotly=get_plotlyjs(),
        sections="\n".join(sections),
    )
    path.write_text(page, encoding="utf-8")


def _subtitle(solutions: Sequence[Solution]) -> str:
    seconds = (solutions[-1].timestamp_ns - solutions[0].timestamp_ns) * 1e-9
    return f"{len(solutions)} frames over {seconds:.3f} s from {solutions[0].timestamp_ns} ns"


def _section(title: str, body: str) -> str:
    return f"<section><h2>{escape(title)}</h2>\n{body}\n</section>"


def _figure(figure: go.Figure, name: str) -> str:
    buttons = [["toImage", "zoom2d", "pan2d", "resetScale2d"]]
    config = {"displaylogo": False, "responsive": True, "modeBarButtons": buttons}
    text: str = figure.to_html(full_html=False, include_plotlyjs=False, div_id=f"figure-{name}", config=config)
    return text


def _strip(pictures: Sequence[Picture], solutions: Sequence[Solution]) -> str:
    by_time = {solution.timestamp_ns: solution for solution in solutions}
    start = solutions[0].timestamp_ns
    figures = [
        f"<figure onclick=\"this.classList.toggle('wide')\">"
        f'<img src="{picture.data_uri}" alt="frame at {picture.timestamp_ns} ns" loading="lazy">'
        f"<figcaption>{picture_caption(picture, by_time[picture.timestamp_ns], start)}</figcaption></figure>"
        for picture in pictures
    ]
    legend = (
        '<p class="legend"><span class="edge">edges</span> <span class="line">measured lines</span> '
        '<span class="target">target projected at the published pose</span></p>'
    )
    return f'{legend}<div class="strip">{"".join(figures)}</div>'
