"""The report of a run: its figures, tables and pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from rvdnav.evaluation import Evaluation, TruePoses
from rvdnav.report.corrections import correction_figure, correction_table
from rvdnav.report.health import stage_figure, timeline_figure
from rvdnav.report.html import facts_html, figure_html, figures_html, section, strip_html
from rvdnav.report.lost import lost_table
from rvdnav.report.motion import ERROR_COLOURS, POSE_COLOURS, error_figures, pose_figures
from rvdnav.report.page import write_page
from rvdnav.report.strip import Picture
from rvdnav.report.tables import dimension_table, headline_tiles, picture_caption, range_table, reason_table
from rvdnav.report.verdict import run_verdict
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
    facts: Sequence[tuple[str, str]] = (),
) -> None:
    """Write the report of a run, called ``name``; ``solutions`` holds at least one frame.

    black_boxes: timestamp, ns, of a frame that lost the target -> its black box's folder, relative to the page.
    facts: what made it, as `provenance` gives it.
    Two runs of the same input give the same page apart from the wall times in it.
    """
    sections = []
    lost = lost_table(solutions, black_boxes or {})
    if lost:
        sections.append(section("Target lost", lost))
    reasons = reason_table(solutions)
    if reasons:
        sections.append(section("Why frames have no pose", reasons))
    if evaluation is not None:
        sections.append(section("Errors by range", range_table(evaluation)))
    errors_title = "Errors and 3σ band" if evaluation is not None else "Uncertainty (3σ)"
    sections += [
        section("State", figure_html(timeline_figure(solutions), "timeline")),
        section(errors_title, figures_html(error_figures(solutions, truth), "errors", ERROR_COLOURS)),
        section("Position and attitude", figures_html(pose_figures(solutions, truth), "pose", POSE_COLOURS)),
    ]
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
    if facts:
        sections.append(section("Made with", facts_html(facts)))
    write_page(
        path,
        name,
        _subtitle(solutions),
        headline_tiles(solutions, evaluation),
        sections,
        verdict=run_verdict(solutions, evaluation),
    )


def _subtitle(solutions: Sequence[Solution]) -> str:
    seconds = (solutions[-1].timestamp_ns - solutions[0].timestamp_ns) * 1e-9
    return f"{len(solutions)} frames over {seconds:.3f} s; times count from the first, {solutions[0].timestamp_ns} ns"


def _strip(pictures: Sequence[Picture], solutions: Sequence[Solution]) -> str:
    by_time = {solution.timestamp_ns: solution for solution in solutions}
    start = solutions[0].timestamp_ns
    figures = [(p.uri, picture_caption(p, by_time[p.timestamp_ns], start)) for p in pictures]
    legend = (
        '<p class="legend"><span class="edge">edges</span> <span class="line">measured lines</span> '
        '<span class="target">target projected at the published pose</span></p>'
    )
    return legend + strip_html(figures)
