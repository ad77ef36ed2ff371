"""Settings of the core: the library's defaults with overrides by name."""

from __future__ import annotations

import math
import operator
from typing import TYPE_CHECKING, Any

from rvdnav.core.library import constants, ffi, lib
from rvdnav.core.options import CoreOptions
from rvdnav.core.status import check

if TYPE_CHECKING:
    from typing_extensions import Unpack

_ISA_NAMES = constants("RVDNAV_ISA_")
ISA_NAMES = tuple(_ISA_NAMES.values())


def make_config(**overrides: Unpack[CoreOptions]) -> Any:
    """An rvdnav_config with the host's clock and, unless overridden, the host's choice of instruction set.

    ``isa`` may be a name ("auto", "scalar", "sse2", "avx2", "neon"); the other names are the fields of the C structure.
    Raises TypeError for a setting that doesn't exist, ValueError with its name and range for a value outside of it.
    """
    config = ffi.new("rvdnav_config *")
    config.struct_size = ffi.sizeof("rvdnav_config")
    check(lib.rvdnav_config_default(config))
    isa = ffi.new("int32_t *")
    check(lib.rvdnav_host_isa(isa))
    config.isa = isa[0]
    config.clock = ffi.addressof(lib, "rvdnav_host_clock")
    known = CoreOptions.__annotations__
    for name, value in overrides.items():
        if name not in known:
            raise TypeError(f"the core has no setting {name!r}; it has {', '.join(sorted(known))}")
        setattr(config, name, _isa_code(value) if name == "isa" else _in_range(name, value))
    if not config.range_max > config.range_min:
        raise ValueError(f"range_max = {config.range_max:g} is not above range_min = {config.range_min:g}")
    return config


def _in_range(name: str, value: Any) -> float | int:
    """The value as what the field holds.  Raises ValueError outside the core's range for it."""
    low, high = core_range(name)
    whole = isinstance(low, int)
    try:
        number = operator.index(value) if whole else float(value)
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not low <= number <= high:
        raise ValueError(f"{name} = {value!r} is not {'a whole number' if whole else 'a number'} from {low} to {high}")
    return number


def core_range(name: str) -> tuple[float | int, float | int]:
    """The least and the largest value of a setting other than isa, whole numbers of one that is whole."""
    low, high = ffi.new("double *"), ffi.new("double *")
    check(lib.rvdnav_config_range(name.encode(), low, high))
    whole = dict(ffi.typeof("rvdnav_config").fields)[name].type.cname == "int32_t"
    return (int(low[0]), int(high[0])) if whole else (low[0], high[0])


def isa_name(code: int) -> str:
    """Name of an instruction set by its code."""
    return _ISA_NAMES[code]


def _isa_code(isa: Any) -> int:
    if isinstance(isa, int):
        return isa
    codes = {name: code for code, name in _ISA_NAMES.items()}
    if isa not in codes:
        raise TypeError(f"no instruction set is called {isa!r}; there are {', '.join(sorted(codes))}")
    return codes[isa]
