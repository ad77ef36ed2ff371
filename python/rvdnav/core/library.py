"""The shared library, loaded once and checked against the header that this package was built with."""

from __future__ import annotations

from pathlib import Path
from typing import Any

try:
    import rvdnav.core._cdef as _cdef
except ImportError as error:
    raise ImportError("rvdnav's C core is not built: install the package (pip install .)") from error

LIBRARY_PATH = Path(_cdef.__file__).with_name("librvdnav.so")


_OPAQUE = {"rvdnav_context", "rvdnav_runner"}


def _struct_names(ffi: Any) -> list[str]:
    """Structures that the header lays out."""
    names = [name for name in ffi.list_types()[0] if name.startswith("rvdnav_") and name not in _OPAQUE]
    return sorted(name for name in names if ffi.typeof(name).kind == "struct")


def load(path: Path) -> tuple[Any, Any]:
    """Opens the library at path; returns (ffi, lib).

    Raises ImportError when it can't be loaded or was built from another header.
    """
    ffi = _cdef.ffi
    try:
        lib = ffi.dlopen(str(path))
        version = lib.rvdnav_abi_version()
        struct_size = lib.rvdnav_struct_size
    except (OSError, AttributeError) as error:
        raise ImportError(f"cannot load rvdnav's C core: {error}") from error
    if version != lib.RVDNAV_ABI_VERSION:
        raise ImportError(f"{path} has ABI version {version}, this package needs {lib.RVDNAV_ABI_VERSION}: rebuild it")
    for name in _struct_names(ffi):
        if struct_size(name.encode()) != ffi.sizeof(name):
            raise ImportError(f"{path} lays out {name} differently from this package: rebuild it")
    return ffi, lib


ffi, lib = load(LIBRARY_PATH)


def constants(prefix: str) -> dict[int, str]:
    """Values of the header's constants with this prefix, to the rest of their names in lower case."""
    return {getattr(lib, name): name[len(prefix) :].lower() for name in dir(lib) if name.startswith(prefix)}
