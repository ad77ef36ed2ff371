"""The image front end beside cv2.Canny: medians of ratios on the images of a sequence, interleaved, on one thread.

    python bench/front_end.py SEQUENCE                       # times
    python bench/front_end.py SEQUENCE --instructions REPLAY # and instructions a pixel, by valgrind

REPLAY is the replay program of a build.  Valgrind knows no AVX-512: it counts what AVX2 takes, or the set that
RVDNAV_FORCE_ISA names.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table
from rvdnav import Sequence, open_sequence
from rvdnav.core.arrays import image_argument
from rvdnav.core.context import Context
from rvdnav.core.library import constants, ffi, lib
from rvdnav.core.status import check

SCRIPTS = Path(__file__).resolve().parents[1] / "scripts"
TURNS = 5
STAGES = ("smooth", "edges", "thin", "rectify", "hough")
THINNED = 3  # stages up to the thinned bits
# The replay program's calls, and how often it makes each on one image.
CALLS = ("smooth", "detect_edges", "filter_edges", "thin", "rectify_edges", "hough_vote", "hough_peaks")


def images_of(sequence: Sequence) -> list[tuple[int, NDArray[np.uint8]]]:
    """Camera and pixels of every image."""
    views = ((camera, image) for frame in sequence for camera, image in enumerate((frame.left, frame.right)))
    return [(camera, image.pixels) for camera, image in views if image is not None]


def stage_seconds(context: Context, camera: int, pixels: NDArray[np.uint8], result: Any) -> NDArray[np.float64]:
    """Of one pass without a prior, by the core's own clock."""
    image, _keep = image_argument(pixels)
    check(lib.rvdnav_view(context.handle, camera, image, ffi.NULL, 0, result))
    codes = {name: code for code, name in constants("RVDNAV_STAGE_").items()}
    return np.array([result.stage_ns[codes[stage]] for stage in STAGES]) * 1e-9


def canny_seconds(pixels: NDArray[np.uint8]) -> float:
    start = time.perf_counter()
    cv2.Canny(pixels, 50, 150)
    return time.perf_counter() - start


def measure(sequence: Sequence) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Seconds of every stage (n, stages) and of Canny (n,) for every image: by turns, the best of each, as other
    programs take the processor away now and then."""
    context = Context(sequence.rig)
    result = ffi.new("rvdnav_view_result *")
    result.struct_size = ffi.sizeof("rvdnav_view_result")
    ours, canny = [], []
    for camera, pixels in images_of(sequence):
        turns = [(stage_seconds(context, camera, pixels, result), canny_seconds(pixels)) for _ in range(TURNS)]
        ours.append(np.min([stages for stages, _ in turns], axis=0))
        canny.append(min(seconds for _, seconds in turns))
    return np.array(ours), np.array(canny)


def time_table(ours: NDArray[np.float64], canny: NDArray[np.float64]) -> Table:
    """Every stage, then the sums that matter."""
    table = Table("stage", "ms", "of Canny", title=f"{len(canny)} images; Canny {np.median(canny) * 1e3:.3f} ms")
    sums = [(name, ours[:, i]) for i, name in enumerate(STAGES)]
    sums.append(("image to thinned bits", ours[:, :THINNED].sum(axis=1)))
    sums.append(("image to Hough peaks", ours.sum(axis=1)))
    for name, seconds in sums:
        table.add_row(name, f"{np.median(seconds) * 1e3:.3f}", f"{np.median(seconds / canny):.3f}")
    return table


def instructions(path: Path, replay: Path) -> Table:
    """Instructions a pixel of every stage, on the sequence's first and last frame."""
    isa = os.environ.get("RVDNAV_FORCE_ISA", "")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        subprocess.run([sys.executable, SCRIPTS / "replay_inputs.py", path, folder, "0", "-1"], check=True)
        frames = sorted(folder.glob("frame*.pgm"))
        record = folder / "callgrind"
        program = [str(replay), str(folder / "rig.txt"), *filter(None, [isa]), *map(str, frames)]
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={record}", *program]
        subprocess.run(command, check=True, capture_output=True)
        listing = ["callgrind_annotate", "--inclusive=yes", "--threshold=100", str(record)]
        text = subprocess.run(listing, check=True, capture_output=True, text=True).stdout
        pixels = sum(cv2.imread(str(frame), cv2.IMREAD_GRAYSCALE).size for frame in frames)
    table = Table("stage", "instructions a pixel", title=f"{isa or 'valgrind’s best instruction set'}")
    counts = [_inclusive(text, f"rvdnav_{call}") / pixels for call in CALLS]
    for call, count in zip((*CALLS, "all"), (*counts, sum(counts)), strict=True):
        table.add_row(call, f"{count:.1f}")
    return table


def _inclusive(listing: str, function: str) -> int:
    found = re.search(rf"^\s*([\d,]+) .*:{function}(?: |$)", listing, re.MULTILINE)
    if found is None:
        raise SystemExit(f"front_end: callgrind saw no {function}")
    return int(found[1].replace(",", ""))


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", type=Path)
    parser.add_argument("--instructions", type=Path, metavar="REPLAY")
    arguments = parser.parse_args()
    cv2.setNumThreads(1)
    console = Console()
    console.print(time_table(*measure(open_sequence(arguments.sequence))))
    if arguments.instructions is not None:
        console.print(instructions(arguments.sequence, arguments.instructions))


if __name__ == "__main__":
    main()
