"""Each stage of the core on a 704x576 image of the example, beside OpenCV's Canny and Hough transform."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import pytest
from rvdnav import Frame, Sequence
from rvdnav.core import WINDOW, Core

STAGES = (
    "smooth",
    "detect_edges",
    "filter_edges",
    "thin",
    "rectify_edges",
    "hough_vote",
    "hough_peaks",
    "hough_track",
    "extract_segments",
    "find_bars",
    "measure_edges",
    "correlate",
    "triangulate",
    "surface",
)
LEFT, RIGHT = 0, 1


@pytest.fixture(scope="module")
def frame(frames: list[Frame]) -> Frame:
    return frames[len(frames) // 2]


@pytest.fixture(scope="module")
def stages(sequence: Sequence, frame: Frame) -> dict[str, Callable[[], Any]]:
    """Every stage with the input that the stages before it give."""
    assert frame.left is not None
    assert frame.right is not None
    core = Core(sequence.rig, sequence.target)
    left, right = frame.left.pixels, frame.right.pixels
    smoothed = core.smooth(LEFT, left)
    raw_bits, direction = core.detect_edges(LEFT, smoothed)
    filtered = core.filter_edges(LEFT, raw_bits)
    bits = core.thin(LEFT, filtered)
    edgels = core.rectify_edges(LEFT, bits, direction)
    accumulator = core.hough_vote(edgels)
    peaks = core.hough_peaks(accumulator)
    segments = core.extract_segments(LEFT, edgels, peaks)
    edges, points, points_right = _projections(sequence, frame)
    windows = _windows(edges)
    return {
        "smooth": lambda: core.smooth(LEFT, left),
        "detect_edges": lambda: core.detect_edges(LEFT, smoothed),
        "filter_edges": lambda: core.filter_edges(LEFT, raw_bits),
        "thin": lambda: core.thin(LEFT, filtered),
        "rectify_edges": lambda: core.rectify_edges(LEFT, bits, direction),
        "hough_vote": lambda: core.hough_vote(edgels),
        "hough_peaks": lambda: core.hough_peaks(accumulator),
        "hough_track": lambda: core.hough_track(LEFT, edgels, windows),
        "extract_segments": lambda: core.extract_segments(LEFT, edgels, peaks),
        "find_bars": lambda: core.find_bars(LEFT, segments),
        "measure_edges": lambda: core.measure_edges(LEFT, left, edges),
        "correlate": lambda: core.correlate(left, right, points),
        "surface": lambda: core.surface(left, right),
        "triangulate": lambda: core.triangulate(points, points_right),
    }


def _projections(sequence: Sequence, frame: Frame) -> tuple[Any, Any, Any]:
    """The bracket's edges in the left view and points on them in both, rectified, from the true pose."""
    assert sequence.truth is not None
    T = sequence.truth.at(frame.timestamp_ns)
    bracket = sequence.target.bracket
    assert T is not None
    assert bracket is not None
    ends = bracket.edge_points @ T[:3, :3].T + T[:3, 3]
    points = np.linspace(ends[:, 0], ends[:, 1], 8).reshape(-1, 3)
    views = [sequence.rig.project_rect(camera, points) for camera in (LEFT, RIGHT)]
    return sequence.rig.project_rect(LEFT, ends).reshape(-1, 4), *views


def _windows(edges: Any) -> Any:
    """Where the edges (n, 4) are expected in Hough space, +- 6 px and 3 degrees."""
    along = edges[:, 2:] - edges[:, :2]
    theta = np.arctan2(along[:, 0], -along[:, 1])
    theta = (theta + np.pi / 4) % np.pi - np.pi / 4
    tangents = np.stack([-np.sin(theta), np.cos(theta)], axis=1)
    t = np.stack([(edges[:, :2] * tangents).sum(axis=1), (edges[:, 2:] * tangents).sum(axis=1)])
    windows = np.zeros(len(edges), WINDOW)
    windows["edge"] = np.arange(len(edges))
    windows["theta"], windows["half_theta"] = theta, np.radians(3.0)
    windows["rho"] = edges[:, 0] * np.cos(theta) + edges[:, 1] * np.sin(theta)
    windows["half_rho"] = 6.0
    windows["t_min"], windows["t_max"] = t.min(axis=0), t.max(axis=0)
    return windows


@pytest.mark.benchmark(group="stage")
@pytest.mark.parametrize("name", STAGES)
def test_stage(benchmark: Any, stages: dict[str, Callable[[], Any]], name: str) -> None:
    assert len(benchmark(stages[name]))  # every stage finds something in this image


@pytest.mark.benchmark(group="stage")
def test_opencv_canny(benchmark: Any, frame: Frame) -> None:
    assert frame.left is not None
    assert benchmark(cv2.Canny, frame.left.pixels, 50, 150).any()


@pytest.mark.benchmark(group="stage")
def test_opencv_hough_lines(benchmark: Any, frame: Frame) -> None:
    assert frame.left is not None
    edges = cv2.Canny(frame.left.pixels, 50, 150)
    assert len(benchmark(cv2.HoughLines, edges, 1, np.pi / 180, 60))
