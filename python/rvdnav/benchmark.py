"""How long a frame takes, beside what OpenCV takes for usual things on the same image in the same run.

Machines differ and are seldom idle, so everything is timed by turns, frame by frame, and told as the median of its
ratios to `cv2.Canny(image, 50, 150)` of the same frame's left image on one thread.
"""

from __future__ import annotations

import os
import platform
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import cycle, islice, pairwise
from pathlib import Path
from typing import Any

import attrs
import cv2
import numpy as np

from rvdnav import __version__
from rvdnav.core import Core
from rvdnav.errors import InputError
from rvdnav.images import PixelArray
from rvdnav.navigator import Navigator
from rvdnav.pose.arrays import FloatArray
from rvdnav.rig import Rig
from rvdnav.sequence import Frame, Sequence
from rvdnav.solution import Solution
from rvdnav.summary import stage_medians

ACQUISITION, TRACKING, TRACKING_ONE_CORE = "acquisition", "tracking", "tracking, 1 core"
CANNY = "Canny(50, 150)"
_STEP_NS = 125_000_000
_HOUGH_VOTES = 60


def _seconds(values: Any) -> FloatArray:
    return np.asarray(values, np.float64)


@attrs.frozen(eq=False)
class Times:
    """Wall times of one thing, and of Canny at the same turns; arrays of one length, seconds."""

    seconds: FloatArray = attrs.field(converter=_seconds)
    canny: FloatArray = attrs.field(converter=_seconds)

    def percentile(self, percent: float) -> float:
        """Seconds within which so many percent of the turns were done."""
        return float(np.percentile(self.seconds, percent))

    @property
    def ratio(self) -> float:
        """Median of the ratios to Canny."""
        return float(np.median(self.seconds / self.canny))


@attrs.frozen(eq=False)
class Benchmark:
    """whole: of a frame, by a fresh navigator or following a published frame; without those that never happened.
    stages: medians of their seconds, by the names of ``whole``.  yardsticks: of one image.  machine: what ran it."""

    whole: dict[str, Times]
    stages: dict[str, dict[str, float]]
    yardsticks: dict[str, Times]
    machine: dict[str, Any]

    def record(self) -> dict[str, Any]:
        """As plain numbers: seconds at 50, 95 and 99 percent, how many, and the ratio to Canny."""
        rows = {**self.whole, **self.yardsticks}
        times = {
            name: {
                **{f"p{percent}": times.percentile(percent) for percent in (50, 95, 99)},
                "ratio": times.ratio,
                "count": len(times.seconds),
            }
            for name, times in rows.items()
        }
        return {"machine": self.machine, "times": times, "stages": self.stages}


def benchmark(sequence: Sequence, frames: int, tell: Callable[[str, int, int], None] | None = None) -> Benchmark:
    """Time so many stereo frames of a sequence, shown forth and back.

    Acquisition is timed on the sequence's frames once, tracking on all that follow a published one.
    tell(what, done, total) is called for each.  Raises InputError when it has no stereo frames.
    """
    recorded = [frame for frame in sequence if frame.left is not None and frame.right is not None]
    if not recorded:
        raise InputError(f"{sequence.path}: holds no stereo frames")
    with _one_opencv_thread():
        return _by_turns(sequence, recorded, frames, tell or (lambda *_: None))


def _by_turns(
    sequence: Sequence, recorded: list[Frame], frames: int, tell: Callable[[str, int, int], None]
) -> Benchmark:
    one_core = min(os.sched_getaffinity(0))
    followed = Navigator(sequence.rig, sequence.target)
    with _on_cores({one_core}):  # its thread stays there
        confined = Navigator(sequence.rig, sequence.target)
    yardsticks = _yardsticks(sequence.rig)
    solutions: dict[str, list[Solution]] = {ACQUISITION: [], TRACKING: [], TRACKING_ONE_CORE: []}
    seconds: dict[str, list[float]] = {name: [] for name in (*solutions, *yardsticks)}
    for number, frame in enumerate(islice(_forth_and_back(recorded), frames)):
        if number < len(recorded):
            _process(Navigator(sequence.rig, sequence.target), frame, ACQUISITION, solutions, seconds)
        _process(followed, frame, TRACKING, solutions, seconds)
        with _on_cores({one_core}):
            _process(confined, frame, TRACKING_ONE_CORE, solutions, seconds)
        assert frame.left is not None
        for name, yardstick in yardsticks.items():
            seconds[name].append(_timed(yardstick, frame.left.pixels)[1])
        tell("frames", number + 1, frames)
    canny = np.array(seconds[CANNY])
    chosen = {ACQUISITION: np.arange(len(seconds[ACQUISITION]))}
    for name in (TRACKING, TRACKING_ONE_CORE):
        after_a_pose = [before.published for before, _ in pairwise(solutions[name])]
        chosen[name] = 1 + np.flatnonzero(after_a_pose)
    return Benchmark(
        whole={name: Times(_seconds(seconds[name])[k], canny[k]) for name, k in chosen.items() if len(k)},
        stages={name: stage_medians([solutions[name][i] for i in k]) for name, k in chosen.items() if len(k)},
        yardsticks={name: Times(seconds[name], canny) for name in yardsticks},
        machine=machine(sequence.rig),
    )


def _process(
    navigator: Navigator,
    frame: Frame,
    name: str,
    solutions: dict[str, list[Solution]],
    seconds: dict[str, list[float]],
) -> None:
    solution, taken = _timed(navigator.process, frame)
    solutions[name].append(solution)
    seconds[name].append(taken)


def _forth_and_back(frames: list[Frame]) -> Iterator[Frame]:
    """The frames from first to last, back to the first, and so on, at 8 frames a second."""
    order = cycle([*range(len(frames)), *range(len(frames) - 2, 0, -1)])
    for number, index in enumerate(order):
        yield attrs.evolve(frames[index], timestamp_ns=(number + 1) * _STEP_NS)


def _timed(call: Callable[[Any], Any], argument: Any) -> tuple[Any, float]:
    start = time.perf_counter()
    result = call(argument)
    return result, time.perf_counter() - start


def _yardsticks(rig: Rig) -> dict[str, Callable[[PixelArray], Any]]:
    """What OpenCV does with an image; and eight points' pose, the last step alone of a navigator by markers."""
    size = (rig.height, rig.width)
    copy, edges = np.empty(size, np.uint8), np.empty(size, np.uint8)
    v, u = np.mgrid[0 : rig.height, 0 : rig.width].astype(np.float32) + np.float32(0.5)
    segments = cv2.createLineSegmentDetector()
    points = np.array([[x, y, 0.01 * x * y] for x in (-0.1, 0.1) for y in (-0.1, -0.03, 0.03, 0.1)])
    K = np.array([[rig.focal_rect, 0.0, rig.width / 2.0], [0.0, rig.focal_rect, rig.height / 2.0], [0.0, 0.0, 1.0]])
    seen, _ = cv2.projectPoints(points, np.array([0.1, -0.2, 0.3]), np.array([0.02, 0.03, 0.8]), K, None)

    def canny(image: PixelArray) -> None:
        edges[:] = cv2.Canny(image, 50, 150)

    return {
        CANNY: canny,
        "memcpy": lambda image: np.copyto(copy, image),
        "GaussianBlur 3x3": lambda image: cv2.GaussianBlur(image, (3, 3), 0),
        "remap, bilinear": lambda image: cv2.remap(image, u, v, cv2.INTER_LINEAR),
        "HoughLines": lambda _: cv2.HoughLines(edges, 1, np.pi / 180, _HOUGH_VOTES),
        "LineSegmentDetector": lambda image: segments.detect(image),
        "solvePnP, 8 points": lambda _: cv2.solvePnP(points, seen, K, None),
    }


@contextmanager
def _one_opencv_thread() -> Iterator[None]:
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(threads)


@contextmanager
def _on_cores(cores: set[int]) -> Iterator[None]:
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cores)
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def machine(rig: Rig) -> dict[str, Any]:
    """What tells two records apart: processor, its usable cores, image size, instruction set and versions."""
    return {
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)),
        "system": f"{platform.system()} {platform.machine()}",
        "image": f"{rig.width}x{rig.height}",
        "isa": Core(rig).isa,
        "rvdnav": __version__,
        "opencv": cv2.__version__,
        "numpy": np.__version__,
        "python": platform.python_version(),
    }


def _processor() -> str:
    path = Path("/proc/cpuinfo")
    lines = path.read_text().splitlines() if path.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown"
