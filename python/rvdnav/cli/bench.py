"""``rvdnav bench``: the speed table, and its figures as JSON."""

from __future__ import annotations

from pathlib import Path

from rich.table import Table

from rvdnav.benchmark import Benchmark, Times, benchmark
from rvdnav.cli.examples import example
from rvdnav.cli.terminal import console, progress_bars
from rvdnav.jsonio import write_json
from rvdnav.sequence import open_sequence

_LEGEND = (
    "Above: a frame of two images, on two threads. Below: OpenCV with one image, on one thread, by turns with the "
    "frames; HoughLines takes Canny's edges. Of Canny: the median of the ratios; other load on the machine raises "
    "those of what takes long."
)


def bench(path: Path | None, frames: int, json_path: Path | None) -> int:
    """Time frames of the sequence at ``path``, of the example where it is None.  Raises InputError."""
    sequence = open_sequence(example("approach") if path is None else path)
    with progress_bars() as tell:
        result = benchmark(sequence, frames, tell)
    _print_times(result)
    _print_stages(result)
    if json_path is not None:
        write_json(json_path, result.record())
    return 0


def _print_times(result: Benchmark) -> None:
    size, isa = result.machine["image"], result.machine["isa"]
    table = Table(title=f"Wall times, {size}, {isa}, {result.machine['processor']}", title_justify="left")
    table.add_column("", no_wrap=True)
    for heading in ("median ms", "95 %", "99 %", "of Canny", "1/s", "timed"):
        table.add_column(heading, justify="right")
    for name, times in result.whole.items():
        table.add_row(name, *_cells(times), f"{1.0 / times.percentile(50):.1f}", str(len(times.seconds)))
    table.add_section()
    for name, times in result.yardsticks.items():
        table.add_row(name, *_cells(times), "", str(len(times.seconds)))
    console.print(table)
    console.print(_LEGEND)


def _cells(times: Times) -> list[str]:
    return [*(f"{1e3 * times.percentile(percent):.3f}" for percent in (50, 95, 99)), f"{times.ratio:.2f}"]


def _print_stages(result: Benchmark) -> None:
    table = Table(title="Median time of a stage, ms", title_justify="left")
    table.add_column("stage")
    for name in result.stages:
        table.add_column(name, justify="right")
    for stage in dict.fromkeys(stage for stages in result.stages.values() for stage in stages):
        found = (stages.get(stage) for stages in result.stages.values())
        table.add_row(stage, *("-" if seconds is None else f"{1e3 * seconds:.2f}" for seconds in found))
    console.print(table)
