"""From status codes to exceptions."""

from __future__ import annotations

from rvdnav.core.library import ffi, lib
from rvdnav.errors import CoreError


def check(status: int) -> None:
    """Raises CoreError unless status is 0."""
    if status != lib.RVDNAV_OK:
        raise CoreError(status, ffi.string(lib.rvdnav_status_text(status)).decode())
