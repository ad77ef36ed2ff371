"""Pictures of the experiment, as data URIs for a page."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from rvdnav.core import Core
from rvdnav.images import PixelArray
from rvdnav.pose.arrays import FloatArray
from rvdnav.report.edges import edge_mask
from rvdnav.report.html import png_uri
from rvdnav.rig import Rig
from rvdnav.sequence import Frame

_MATCH_COLOUR = (60, 200, 255)  # BGR
_APEX_COLOUR = (110, 230, 70)
_GAP = 8  # px between two views


def draw_plain(frame: Frame) -> str:
    """The left image of a frame."""
    return png_uri(_left(frame))


def draw_edges(core: Core, frame: Frame) -> str:
    """The thinned edges of the left image, dark on white."""
    return draw_map(edge_mask(core, 0, _left(frame)))


def draw_map(image: NDArray[np.bool_] | PixelArray) -> str:
    """A grey image, or a mask (h, w) dark on white."""
    return png_uri(np.where(image, 0, 255).astype(np.uint8) if image.dtype == np.bool_ else image.astype(np.uint8))


def draw_matches(core: Core, frame: Frame, rig: Rig) -> str:
    """Both images side by side with the corresponding points: the apexes P1 to P4 and Q1 to Q4, and those on the bars'
    faces that were correlated along the epipolar rows."""
    left, right = _left(frame), frame.right.pixels if frame.right is not None else np.zeros((0, 0), np.uint8)
    found = core.process(left, right)
    matches = found.matches[found.matches["accepted"] != 0]
    pairs = [(matches["x"], matches["y"], matches["x"] - matches["disparity"], matches["y"], _MATCH_COLOUR)]
    views = found.views
    if views[0] is not None and views[1] is not None:
        both = views[0].apex_found & views[1].apex_found
        pairs.append((*views[0].apexes[both].T, *views[1].apexes[both].T, _APEX_COLOUR))
    canvas = np.full((left.shape[0], 2 * left.shape[1] + _GAP, 3), 255, np.uint8)
    canvas[:, : left.shape[1]] = (0.8 * left[:, :, None]).astype(np.uint8)
    canvas[:, left.shape[1] + _GAP :] = (0.8 * right[:, :, None]).astype(np.uint8)
    for x_left, y_left, x_right, y_right, colour in pairs:
        a = rig.rect_to_raw(0, np.column_stack([x_left, y_left]))
        b = rig.rect_to_raw(1, np.column_stack([x_right, y_right]))
        b[:, 0] += left.shape[1] + _GAP
        for start, end in zip(a, b, strict=True):
            _draw_pair(canvas, start, end, colour)
    return png_uri(canvas)


def _draw_pair(canvas: NDArray[np.uint8], start: FloatArray, end: FloatArray, colour: tuple[int, int, int]) -> None:
    if not (np.isfinite(start).all() and np.isfinite(end).all()):
        return
    (x0, y0), (x1, y1) = np.round(start).astype(int), np.round(end).astype(int)
    faint = tuple(component // 2 for component in colour)
    cv2.line(canvas, (int(x0), int(y0)), (int(x1), int(y1)), faint, 1, cv2.LINE_AA)
    for x, y in ((x0, y0), (x1, y1)):
        cv2.circle(canvas, (int(x), int(y)), 4, colour, 2, cv2.LINE_AA)


def _left(frame: Frame) -> PixelArray:
    if frame.left is None:
        raise ValueError("the frame has no left image")
    return frame.left.pixels
