"""The report of a run: its figures, tables and pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from rvdnav.evaluation import Evaluation, TruePoses
from rvdnav.report.corrections import correction_figure, correction_table
from rvdnav.report.health import stage_figure, timeline_figure
from rvdnav.report.html import figure_html, section, strip_html
from rvdnav.report.lost import lost_table
from rvdnav.report.motion import error_figure, pose_figure
from rvdnav.report.page import write_page
from rvdnav.report.strip import Picture
from rvdnav.report.tables import dimension_table, headline_tiles, picture_caption, range_table
from rvdnav.solution import Solution
from rvdnav.summary import last_corrections, learned_dimensions


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
    corrections = last_corrections(solutions)
    if corrections is not None:
        figure = figure_html(correction_figure(corrections, solutions), "corrections")
        sections.append(section("Corrections learnt", figure + correction_table(corrections, solutions)))
    if any(solution.stage_times for solution in solutions):
        sections.append(section("Time per stage", figure_html(stage_figure(solutions), "stages")))
    if pictures:
        sections.append(section("Frames", _strip(pictures, solutions)))
    write_page(path, name, _subtitle(solutions), headline_tiles(solutions, evaluation), sections)


def _subtitle(solutions: Sequence[Solution]) -> str:
    seconds = (solutions[-1].timestamp_ns - solutions[0].timestamp_ns) * 1e-9
    return f"{len(solutions)} frames over {seconds:.3f} s from {solutions[0].timestamp_ns} ns"


def _strip(pictures: Sequence[Picture], solutions: Sequence[Solution]) -> str:
    by_time = {solution.timestamp_ns: solution for solution in solutions}
    start = solutions[0].timestamp_ns
    figures = [(p.uri, picture_caption(p, by_time[p.timestamp_ns], start)) for p in pictures]
    legend = (
        '<p class="legend"><span class="edge">edges</span> <span class="line">measured lines</span> '
        '<span class="target">target projected at the published pose</span></p>'
    )
    return legend + strip_html(figures)
