"""Interlaced images: told from others by what they show, and taken apart into fields.

The rows of one field were exposed at another time than those of the other, so edges that move along the rows are
displaced in every second row: a comb.  A field by itself is an image of half the rows.
"""

from __future__ import annotations

import attrs
import cv2
import numpy as np

from rvdnav.core import FieldSigns, field_signs
from rvdnav.images import PixelArray
from rvdnav.navigator.views import Images

_BINOMIAL = np.array([0.25, 0.5, 0.25])
# Share of the tiles with edges that are combed: without fields (noise, texture), and with them (some edges run along
# the rows or stand still).
_SHARE_WITHOUT, _SHARE_WITH = 0.03, 0.3
_LARGEST_EVIDENCE = 10.0
# Odds from which on images are taken for interlaced, and the most that the frames so far may speak for or against it:
# a target that stands still doesn't take back at once what it has shown in motion.
_INTERLACED = 3.0
_LARGEST_MEMORY = 20.0
# Rows are equal in pairs if they are nearly so in this share of the pairs.
_EQUAL_SHARE = 0.9


@attrs.frozen(eq=False)
class Fields:
    """What of a frame's images is measured.

    first: the images, or their fields that were exposed at the stamp.  second: the other fields, where either may have
    been.  noticed: the images are interlaced though nobody said so.
    """

    first: Images
    second: Images | None = None
    noticed: bool = False


def declared_fields(images: Images, scan: str) -> Fields:
    """Of images whose scan is interlaced: the field that was exposed first, which the stamp is of."""
    return Fields(_fields(images, int(scan == "bottom_field_first")))


def noticed_fields(images: Images, odds: float) -> tuple[Fields, float]:
    """Of images that nobody said to be interlaced, with the logarithm of the odds for it from earlier frames; that
    with these images.  One of them must be there."""
    signs = [None if image is None else field_signs(image) for image in images]
    is_doubled = [sign is not None and doubled(sign) for sign in signs]
    if any(is_doubled):
        single = tuple(field(i, 0) if i is not None and d else i for i, d in zip(images, is_doubled, strict=True))
        return Fields(single, noticed=True), odds
    odds += float(np.mean([comb_odds(sign) for sign in signs if sign is not None]))
    odds = float(np.clip(odds, -_LARGEST_MEMORY, _LARGEST_MEMORY))
    if odds < _INTERLACED:
        return Fields(images), odds
    return Fields(_fields(images, 0), _fields(images, 1), noticed=True), odds


def _fields(images: Images, first_row: int) -> Images:
    return tuple(None if image is None else field(image, first_row) for image in images)


def comb_odds(signs: FieldSigns) -> float:
    """Logarithm of the odds that an image is interlaced, from its tiles with edges, at most 10 to either side."""
    odds = signs.combed * np.log(_SHARE_WITH / _SHARE_WITHOUT)
    odds += (signs.tiles - signs.combed) * np.log((1.0 - _SHARE_WITH) / (1.0 - _SHARE_WITHOUT))
    return float(np.clip(odds, -_LARGEST_EVIDENCE, _LARGEST_EVIDENCE))


def doubled(signs: FieldSigns) -> bool:
    """Whether rows are equal in pairs, from the first one on."""
    enough = signs.changed_pairs >= signs.row_pairs // 8
    return enough and signs.equal_pairs >= _EQUAL_SHARE * signs.changed_pairs > 0.0


def field(image: PixelArray, first_row: int) -> PixelArray:
    """The field of the rows first_row, first_row + 2, …; the rows between them by a cubic through their neighbours, all
    smoothed down the columns by (1 2 1)/4: half the rows alias what is fine."""
    own = image[first_row::2]
    above = cv2.copyMakeBorder(own, 2, 2, 0, 0, cv2.BORDER_REPLICATE).astype(np.int16)
    n = len(own)
    between = (9 * (above[1 : n + 2].astype(np.int32) + above[2 : n + 3]) - above[: n + 1] - above[3 : n + 4] + 8) >> 4
    filled = np.clip(between, 0, 255).astype(np.uint8)  # filled[k] lies before own[k]
    whole: PixelArray = np.empty_like(image)
    whole[first_row::2] = own
    missing = whole[1 - first_row :: 2]
    missing[:] = filled[1 - first_row :][: len(missing)]
    smoothed = cv2.sepFilter2D(whole, -1, np.ones(1), _BINOMIAL, borderType=cv2.BORDER_REPLICATE)
    return np.asarray(smoothed, np.uint8)
