"""Puts the figures, tables and pictures of a run into one HTML page that needs no network."""

from __future__ import annotations

import string
from collections.abc import Mapping, Sequence
from html import escape
from importlib import resources
from pathlib import Path

import plotly.graph_objects as go
from plotly.offline import get_plotlyjs

from rvdnav.evaluation import Evaluation, TruePoses
from rvdnav.report.health import stage_figure, timeline_figure
from rvdnav.report.lost import lost_table
from rvdnav.report.motion import error_figure, pose_figure
from rvdnav.report.strip import Picture
from rvdnav.report.tables import dimension_table, headline_tiles, picture_caption, range_table
from rvdnav.solution import Solution
from rvdnav.summary import learned_dimensions


def write_report(
    path: Path,
    name: str,
    solutions: Sequence[Solution],
    *,
    truth: TruePoses | None,
    evaluation: Evaluation | None,
    pictures: Sequence[Picture] = (),
    black_boxes: Mapping[int, str] | None = None,
) -> None:
    """Write the report of a run over the sequence called ``name``; ``solutions`` holds at least one frame.

    black_boxes: timestamp, ns, of a frame that lost the target -> its black box's folder, relative to the page.
    Two runs of the same input give the same page apart from the wall times in it.
    """
    errors_title = "Errors and 3σ band" if evaluation is not None else "Uncertainty (3σ)"
    sections = [
        section("Position and attitude", figure_html(pose_figure(solutions, truth), "pose")),
        section(errors_title, figure_html(error_figure(solutions, evaluation), "errors")),
        section("State", figure_html(timeline_figure(solutions), "timeline")),
    ]
    lost = lost_table(solutions, black_boxes or {})
    if lost:
        sections.append(section("Target lost", lost))
    if evaluation is not None:
        sections.insert(0, section("Errors by range", range_table(evaluation)))
    dimensions = learned_dimensions(solutions)
    if dimensions is not None:
        sections.append(section("Dimensions learnt", dimension_table(dimensions)))
    if any(solution.stage_times for solution in solutions):
        sections.append(section("Time per stage", figure_html(stage_figure(solutions), "stages")))
    if pictures:
        sections.append(section("Frames", _strip(pictures, solutions)))
    write_page(path, name, _subtitle(solutions), headline_tiles(solutions, evaluation), sections)


def write_page(path: Path, title: str, subtitle: str, tiles: str, sections: Sequence[str]) -> None:
    """Write a report in the shared style; title and subtitle are plain text, tiles and sections HTML."""
    template = string.Template(resources.files("rvdnav.report").joinpath("page.html").read_text(encoding="utf-8"))
    page = template.substitute(
        title=escape(title),
        subtitle=escape(subtitle),
        tiles=tiles,
        plotly=get_plotlyjs(),
        sections="\n".join(sections),
    )
    path.write_text(page, encoding="utf-8")


def _subtitle(solutions: Sequence[Solution]) -> str:
    seconds = (solutions[-1].timestamp_ns - solutions[0].timestamp_ns) * 1e-9
    return f"{len(solutions)} frames over {seconds:.3f} s from {solutions[0].timestamp_ns} ns"


def section(title: str, body: str) -> str:
    """A card of the page: its heading, plain text, and its HTML."""
    return f"<section><h2>{escape(title)}</h2>\n{body}\n</section>"


def figure_html(figure: go.Figure, name: str) -> str:
    """A figure as HTML; its name is unique on the page."""
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
