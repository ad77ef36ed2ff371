"""Tables on the terminal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from rich.table import Table

from rvdnav.cli.terminal import console
from rvdnav.evaluation import Evaluation, Quantiles, RangeRow
from rvdnav.faults import Fault, Response
from rvdnav.reconstruction import UNMATCHED, Cloud
from rvdnav.solution import LearnedDimensions, Reason, Solution, State
from rvdnav.summary import (
    correction_text,
    dimension_rows,
    last_corrections,
    learned_dimensions,
    median_frame_time,
    median_sigmas,
    tolerance_alarms,
    unpublished_reasons,
    worked_on,
)
from rvdnav.target import Target


def print_summary(solutions: Sequence[Solution], evaluation: Evaluation | None, target: Target) -> None:
    """What a run gave, in one two-column table, and why frames were not published."""
    published = sum(s.published for s in solutions)
    states = Counter(s.state for s in solutions)
    table = Table(show_header=False, title="Run", title_justify="left")
    table.add_column(style="bold")
    table.add_column(justify="right")
    table.add_row("frames", str(len(solutions)))
    table.add_row("published", f"{published} ({_percent(published, len(solutions))})")
    for state in State:
        if states[state]:
            table.add_row(state.name, str(states[state]))
    if target.dimensions_known:
        table.add_row("size of the target", size_text(target))
    sigmas = median_sigmas(solutions)
    if sigmas is not None:
        table.add_row("median sigma position", f"{sigmas[0] * 1e3:.3f} mm")
        table.add_row("median sigma attitude", f"{np.degrees(sigmas[1]):.3f} deg")
    if evaluation is not None and evaluation.overall.position_m and evaluation.overall.attitude_rad:
        position, attitude = evaluation.overall.position_m, evaluation.overall.attitude_rad
        if evaluation.frames < len(solutions):
            table.add_row("frames with a true pose", f"{evaluation.frames} of {len(solutions)}")
        table.add_row("position error, median / 95 %", f"{position.median * 1e3:.3f} / {position.p95 * 1e3:.3f} mm")
        degrees = np.degrees([attitude.median, attitude.p95])
        table.add_row("attitude error, median / 95 %", f"{degrees[0]:.3f} / {degrees[1]:.3f} deg")
    seconds = median_frame_time(solutions)
    if seconds:
        table.add_row("median time per frame", f"{seconds * 1e3:.1f} ms ({1 / seconds:.1f} frames/s)")
        timed = sum(worked_on(s) for s in solutions)
        if timed < len(solutions):
            table.add_row("", f"of {timed} frames with an image to work on")
    console.print(table)
    unpublished = len(solutions) - published
    print_reasons(f"Why {unpublished} of {len(solutions)} frames were not published", unpublished_reasons(solutions))
    if not published and target.dimensions_known and Reason.NO_TARGET in dict(unpublished_reasons(solutions)):
        console.print(
            f"nothing of the size of {target.name}, {size_text(target)}, was seen: is the unit in target.yaml right?",
            soft_wrap=True,
        )
    dimensions = learned_dimensions(solutions)
    if dimensions is not None:
        _print_dimensions(dimensions)
    corrections = last_corrections(solutions)
    if corrections is not None:
        console.print(correction_text(corrections), soft_wrap=True)
    for reason, count in tolerance_alarms(solutions):
        console.print(f"{reason.name} in {count} of {len(solutions)} frames: {reason.description}", soft_wrap=True)


def print_reasons(title: str, reasons: Sequence[tuple[Reason, int]]) -> None:
    """Why frames were not counted, with the number for each reason; nothing where there is none."""
    if not reasons:
        return
    table = Table(title=title, title_justify="left")
    table.add_column("reason")
    table.add_column("frames", justify="right")
    table.add_column("")
    for reason, count in reasons:
        table.add_row(reason.name, str(count), reason.description)
    console.print(table)


def size_text(target: Target) -> str:
    """Extent of a target's points along its axes, such as 0 x 180 x 140 mm; in metres where they are many."""
    extent = np.ptp(np.array(list(target.points.values())), axis=0)
    scale, unit = (1.0, "m") if extent.max() >= 10.0 else (1e3, "mm")
    return " x ".join(f"{scale * length:.4g}" for length in extent if length > 0.0) + f" {unit}"


def _print_dimensions(dimensions: LearnedDimensions) -> None:
    """The size of a target of unknown dimensions, as learnt in the end."""
    table = Table(title=f"Dimensions learnt from {dimensions.frames} frames", title_justify="left")
    table.add_column("dimension")
    table.add_column("mm", justify="right")
    table.add_column("sigma, mm", justify="right")
    for row in dimension_rows(dimensions):
        table.add_row(*row)
    console.print(table)
    if not dimensions.known:
        console.print("not yet known well enough to navigate with one camera")


def print_cloud(cloud: Cloud) -> None:
    """What a reconstruction gave."""
    table = Table(show_header=False, title="Surface", title_justify="left")
    table.add_column(style="bold")
    table.add_column(justify="right")
    table.add_row("points", f"{len(cloud)} of {cloud.crossings} zero crossings in the left image")
    if len(cloud):
        near, middle, far = np.percentile(cloud.depth, [5, 50, 95])
        table.add_row("depth, 5 / 50 / 95 %", f"{near:.3f} / {middle:.3f} / {far:.3f} m")
        half, most = np.percentile(cloud.sigma * 1e3, [50, 95])
        table.add_row("sigma, median / 95 %", f"{half:.2f} / {most:.2f} mm")
    console.print(table)
    if len(cloud) < cloud.crossings:
        console.print(UNMATCHED, soft_wrap=True)


def print_responses(responses: Sequence[tuple[Fault, Response]], evaluation: Evaluation | None) -> None:
    """What became of the injected faults, a row each."""
    table = Table(title="Faults", title_justify="left")
    table.add_column("fault")
    for heading in ("struck frames", "refused", "alarm after", "published wrong"):
        table.add_column(heading, justify="right")
    for fault, response in responses:
        alarm = "-" if response.alarm is None else f"{response.alarm} frame{'' if response.alarm == 1 else 's'}"
        wrong = "-" if evaluation is None else str(response.wrong(evaluation))
        table.add_row(fault.label, str(len(response.struck)), str(response.refused), alarm, wrong)
    console.print(table)


def print_evaluation(evaluation: Evaluation) -> None:
    """Errors by range, then what the covariances were worth."""
    table = Table(title="Errors: median / 95 % / max", title_justify="left")
    table.add_column("range")
    for heading in ("published", "position, mm", "attitude, deg"):
        table.add_column(heading, justify="right")
    for row in evaluation.rows:
        if row.frames:
            table.add_row(*_range_cells(row))
    table.add_section()
    table.add_row(*_range_cells(evaluation.overall))
    console.print(table)
    print_judged(evaluation.frames, evaluation.run_frames, "frames")
    if not evaluation.published:
        return
    if 2 * evaluation.wrong.sum() > evaluation.published:
        console.print("most poses are wrong: is it the same sequence, and the same frame C of the target?")
    console.print(f"within 20 mm and 2 deg: {100 * evaluation.within_paper_limits:.1f} % of the published")
    console.print(f"wrong (> 20 mm or > 2 deg (1 + range / 1 m)): {int(evaluation.wrong.sum())}")
    console.print(f"mean NEES / 6: {evaluation.mean_nees_ratio:.2f}")
    shares = [f"{100 * share:.1f}" for share in evaluation.within_3_sigma]
    position, rotation = " ".join(shares[:3]), " ".join(shares[3:])
    console.print(f"within 3 sigma, %: position {position}, rotation {rotation}")


def print_judged(judged: int, total: int, what: str) -> None:
    """How many frames or poses are compared with the truth, where it is not all."""
    if judged < total:
        console.print(f"judged: {judged} of {total} {what}; the others have no true pose within 1 us")


def _range_cells(row: RangeRow) -> list[str]:
    return [
        row.name,
        f"{row.published} of {row.frames}",
        _triple(row.position_m, 1e3),
        _triple(row.attitude_rad, float(np.degrees(1.0))),
    ]


def _triple(quantiles: Quantiles | None, scale: float) -> str:
    if quantiles is None:
        return "-"
    return " / ".join(f"{value * scale:.3f}" for value in (quantiles.median, quantiles.p95, quantiles.max))


def _percent(part: int, whole: int) -> str:
    return f"{100 * part / whole:.1f} %"
