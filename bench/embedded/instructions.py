"""Instructions that the flight program takes a frame, stage by stage, on each Arm processor under QEMU.

instructions.py SEQUENCE [--keep PAGE | --compare PAGE]

SEQUENCE: as examples/embedded/pack.py makes it.  Prints a table in thousands: the search's stages are the mean over
the frames that are searched, the measurement's over those that are not, since they were predicted.  --keep puts it
into a page of the documents in place of the one there; --compare fails where a stage takes over a tenth more than
there.  The counts are the same in every run; another compiler gives others.
"""

import argparse
import itertools
import os
import re
import subprocess
import tempfile
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PRESETS = {
    "baremetal-arm926": "ARM926EJ-S",
    "baremetal-cortex-m7": "Cortex-M7",
    "armv7-neon": "ARMv7, NEON",
    "aarch64": "AArch64, NEON",
}
TOLERANCE = 1.10
LEAST = 20  # thousands; what takes less is not compared

# Where a stage begins: it lasts until the next mark is passed.
OUTSIDE = ""  # input and output, which belong to the board
BETWEEN = "search: between these"
SEARCH = {
    "rvdnav::smooth": "search: smooth",
    "rvdnav::detect_edges": "search: edges",
    "rvdnav::filter_edges": "search: edges",
    "rvdnav::thin": "search: thin",
    "rvdnav::rectify_gradients": "search: rectify",
    "rvdnav::hough_vote": "search: Hough votes",
    "rvdnav::hough_peaks": "search: Hough peaks",
    "rvdnav::extract_segments": "search: segments",
    "rvdnav::find_bars": "search: bars",
    "rvdnav::propose_brackets": "search: brackets proposed",
    "rvdnav::acquire_bracket": "search: bracket chosen",
    "rvdnav::hough_track": "search: lines refitted",
    "rvdnav::refit_line": "search: lines refitted",
    "rvdnav::correlate_rows": "search: correlation",
    "rvdnav::triangulate": "search: triangulation",
    "rvdnav_view": BETWEEN,
    "rvdnav_join": BETWEEN,
}
MEASUREMENT = {
    "rvdnav::sample_edges": "measurement: edges sampled",
    "rvdnav::fit_edge_lines": "measurement: lines fitted",
    "rvdnav::refine_pose": "measurement: pose refined",
    "rvdnav::gather_evidence": "measurement: evidence",
    "rvdnav_measure": "measurement: between these",
}
STAGES = {"sequence_read": OUTSIDE, "put": OUTSIDE, "hash": OUTSIDE} | SEARCH | MEASUREMENT
SEARCHED, PREDICTED = "a stereo frame searched", "a stereo frame predicted"

Column = dict[str, float]  # thousands of instructions a frame, by stage


def build_plugin(folder: Path) -> Path:
    """Compiles count.c."""
    library = folder / "libcount.so"
    flags = ["-std=c11", "-O2", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-fvisibility=hidden"]
    subprocess.run(["cc", *flags, "-o", library, ROOT / "bench" / "embedded" / "count.c"], check=True)
    return library


def marks(program: Path) -> str:
    """Lines of address and name of each function of STAGES that the program has."""
    listed = subprocess.run(["nm", "-C", program], check=True, capture_output=True, text=True).stdout
    lines = []
    for address, name in re.findall(r"^([0-9a-f]+) [TtW] ([\w:]+)(?:\(.*)?$", listed, re.MULTILINE):
        if name in STAGES:
            lines.append(f"{int(address, 16) & ~1:x} {name}")  # the lowest bit says that it is Thumb code
    return "\n".join(lines) + "\n"


def count(preset: str, sequence: Path, plugin: Path) -> Column:
    """What the flight program of a preset takes."""
    program = ROOT / "build" / preset / "examples" / "embedded" / "flight"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "marks").write_text(marks(program))
        options = f"{plugin},marks={folder / 'marks'},out={folder / 'passed'}"
        command = [str(ROOT / "scripts" / "emulate"), preset, "flight", str(sequence)]
        subprocess.run(command, check=True, env=os.environ | {"EMULATE_PLUGIN": options}, stdout=subprocess.DEVNULL)
        passed = [line.split() for line in (folder / "passed").read_text().splitlines()]
    return column(passed)


def column(passed: list[list[str]]) -> Column:
    """From the marks in the order that they were passed in, and how many instructions had run before each."""
    frames: list[Counter[str]] = []
    for (mark, start), (_, end) in itertools.pairwise(passed):
        if mark == "sequence_read":
            frames.append(Counter())
        if frames and STAGES[mark] != OUTSIDE:
            frames[-1][STAGES[mark]] += int(end) - int(start)
    searched = [frame for frame in frames if BETWEEN in frame]
    predicted = [frame for frame in frames if BETWEEN not in frame]

    def mean(kind: list[Counter[str]], stages: Iterable[str]) -> float:
        return sum(frame[stage] for frame in kind for stage in stages) / len(kind) / 1e3

    search, measurement = dict.fromkeys(SEARCH.values()), dict.fromkeys(MEASUREMENT.values())
    rows = {stage: mean(searched, [stage]) for stage in search}
    rows |= {stage: mean(predicted, [stage]) for stage in measurement}
    everything = [*search, *measurement]
    return rows | {SEARCHED: mean(searched, everything), PREDICTED: mean(predicted, everything)}


def as_table(columns: dict[str, Column]) -> str:
    """Markdown."""
    rows = [["thousands of instructions", *columns], ["---", *("--:" for _ in columns)]]
    for stage in next(iter(columns.values())):
        rows.append([stage, *(f"{counts[stage]:,.0f}" for counts in columns.values())])
    return "".join("| " + " | ".join(row) + " |\n" for row in rows)


def find_table(page: str) -> str:
    """The table of a page."""
    return "".join(re.findall(r"^\| thousands of instructions .*\n(?:\|.*\n)+", page, re.MULTILINE))


def read_table(table: str) -> dict[str, Column]:
    """What as_table wrote."""
    rows = [[cell.strip() for cell in row.split("|")[1:-1]] for row in table.splitlines()]
    names = rows[0][1:]
    return {name: {row[0]: float(row[1 + i].replace(",", "")) for row in rows[2:]} for i, name in enumerate(names)}


def grown(before: dict[str, Column], after: dict[str, Column]) -> list[str]:
    """A line for each stage that takes over a tenth more, or is not in the table."""
    lines = []
    for processor, counts in after.items():
        for stage, thousands in counts.items():
            kept = before.get(processor, {}).get(stage, 0.0)
            if thousands > max(TOLERANCE * kept, LEAST):
                lines.append(f"{processor}, {stage}: {kept:,.0f} -> {thousands:,.0f} thousand instructions")
    return lines


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", type=Path)
    parser.add_argument("--keep", type=Path, metavar="PAGE")
    parser.add_argument("--compare", type=Path, metavar="PAGE")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        plugin = build_plugin(Path(folder))
        columns = {name: count(preset, options.sequence, plugin) for preset, name in PRESETS.items()}
    table = as_table(columns)
    print(table, end="")
    if options.keep is not None:
        page = options.keep.read_text()
        options.keep.write_text(page.replace(find_table(page), table))
    if options.compare is not None:
        lines = grown(read_table(find_table(options.compare.read_text())), columns)
        if lines:
            raise SystemExit("\n".join(lines))


if __name__ == "__main__":
    main()
