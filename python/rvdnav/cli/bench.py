"""``rvdnav bench``: the speed table."""

from __future__ import annotations

from pathlib import Path

from rich.table import Table

from rvdnav.benchmark import Benchmark, Timing, benchmark
from rvdnav.cli.examples import example
from rvdnav.cli.terminal import console
from rvdnav.sequence import open_sequence


def bench(path: Path | None) -> int:
    """Time the frames of the sequence at ``path``, of the example where it is None.  Raises InputError."""
    _print_benchmark(benchmark(open_sequence(example("approach") if path is None else path)))
    return 0


def _print_benchmark(result: Benchmark) -> None:
    kinds: list[Timing | None] = [result.acquisition, result.tracking]
    table = Table(title="Median time of a stereo frame, ms", title_justify="left")
    table.add_column("stage")
    table.add_column("acquisition", justify="right")
    table.add_column("tracking", justify="right")
    stages = dict.fromkeys(stage for kind in kinds if kind is not None for stage in kind.stages)
    for stage in stages:
        table.add_row(stage, *(_milliseconds(None if kind is None else kind.stages.get(stage)) for kind in kinds))
    table.add_section()
    table.add_row("whole frame", *(_milliseconds(None if kind is None else kind.frame) for kind in kinds))
    table.add_row("frames/s", *("-" if kind is None else f"{1 / kind.frame:.1f}" for kind in kinds))
    table.add_row("frames timed", *("0" if kind is None else str(kind.frames) for kind in kinds))
    table.add_section()
    table.add_row("cv2.Canny(image, 50, 150)", *[_milliseconds(result.canny)] * 2)
    table.add_row("cv2.HoughLines on its edges", *[_milliseconds(result.hough)] * 2)
    console.print(table)
    console.print("Our two views run at the same time; OpenCV takes one image after the other.")


def _milliseconds(seconds: float | None) -> str:
    return "-" if seconds is None else f"{seconds * 1e3:.2f}"
