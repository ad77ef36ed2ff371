"""Pictures of frames with the edges, the measured lines and the projected target drawn on them."""

from __future__ import annotations

from collections.abc import Callable

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from rvdnav.pose.arrays import FloatArray
from rvdnav.report.html import jpeg_uri
from rvdnav.rig import Rig
from rvdnav.sequence import Frame
from rvdnav.solution import Solution
from rvdnav.target import Target

ByteArray = NDArray[np.uint8]

# BGR; the legend in page.html names the same colours.
_EDGE_COLOUR = (190, 150, 40)
_LINE_COLOUR = (60, 200, 255)
_TARGET_COLOUR = (110, 230, 70)
_CURVE_POINTS = 24  # along a straight edge, so that the lens distortion bends it
_SUBPIXEL_BITS = 4
_SCALE = 2  # of the picture, for lines finer than a pixel
_OVERHANG = 14.0  # px
_JPEG_QUALITY = 80

EdgeMask = Callable[[int, ByteArray], NDArray[np.bool_]]
"""Camera index and image (h, w) -> mask (h, w) of its edge pixels."""


@attrs.frozen
class Picture:
    """One frame of the strip: of which time and camera, its image for an img element's src, and why it is shown."""

    timestamp_ns: int
    camera: int
    uri: str
    why: str = ""


def draw_picture(
    frame: Frame, solution: Solution, rig: Rig, target: Target, edges: EdgeMask, why: str = ""
) -> Picture | None:
    """The left image (the right one where the left is missing) with what was found; None without any image."""
    camera, image = (0, frame.left) if frame.left is not None else (1, frame.right)
    if image is None:
        return None
    # The grey image is darkened so that the drawing stands out on sunlit frames too.
    canvas = np.repeat((image.pixels * 0.8).astype(np.uint8)[:, :, None], 3, axis=2)
    canvas[edges(camera, image.pixels)] = _EDGE_COLOUR
    canvas = canvas.repeat(_SCALE, axis=0).repeat(_SCALE, axis=1)
    for segment in solution.view_lines.get(camera, np.empty((0, 4))):
        _draw_curve(canvas, rig.rect_to_raw(camera, _lengthened(segment)), _LINE_COLOUR)
    if solution.T_world_target is not None:
        for curve in _projected_edges(solution.T_world_target, rig, target, camera):
            _draw_curve(canvas, curve, _TARGET_COLOUR)
    return Picture(timestamp_ns=frame.timestamp_ns, camera=camera, uri=jpeg_uri(canvas, _JPEG_QUALITY), why=why)


def _lengthened(segment: FloatArray) -> FloatArray:
    """Points along a segment and a little beyond, where the projected target doesn't cover it and lines meet."""
    start, end = segment[:2], segment[2:]
    overhang = (end - start) * (_OVERHANG / max(float(np.linalg.norm(end - start)), 1.0))
    return np.linspace(start - overhang, end + overhang, _CURVE_POINTS)


def _projected_edges(T_world_target: FloatArray, rig: Rig, target: Target, camera: int) -> list[FloatArray]:
    """The target's edges as raw-pixel curves (n, 2); NaN behind the camera."""
    ends = [*target.edges, *(edge for bar in target.bars for edge in (bar.outer, bar.inner))]
    curves = []
    for start, end in ends:
        points = np.linspace(target.points[start], target.points[end], _CURVE_POINTS)
        curves.append(rig.project(camera, points @ T_world_target[:3, :3].T + T_world_target[:3, 3]))
    return curves


def _draw_curve(canvas: ByteArray, points: FloatArray, colour: tuple[int, int, int]) -> None:
    points = points[np.isfinite(points).all(axis=1)]  # the rest lies behind the camera
    pixels = (points + 0.5) * _SCALE - 0.5  # pixel centres of the enlarged canvas
    fixed = np.round(pixels * (1 << _SUBPIXEL_BITS)).astype(np.int32)
    cv2.polylines(canvas, [fixed[:, None, :]], False, colour, 2, cv2.LINE_AA, _SUBPIXEL_BITS)
