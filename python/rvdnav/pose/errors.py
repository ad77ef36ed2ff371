"""The one exception of the pose mathematics."""

from __future__ import annotations

from rvdnav.errors import RvdnavError


class PoseError(RvdnavError):
    """A pose that the given geometry does not determine, or an estimate asked for where none can exist."""
