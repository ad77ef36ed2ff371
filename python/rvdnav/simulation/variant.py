"""Mitsuba, the path tracer: found, and set to the fastest variant that works here."""

from __future__ import annotations

import ctypes
import os
from typing import Any

from rvdnav.extras import needs_extra

_LLVM = "llvm_ad_mono"
_SCALAR = "scalar_rgb"
# Mitsuba aborts with older ones, so it must not find them by itself.
_LIBRARIES = [f"libLLVM.so.{version}.1" for version in range(22, 18, -1)]
_LIBRARY_VARIABLE = "DRJIT_LIBLLVM_PATH"


def usable_variant() -> str:
    """`llvm_ad_mono` where an LLVM library of version 19 or later loads, else `scalar_rgb`, which is slower.

    The path in DRJIT_LIBLLVM_PATH is trusted; otherwise it is set to the library found.
    """
    if _LIBRARY_VARIABLE in os.environ:
        return _LLVM
    for library in _LIBRARIES:
        try:
            ctypes.CDLL(library)
        except OSError:
            continue
        os.environ[_LIBRARY_VARIABLE] = library
        return _LLVM
    return _SCALAR


def load_mitsuba(variant: str | None = None) -> Any:
    """The module `mitsuba` in a variant, by default the usable one.  Raises InputError when it is not installed."""
    wanted = variant or usable_variant()
    with needs_extra("sim", "rendering"):
        import mitsuba
    mitsuba.set_variant(wanted)
    return mitsuba


def renderer_name(mitsuba: Any) -> str:
    """Version and variant, such as "mitsuba 3.9.1 llvm_ad_mono"."""
    return f"mitsuba {mitsuba.__version__} {mitsuba.variant()}"
