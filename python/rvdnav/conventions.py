"""What every part of the package agrees on: exact timestamps and what counts as a rigid transform.

The frames, the rotations and the order of a covariance are stated in docs/conventions.md.
"""

from __future__ import annotations

import itertools
import re
import statistics
from collections.abc import Sequence
from decimal import Decimal, localcontext
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from rvdnav.pose.arrays import FloatArray, float_array
from rvdnav.pose.so3 import make_T, project_to_so3

ROTATION_TOLERANCE = 1e-6
"""Largest deviation of an element of R Rᵀ from the identity that still counts as rounding."""


class TimestampUnit(NamedTuple):
    """A unit of time: its name in the plural, and how many nanoseconds it has."""

    name: str
    ns: int


NANOSECONDS = TimestampUnit("nanoseconds", 1)
_OTHER_UNITS = (
    TimestampUnit("microseconds", 10**3),
    TimestampUnit("milliseconds", 10**6),
    TimestampUnit("seconds", 10**9),
)
_USUAL_GAPS_NS = (10**6, 5 * 10**9)
_LEAST_GAP_NS = 10**5
_UNIX_TIMES_S = (10**8, 4_102_444_800)
_DECIMAL = re.compile(r"[+-]?[0-9]+(\.[0-9]*)?([eE][+-]?[0-9]{1,3})?")
_INT64_MAX = 2**63 - 1


def parse_timestamp_s(text: str) -> int:
    """Timestamp in ns of a decimal number of seconds, such as "1700000000.125" or "1.700000000125e+09".

    It never passes through a float, whose steps are 238 ns today; digits beyond the ninth are rounded.
    Raises ValueError unless the text is such a number, not negative and within int64 nanoseconds.
    """
    if _DECIMAL.fullmatch(text) is None:
        raise ValueError(f"{text!r} is not a timestamp in seconds")
    with localcontext() as context:
        context.prec = len(text) + 1100  # exact for any exponent that the pattern lets through
        ns = int((Decimal(text) * 10**9).to_integral_value())
    if not 0 <= ns <= _INT64_MAX:
        raise ValueError(f"timestamp {text} s is outside the range of int64 nanoseconds")
    return ns


def parse_timestamp_ns(text: str) -> int:
    """Timestamp in ns of a whole number of nanoseconds.  Raises ValueError like `parse_timestamp_s`."""
    if re.fullmatch("[0-9]+", text) is None:
        raise ValueError(f"{text!r} is not a timestamp in whole nanoseconds")
    ns = int(text)
    if ns > _INT64_MAX:
        raise ValueError(f"timestamp {text} ns is outside the range of int64")
    return ns


def timestamp_unit(stamps: Sequence[int]) -> TimestampUnit:
    """The unit in which whole numbers, at least one and increasing, are the times of a camera's images.

    The one of microseconds, milliseconds and seconds in which they are Unix times of the years 1973 to 2099 and the
    images lie a millisecond to 5 s apart, by the median.  Else nanoseconds, if the images then lie 0.1 ms apart or
    more, or if there is one alone.  Raises ValueError where none fits.
    """
    gap = statistics.median(after - before for before, after in itertools.pairwise(stamps)) if len(stamps) > 1 else None
    if gap is None:
        return NANOSECONDS
    for unit in _OTHER_UNITS:
        dated = _UNIX_TIMES_S[0] <= stamps[0] * unit.ns // 10**9 < _UNIX_TIMES_S[1]
        if dated and _USUAL_GAPS_NS[0] <= gap * unit.ns <= _USUAL_GAPS_NS[1]:
            return unit
    if gap >= _LEAST_GAP_NS:
        return NANOSECONDS
    raise ValueError(
        f"by their stamps the images lie {gap:g} ns apart; stamps are whole nanoseconds, or Unix time in whole "
        "microseconds, milliseconds or seconds"
    )


def format_timestamp_s(timestamp_ns: int) -> str:
    """The inverse of `parse_timestamp_s`: seconds with nine decimals; timestamp_ns must not be negative."""
    seconds, ns = divmod(int(timestamp_ns), 10**9)
    return f"{seconds}.{ns:09d}"


def rigid_transform(values: ArrayLike) -> FloatArray:
    """`values` as a read-only transform (4, 4) in SE(3), its rotation freed from rounding.

    Raises ValueError as `check_rigid` does.
    """
    T = float_array(values, 4, 4)
    check_rigid(T)
    T = make_T(project_to_so3(T[:3, :3]), T[:3, 3])
    T.setflags(write=False)
    return T


def check_rigid(values: ArrayLike) -> None:
    """Raise ValueError unless a matrix (4, 4) is a transform in SE(3).

    Its numbers are finite, its last row is 0 0 0 1, and the rest holds a rotation, orthonormal to `ROTATION_TOLERANCE`
    and right-handed.
    """
    T = float_array(values, 4, 4)
    if not np.array_equal(T[3], (0.0, 0.0, 0.0, 1.0)):
        raise ValueError("the last row is not 0 0 0 1")
    R = T[:3, :3]
    with np.errstate(over="ignore", invalid="ignore"):
        deviation = float(np.abs(R @ R.T - np.eye(3)).max())
    if not deviation <= ROTATION_TOLERANCE:
        raise ValueError(f"the rotation is none: R Rᵀ differs from the identity by {deviation:.1e}")
    if np.linalg.det(R) < 0.0:
        raise ValueError("the rotation is none: it mirrors (determinant -1)")
