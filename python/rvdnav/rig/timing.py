"""When the rows of an image are exposed."""

from __future__ import annotations

import numpy as np

from rvdnav.pose.arrays import IntArray

SCANS = ("progressive", "top_field_first", "bottom_field_first")
"""Orders of the rows: one after the other, or in two fields, of which the top one has the rows 0, 2, 4 …"""
LONGEST_NS = 1_000_000_000
"""Longest exposure, and delay of a row or field."""


def row_delays_ns(height: int, scan: str, line_delay_ns: int, field_delay_ns: int) -> IntArray:
    """Middle of each row's exposure (height,) after that of the first row that is exposed, ns.

    line_delay_ns: from a row to the next one of its field.  field_delay_ns: from the first row of the first field to
    the first one of the second.
    """
    rows = np.arange(height, dtype=np.int64)
    in_field, of_second = rows // 2, rows % 2 == (scan == "top_field_first")
    interlaced: IntArray = line_delay_ns * in_field + field_delay_ns * of_second
    return line_delay_ns * rows if scan == "progressive" else interlaced
