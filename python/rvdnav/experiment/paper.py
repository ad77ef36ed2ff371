"""The report of the paper's experiment: its run navigated, the counterparts of its figures, and its claims examined."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import attrs
import numpy as np

from rvdnav.core import Core
from rvdnav.errors import InputError
from rvdnav.evaluation import PAPER_ATTITUDE_RAD, PAPER_POSITION_M, Evaluation, evaluate
from rvdnav.experiment.figures import axis_figure, detail_figure, errors_figure, sobel_figure
from rvdnav.experiment.pictures import draw_edges, draw_map, draw_matches, draw_plain
from rvdnav.experiment.sobel import THRESHOLDS, EdgeTrial, compare_edges
from rvdnav.experiment.thinning import Thinning, compare_thinning
from rvdnav.navigator import Navigator
from rvdnav.report.html import figure_html, note_html, section, strip_html, table_html
from rvdnav.report.page import write_page
from rvdnav.sequence import Sequence as Recorded
from rvdnav.solution import Solution

REPORT = "experiment.html"
_FRAMES = 6
_X, _Z = 0, 2


@attrs.frozen(eq=False)
class Run:
    """A sequence with its true poses, and what the navigator made of it."""

    sequence: Recorded
    solutions: tuple[Solution, ...]
    evaluation: Evaluation


def navigate(sequence: Recorded) -> Run:
    """Navigate a stereo sequence with default settings.  Raises InputError without truth, or with one camera."""
    if sequence.truth is None:
        raise InputError(f"{sequence.path}: has no groundtruth.tum to be compared with")
    if not sequence.rig.is_stereo:
        raise InputError(f"{sequence.path}: has one camera; the paper's experiment needs two")
    navigator = Navigator(sequence.rig, sequence.target)
    solutions = tuple(navigator.process(frame) for frame in sequence)
    return Run(sequence, solutions, evaluate(solutions, sequence.truth))


def write_paper_report(path: Path, run: Run) -> None:
    """Write the report of a run; two of the same run differ in the measured times alone.

    Raises InputError without scikit-image, with which the thinning is compared.
    """
    core = Core(run.sequence.rig, run.sequence.target)
    trials = compare_edges(core)
    middle = trials[len(trials) // 2]
    thinned = [
        (what, compare_thinning(core, middle.chart, edges))
        for what, edges in (("adaptive edges", middle.adaptive_map), ("plain Sobel edges", middle.plain_map))
    ]
    sections = [
        *_run_sections(core, run),
        section("Section 3.1: detail against noise", _sobel_text(trials) + figure_html(sobel_figure(trials), "sobel")),
        section("Section 3.1: edges shown, by brightness and contrast", figure_html(detail_figure(middle), "detail")),
        section("Section 3.1: the same chart", _chart_pictures(middle)),
        section("Section 3.1: thinning", _thinning_table(thinned)),
    ]
    frames = len(run.solutions)
    subtitle = f"the experiment of the paper, repeated on {frames} stereo frames with known truth"
    write_page(path, run.sequence.path.resolve().name, subtitle, _tiles(run.evaluation), sections)


def _run_sections(core: Core, run: Run) -> list[str]:
    frames = [run.sequence[index] for index in np.linspace(0, len(run.solutions) - 1, _FRAMES).round().astype(int)]
    seen = [frame for frame in frames if frame.left is not None and frame.right is not None]
    captions = [_range_caption(run, frame.timestamp_ns) for frame in seen]
    return [
        section("Figure 9: the sequence", _strip([draw_plain(frame) for frame in seen], captions)),
        section("Figure 10: edges", _strip([draw_edges(core, frame) for frame in seen], captions)),
        section("Figure 11: matched points", _strip([draw_matches(core, f, run.sequence.rig) for f in seen], captions)),
        section("Figure 12: x measured and true", figure_html(axis_figure(run, _X), "x")),
        section("Figure 13: z measured and true", figure_html(axis_figure(run, _Z), "z")),
        section("Figure 14: errors, and the paper's limits", figure_html(errors_figure(run), "errors")),
    ]


def _range_caption(run: Run, timestamp_ns: int) -> str:
    truth = run.sequence.truth
    T = None if truth is None else truth.at(timestamp_ns)
    start = run.solutions[0].timestamp_ns
    time = f"{(timestamp_ns - start) * 1e-9:.2f} s"
    return time if T is None else f"{time}, range {np.linalg.norm(T[:3, 3]):.2f} m"


def _strip(pictures: Sequence[str], captions: Sequence[str]) -> str:
    return strip_html(zip(pictures, captions, strict=True))


def _tiles(evaluation: Evaluation) -> list[tuple[str, str, str]]:
    published = f"{evaluation.published} of {evaluation.frames} frames published"
    tiles = [("published", f"{100 * evaluation.published_fraction:.1f} %", published)]
    if evaluation.published:
        position, attitude = 1e3 * evaluation.position_m, np.degrees(evaluation.attitude_rad)
        paper_mm, paper_deg = 1e3 * PAPER_POSITION_M, np.degrees(PAPER_ATTITUDE_RAD)
        tiles += [
            ("largest position error", f"{position.max():.2f} mm", f"median {np.median(position):.3f} mm"),
            (
                "paper's position limit",
                f"±{paper_mm:.0f} mm",
                f"{paper_mm / position.max():.0f} times our largest",
            ),
            ("largest attitude error", f"{attitude.max():.2f}°", f"median {np.median(attitude):.3f}°"),
            (
                "paper's attitude limit",
                f"±{paper_deg:.0f}°",
                f"{paper_deg / attitude.max():.1f} times our largest",
            ),
        ]
    return tiles


def _sobel_text(trials: Sequence[EdgeTrial]) -> str:
    headings = (
        "noise",
        "true edges shown, adaptive",
        "plain",
        "noise edges in 10 000 px, adaptive",
        "plain",
        "plain threshold, grey levels",
    )
    rows = [
        (
            f"× {trial.noise:g}",
            f"{100 * trial.adaptive.detail:.1f} %",
            f"{100 * trial.plain[trial.matched].detail:.1f} %",
            f"{1e4 * trial.adaptive.noise:.1f}",
            f"{1e4 * trial.plain[trial.matched].noise:.1f}",
            f"{THRESHOLDS[trial.matched]:.0f}",
        )
        for trial in trials
    ]
    note = note_html(
        "A chart of edges of 8 to 35 % contrast on grounds from deep shadow to full light, with the "
        "noise of a sensor times 1, 2 and 3. The plain operator is drawn over all thresholds; the adaptive one has one "
        "setting. The table gives the plain operator the lowest threshold, a whole grey level, at which it shows no "
        "more noise than the adaptive one."
    )
    return note + table_html(headings, rows)


def _chart_pictures(trial: EdgeTrial) -> str:
    captions = [f"chart, noise × {trial.noise:g}", "adaptive Sobel", "plain Sobel, as much noise"]
    pictures = [draw_map(trial.chart.image), draw_map(trial.adaptive_map), draw_map(trial.plain_map)]
    return _strip(pictures, captions)


def _thinning_table(thinned: Sequence[tuple[str, Sequence[Thinning]]]) -> str:
    headings = (
        "thinned, by",
        "pixels left",
        "2 × 2 blocks left",
        "connected edges",
        "RMS distance from the true edge, px",
        "time, ms",
    )
    rows = [
        (
            f"{what}, {one.name}",
            str(one.pixels),
            str(one.thick),
            f"{one.components[0]} → {one.components[1]}",
            f"{one.offset_px:.2f}",
            f"{1e3 * one.seconds:.2f}",
        )
        for what, pair in thinned
        for one in pair
    ]
    return table_html(headings, rows) + note_html(
        "The usual thinning is that of Zhang and Suen, as scikit-image has it. Times are medians on this machine."
    )
