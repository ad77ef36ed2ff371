"""What the core tells of images before any stage: whether they are new, how noisy, and of fields."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.core.arrays import image_argument
from rvdnav.core.library import ffi, lib
from rvdnav.core.status import check


@attrs.frozen
class FieldSigns:
    """What tells an image (h, w) of two fields from others.

    tiles: of 32 columns and 32 rows, with edges.  combed: of them, with odd rows displaced against the even ones, all
    alike.  row_pairs: an even row with the next one, but for the last pair.  changed_pairs: of them, those that the
    next pair differs from, somewhere by 8 or more.  equal_pairs: of those, within which there is less than a quarter of
    that difference there.
    """

    tiles: int
    combed: int
    row_pairs: int
    changed_pairs: int
    equal_pairs: int


def digest(image: NDArray[np.uint8]) -> bytes:
    """Eight bytes that another image has as good as never, however little it differs."""
    c_image, _keep = image_argument(image)
    out = ffi.new("uint64_t *")
    check(lib.rvdnav_image_digest(c_image, out))
    return int(out[0]).to_bytes(8, "little")


def noise_median(image: NDArray[np.uint8]) -> float:
    """Median, grey levels, of the absolute values of (1 -2 1)^T (1 -2 1) on every third row."""
    c_image, _keep = image_argument(image)
    out = ffi.new("uint32_t *")
    check(lib.rvdnav_noise_median(c_image, out))
    return 0.5 * float(out[0])


def field_signs(image: NDArray[np.uint8]) -> FieldSigns:
    """Of an image that may be interlaced."""
    c_image, _keep = image_argument(image)
    out = ffi.new("rvdnav_fields *")
    out.struct_size = ffi.sizeof("rvdnav_fields")
    check(lib.rvdnav_find_fields(c_image, out))
    return FieldSigns(out.tiles, out.combed, out.row_pairs, out.changed_pairs, out.equal_pairs)
