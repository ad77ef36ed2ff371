"""The table of the moments when the target was lost, as HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

from rvdnav.report.html import Html, table_html
from rvdnav.solution import Solution, State


def lost_table(solutions: Sequence[Solution], black_boxes: Mapping[int, str]) -> str:
    """When, how long after the last published pose, for which reasons, and a link to the black box.

    black_boxes: timestamp, ns, of a frame that lost the target -> its black box's folder, relative to the page.
    Empty where the target was never lost.
    """
    rows: list[list[str]] = []
    unpublished: list[Solution] = []
    last_pose_ns = start_ns = solutions[0].timestamp_ns
    for solution in solutions:
        if solution.published:
            last_pose_ns, unpublished = solution.timestamp_ns, []
            continue
        unpublished.append(solution)
        if solution.state is State.LOST:
            reasons = {reason.name for refused in unpublished for reason in refused.reasons}
            cells = [
                f"{(solution.timestamp_ns - start_ns) * 1e-9:.3f} s",
                f"{(solution.timestamp_ns - last_pose_ns) * 1e-9:.3f} s",
                str(len(unpublished)),
                ", ".join(sorted(reasons)) or "–",
                _link(black_boxes.get(solution.timestamp_ns)),
            ]
            rows.append(cells)
    if not rows:
        return ""
    headings = ("lost at", "since the last pose", "frames refused", "their reasons", "black box")
    return table_html(headings, rows)


def _link(folder: str | None) -> str:
    return "–" if folder is None else Html(f'<a href="{escape(folder)}/">{escape(folder)}</a>')
