"""Writes the cffi module of the preprocessed C header: emit_cdef.py DECLARATIONS MODULE."""

import sys
from pathlib import Path

from cffi import FFI

declarations, module = map(Path, sys.argv[1:])
ffi = FFI()
ffi.cdef(declarations.read_text())
ffi.set_source("rvdnav.core._cdef", None)
ffi.emit_python_code(str(module))
