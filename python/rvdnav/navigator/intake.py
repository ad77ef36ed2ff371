"""Which of a frame's images are new: frozen cameras and frames sent twice show what was there before."""

from __future__ import annotations

from rvdnav.core import digest
from rvdnav.images import PixelArray
from rvdnav.navigator.views import Images
from rvdnav.sequence import Frame
from rvdnav.solution import Reason

Digests = tuple[bytes | None, ...]
"""Of each camera's last image, None where there was none."""

_MISSING = (Reason.LEFT_MISSING, Reason.RIGHT_MISSING)


def take_in(frame: Frame, last: Digests) -> tuple[Images, frozenset[Reason], Digests]:
    """The images of the cameras that have a digest, None for those that are missing or were there before; why; and the
    digests to compare the next frame with."""
    images: list[PixelArray | None] = []
    reasons: set[Reason] = set()
    digests = list(last)
    for camera, image in enumerate((frame.left, frame.right)[: len(last)]):
        images.append(None)
        if image is None:
            reasons.add(_MISSING[camera])
            continue
        # No two exposures are alike in every bit, for a sensor has noise.
        digests[camera] = digest(image.pixels)
        if digests[camera] == last[camera] and _is_picture(image.pixels):
            reasons.add(Reason.DUPLICATE)
            continue
        images[camera] = image.pixels
    return tuple(images), frozenset(reasons), tuple(digests)


def _is_picture(image: PixelArray) -> bool:
    """Whether an image has more than one grey level; one without, all black or all white, may well come again."""
    return bool(image.min() != image.max())
