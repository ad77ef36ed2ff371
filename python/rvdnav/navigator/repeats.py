"""Frozen cameras and frames sent twice: images that were there before."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


class RepeatDetector:
    """Tells when a camera delivers its last image once more.

    No two exposures are alike in every bit, for a sensor has noise.  An image of one grey level is no picture at all
    and doesn't count.
    """

    def __init__(self) -> None:
        self._last: dict[int, NDArray[np.uint8]] = {}

    def repeated(self, images: tuple[NDArray[np.uint8] | None, ...]) -> bool:
        """Whether any camera's image (height, width) equals its last one; they are remembered, as copies."""
        found = False
        for camera, image in enumerate(images):
            if image is None:
                continue
            last = self._last.get(camera)
            if last is None or not np.array_equal(image, last):
                self._last[camera] = image.copy()  # the caller may use its memory again
            elif image.min() != image.max():
                found = True
        return found
