"""Headline numbers, tables and captions of the report of a run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rvdnav.evaluation import Evaluation, Quantiles, RangeRow
from rvdnav.report.html import note_html, table_html
from rvdnav.report.strip import Picture
from rvdnav.solution import LearnedDimensions, Solution
from rvdnav.summary import dimension_rows, median_frame_time, median_sigmas, unpublished_reasons


def headline_tiles(solutions: Sequence[Solution], evaluation: Evaluation | None) -> list[tuple[str, str, str]]:
    """The numbers at the top: published, errors (claimed 1 sigma without truth), speed."""
    published = sum(s.published for s in solutions)
    tiles = [("published", f"{100 * published / len(solutions):.1f} %", f"{published} of {len(solutions)} frames")]
    sigmas = median_sigmas(solutions)
    row = None if evaluation is None else evaluation.overall
    if evaluation is not None and row is not None and row.position_m is not None and row.attitude_rad is not None:
        position, attitude = row.position_m, row.attitude_rad
        note = f"95 % {position.p95 * 1e3:.2f}, max {position.max * 1e3:.2f} mm"
        tiles.append(("median position error", f"{position.median * 1e3:.2f} mm", note))
        note = f"95 % {np.degrees(attitude.p95):.2f}, max {np.degrees(attitude.max):.2f}°"
        tiles.append(("median attitude error", f"{np.degrees(attitude.median):.2f}°", note))
        note = f"NEES/6 {evaluation.mean_nees_ratio:.2f}; wrong: {int(evaluation.wrong.sum())}"
        tiles.append(("within 20 mm and 2°", f"{100 * evaluation.within_paper_limits:.1f} %", note))
    elif sigmas is not None:
        tiles.append(("median position σ", f"{sigmas[0] * 1e3:.2f} mm", "claimed, 1σ"))
        tiles.append(("median attitude σ", f"{np.degrees(sigmas[1]):.2f}°", "claimed, 1σ"))
    seconds = median_frame_time(solutions)
    if seconds:
        tiles.append(("speed", f"{1 / seconds:.1f} fps", f"{seconds * 1e3:.1f} ms a frame, median"))
    return tiles


def range_table(evaluation: Evaluation) -> str:
    """Median / 95 % / max of both errors for each range bin and all together."""
    groups = (("", 3), ("position error, mm", 3), ("attitude error, °", 3))
    headings = ("range", "frames", "published", *("median", "95 %", "max") * 2)
    rows = [_table_row(row) for row in (*(row for row in evaluation.rows if row.frames), evaluation.overall)]
    return table_html(headings, rows, groups=groups, total=True)


def _table_row(row: RangeRow) -> list[str]:
    cells = [row.name, str(row.frames), f"{100 * row.published / row.frames:.1f} %"]
    return cells + _quantile_cells(row.position_m, 1e3) + _quantile_cells(row.attitude_rad, float(np.degrees(1.0)))


def _quantile_cells(quantiles: Quantiles | None, scale: float) -> list[str]:
    if quantiles is None:
        return ["–"] * 3
    return [f"{value * scale:.3f}" for value in (quantiles.median, quantiles.p95, quantiles.max)]


def reason_table(solutions: Sequence[Solution]) -> str:
    """Why frames have no pose, with the number for each reason; empty where all have one."""
    reasons = unpublished_reasons(solutions)
    rows = [(reason.name, str(count), reason.description) for reason, count in reasons]
    return f'<div class="words">{table_html(("reason", "frames", ""), rows)}</div>' if rows else ""


def dimension_table(dimensions: LearnedDimensions) -> str:
    """The sizes that were learnt, with their standard deviations."""
    known = "enough to navigate with one camera" if dimensions.known else "not yet enough to navigate with one camera"
    note = note_html(f"As known at the end, from {dimensions.frames} frames: {known}.")
    return note + table_html(("dimension", "size, mm", "σ, mm"), dimension_rows(dimensions))


def picture_caption(picture: Picture, solution: Solution, start_ns: int) -> str:
    """Why it is shown, time, camera, state and range of a picture, and why it was not published."""
    parts = [picture.why] if picture.why else []
    parts += [f"{(picture.timestamp_ns - start_ns) * 1e-9:.3f} s", ("left", "right")[picture.camera]]
    parts.append(solution.state.name if solution.mode is None else f"{solution.state.name}, {solution.mode.name}")
    if solution.T_world_target is not None:
        parts.append(f"range {np.linalg.norm(solution.T_world_target[:3, 3]):.3f} m")
    else:
        parts += sorted(reason.name for reason in solution.reasons)
    return " · ".join(parts)
