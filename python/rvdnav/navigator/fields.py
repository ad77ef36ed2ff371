"""Interlaced images: told from others by what they show, and taken apart into fields.

The rows of one field were exposed at another time than those of the other, so edges that move along the rows are
displaced in every second row: a comb.  A field by itself is an image of half the rows.
"""

from __future__ import annotations

from typing import Any

import attrs
import cv2
import numpy as np
from numpy.typing import NDArray

from rvdnav.images import PixelArray
from rvdnav.navigator.views import Images
from rvdnav.pose.arrays import FloatArray

# Cubic through four rows of a field, at the middle of the two inner ones.
_CUBIC = np.array([-1.0, 0.0, 9.0, 16.0, 9.0, 0.0, -1.0], np.float32)[:, None] / 16.0
_BINOMIAL = np.array([0.25, 0.5, 0.25])
# Pieces of the image within which all edges move alike: pairs of rows, and columns.
_TILE = (16, 32)
# Where the grey changes by this much a pixel along the rows there is an edge, and by this many such pixels a tile shows
# one.
_STEP = 8.0
_EDGE_PIXELS = 16
# A tile is combed if its rows agree on a displacement by so many standard deviations of it, and it is so large, px.
_AGREEMENT = 3.0
_DISPLACED_PX = 0.08
# Share of the tiles with edges that are combed: without fields (noise, texture), and with them (some edges run along
# the rows or stand still).
_SHARE_WITHOUT, _SHARE_WITH = 0.03, 0.3
_LARGEST_EVIDENCE = 10.0
# Odds from which on images are taken for interlaced, and the most that the frames so far may speak for or against it:
# a target that stands still doesn't take back at once what it has shown in motion.
_INTERLACED = 3.0
_LARGEST_MEMORY = 20.0
# Rows are equal in pairs if they differ by this part of what neighbouring pairs differ by, in this share of them.
_EQUAL = 0.25
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
    present = [image for image in images if image is not None]
    if all(doubled(image) for image in present):
        return Fields(_fields(images, 0), noticed=True), odds
    odds += float(np.mean([combed(image) for image in present]))
    odds = float(np.clip(odds, -_LARGEST_MEMORY, _LARGEST_MEMORY))
    if odds < _INTERLACED:
        return Fields(images), odds
    return Fields(_fields(images, 0), _fields(images, 1), noticed=True), odds


def _fields(images: Images, first_row: int) -> Images:
    return tuple(None if image is None else field(image, first_row) for image in images)


def combed(image: PixelArray) -> float:
    """Logarithm of the odds that an image is interlaced, from its tiles with edges, at most 10 to either side."""
    rows = len(image) // 2 * 2
    grey = image[:rows].astype(np.float32)
    top, bottom = grey[::2], grey[1::2]
    between = cv2.filter2D(top, -1, _CUBIC[::2], anchor=(0, 1), borderType=cv2.BORDER_REPLICATE)
    along = cv2.filter2D(between, -1, np.array([[-0.5, 0.0, 0.5]], np.float32))
    along[np.abs(along) < _STEP] = 0.0
    # A displacement d of the bottom field to the right changes its grey by -d times the slope.
    moved = _by_tile_rows(along * (between - bottom))
    weight = _by_tile_rows(along**2)
    edges = _by_tile_rows((along != 0.0).astype(np.float32)).sum(axis=1)
    total, scatter = moved.sum(axis=1), np.sqrt((moved**2).sum(axis=1))
    shown = edges >= _EDGE_PIXELS
    comb = shown & (np.abs(total) > _AGREEMENT * scatter) & (np.abs(total) > _DISPLACED_PX * weight.sum(axis=1))
    tiles, combs = int(shown.sum()), int(comb.sum())
    odds = combs * np.log(_SHARE_WITH / _SHARE_WITHOUT)
    odds += (tiles - combs) * np.log((1.0 - _SHARE_WITH) / (1.0 - _SHARE_WITHOUT))
    return float(np.clip(odds, -_LARGEST_EVIDENCE, _LARGEST_EVIDENCE))


def doubled(image: PixelArray) -> bool:
    """Whether rows are equal in pairs, from the first one on."""
    rows = len(image) // 2 * 2
    change = np.zeros(rows)
    difference = cv2.absdiff(image[1:rows], image[: rows - 1])
    change[1:] = cv2.reduce(difference, 1, cv2.REDUCE_AVG, dtype=cv2.CV_64F).ravel()
    within, across = change[1::2][:-1], change[2::2]
    changed = across > 0.0
    enough = int(changed.sum()) >= len(across) // 8
    return bool(enough and np.mean(within[changed] < _EQUAL * across[changed]) >= _EQUAL_SHARE)


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


def _by_tile_rows(values: NDArray[Any]) -> FloatArray:
    """(tile rows, rows of a tile, tile columns) sums over the columns of each tile; what fills no tile is left out."""
    height, width = _TILE
    down, across = values.shape[0] // height, values.shape[1] // width
    tiles = values[: down * height, : across * width].reshape(down, height, across, width)
    sums: FloatArray = tiles.sum(axis=3, dtype=np.float64)
    return sums
