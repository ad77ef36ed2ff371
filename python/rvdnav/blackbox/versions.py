"""Which software recorded a black box: what has to be the same, and what may change the last bits."""

from __future__ import annotations

import platform
from pathlib import Path
from typing import Any

import numpy as np

from rvdnav import __version__
from rvdnav.core.library import lib
from rvdnav.errors import InputError

_REQUIRED = ("format", "rvdnav", "core_abi")
_FORMAT = 1
"""Of the black box's files."""


def versions() -> dict[str, Any]:
    """Of what runs now.  The first three must be those of the record; the others hold libm and BLAS."""
    return {
        "format": _FORMAT,
        "rvdnav": __version__,
        "core_abi": int(lib.RVDNAV_ABI_VERSION),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "machine": platform.machine(),
    }


def check_versions(path: Path, recorded: Any) -> None:
    """Raise InputError naming the file unless what recorded it is what runs now."""
    now = versions()
    if not isinstance(recorded, dict) or not all(key in recorded for key in _REQUIRED):
        raise InputError(f"{path}: doesn't tell the versions that recorded it")
    if any(recorded[key] != now[key] for key in _REQUIRED):
        raise InputError(f"{path}: was recorded by {_named(recorded)} and cannot be replayed by {_named(now)}")


def other_surroundings(recorded: dict[str, Any]) -> list[str]:
    """In words, what around the package is not as it was and may account for different bits."""
    now = versions()
    keys = [key for key in now if key not in _REQUIRED and recorded.get(key) != now[key]]
    return [f"recorded with {key} {recorded.get(key)}, replayed with {now[key]}" for key in keys]


def _named(given: dict[str, Any]) -> str:
    return f"rvdnav {given['rvdnav']} (core ABI {given['core_abi']}, black box format {given['format']})"
