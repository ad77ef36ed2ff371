"""A frame's images and the edge pixels in them."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from rvdnav.core import Core, FrameResult, noise_median
from rvdnav.core.arrays import Records
from rvdnav.images import PixelArray
from rvdnav.navigator.stage_times import add_frame_times, lap, now

Images = tuple[PixelArray | None, ...]
"""Of each camera, 8-bit grey (height, width); None where it has none."""

_SATURATED_GREY = 250
# What a white noise of standard deviation 1 has after the mask of `noise_sigma`, and its median absolute value of it.
_MASK_GAIN = 6.0
_MEDIAN_OF_NORMAL = 0.6745


@attrs.frozen(eq=False)
class View:
    """One view's edge pixels (EDGEL records), its mean grey level, and its share of saturated pixels."""

    edgels: NDArray[np.void]
    mean_grey: float
    saturated: float


Views = tuple[View | None, ...]


def reduced(images: Images, factor: int) -> Images:
    """Images of which each pixel is the mean of factor x factor, as `Rig.reduced` has them."""
    if factor == 1:
        return images
    return tuple(None if image is None else _reduced(image, factor) for image in images)


def _reduced(image: PixelArray, factor: int) -> PixelArray:
    height, width = image.shape[0] // factor, image.shape[1] // factor
    whole = image[: height * factor, : width * factor]
    return np.asarray(cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA), np.uint8)


def smoothed(images: Images, sigma: float) -> Images:
    """Images smoothed by a Gaussian of a standard deviation, px; as they are for 0."""
    if sigma == 0.0:
        return images
    return tuple(None if image is None else np.asarray(cv2.GaussianBlur(image, (0, 0), sigma)) for image in images)


def noise_sigma(image: PixelArray) -> float:
    """Standard deviation, grey levels, of an image's white noise, on every third row.

    From the difference of two Laplacians, which planes and straight edges along the axes leave at zero; of that the
    median, which the others leave alone too (J. Immerkaer, "Fast noise variance estimation", 1996).
    """
    return noise_median(image) / (_MASK_GAIN * _MEDIAN_OF_NORMAL)


def look(core: Core, images: Images, times: dict[str, float], windows: Sequence[Records] = ((), ())) -> FrameResult:
    """The core's frame call: the bracket's edges in the windows of each camera, or without any its search."""
    frame = core.process(images[0], images[1] if len(images) > 1 else None, *windows)
    add_frame_times(times, frame)
    return frame


def see(core: Core, images: Images, times: dict[str, float]) -> Views:
    """The edge pixels of the images; None where a camera has none."""
    return tuple(None if image is None else _see(core, camera, image, times) for camera, image in enumerate(images))


def _see(core: Core, camera: int, image: PixelArray, times: dict[str, float]) -> View:
    start = now()
    smoothed = core.smooth(camera, image)
    start = lap(times, "smooth", start)
    bits, direction = core.detect_edges(camera, smoothed)
    start = lap(times, "edges", start)
    bits = core.thin(camera, core.filter_edges(camera, bits))
    start = lap(times, "thin", start)
    # As in the frame call; the stages that follow refuse more than this.
    edgels = core.rectify_edges(camera, bits, direction)[: core.config.max_edgels]
    lap(times, "rectify", start)
    return View(edgels, float(image.mean()), float((image >= _SATURATED_GREY).mean()))
