"""How long a frame takes, stage by stage, beside OpenCV's Canny and Hough transform on the same images."""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import islice, pairwise
from typing import TypeVar

import attrs
import cv2
import numpy as np

from rvdnav.errors import InputError
from rvdnav.navigator import Navigator
from rvdnav.sequence import Frame, Sequence
from rvdnav.solution import Solution
from rvdnav.summary import stage_medians

T = TypeVar("T")

MAX_FRAMES = 48
_HOUGH_VOTES = 60


@attrs.frozen
class Timing:
    """Median wall times in seconds over the frames of one kind."""

    frames: int
    stages: dict[str, float]
    frame: float
    """Of the whole process call."""


@attrs.frozen
class Benchmark:
    """Acquisition: every frame by a fresh navigator.  Tracking: frames that follow a published one."""

    acquisition: Timing
    tracking: Timing | None
    """None where nothing could be tracked."""
    canny: float
    """Median seconds of cv2.Canny(image, 50, 150) over both images of a frame."""
    hough: float
    """Median seconds of cv2.HoughLines on those edges, 1 px by 1 degree, over both images of a frame."""


def benchmark(sequence: Sequence) -> Benchmark:
    """Time the first stereo frames of a sequence.  Raises InputError when it has none."""
    stereo = (frame for frame in sequence if frame.left is not None and frame.right is not None)
    frames = list(islice(stereo, MAX_FRAMES))
    if not frames:
        raise InputError(f"{sequence.path}: holds no stereo frames")
    fresh = [_timed_process(Navigator(sequence.rig, sequence.target), frame) for frame in frames]
    navigator = Navigator(sequence.rig, sequence.target)
    followed = [_timed_process(navigator, frame) for frame in frames]
    tracked = [now for before, now in pairwise(followed) if before[0].published]
    opencv = np.median([_time_opencv(frame) for frame in frames], axis=0)
    return Benchmark(
        acquisition=_timing(fresh),
        tracking=_timing(tracked) if tracked else None,
        canny=float(opencv[0]),
        hough=float(opencv[1]),
    )


def _timed_process(navigator: Navigator, frame: Frame) -> tuple[Solution, float]:
    return _timed(lambda: navigator.process(frame))


def _timed(call: Callable[[], T]) -> tuple[T, float]:
    start = time.perf_counter()
    result = call()
    return result, time.perf_counter() - start


def _timing(runs: list[tuple[Solution, float]]) -> Timing:
    solutions = [solution for solution, _ in runs]
    return Timing(len(runs), stage_medians(solutions), float(np.median([seconds for _, seconds in runs])))


def _time_opencv(frame: Frame) -> tuple[float, float]:
    images = [image.pixels for image in (frame.left, frame.right) if image is not None]
    edges, canny = _timed(lambda: [cv2.Canny(image, 50, 150) for image in images])
    _, hough = _timed(lambda: [cv2.HoughLines(mask, 1, np.pi / 180, _HOUGH_VOTES) for mask in edges])
    return canny, hough
