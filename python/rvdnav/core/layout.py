"""numpy dtypes of the C structures, taken from the library's own layout."""

from __future__ import annotations

from typing import Any

import numpy as np

from rvdnav.core.library import ffi


def _field_dtype(kind: Any) -> Any:
    if kind.kind == "array":
        shape = []
        while kind.kind == "array":
            shape.append(kind.length)
            kind = kind.item
        return (_field_dtype(kind), tuple(shape))
    if kind.kind == "struct":
        return struct_dtype(kind.cname)
    code = "f" if kind.cname in ("float", "double") else "u" if kind.cname.startswith("u") else "i"
    return np.dtype(f"{code}{ffi.sizeof(kind)}")


def struct_dtype(name: str) -> np.dtype[np.void]:
    """Structured dtype with the fields, offsets and size of the C structure."""
    fields = ffi.typeof(name).fields
    return np.dtype(
        {
            "names": [field for field, _ in fields],
            "formats": [_field_dtype(info.type) for _, info in fields],
            "offsets": [info.offset for _, info in fields],
            "itemsize": ffi.sizeof(name),
        }
    )


EDGEL = struct_dtype("rvdnav_edgel")
PEAK = struct_dtype("rvdnav_peak")
SEGMENT = struct_dtype("rvdnav_segment")
BAR = struct_dtype("rvdnav_bar")
WINDOW = struct_dtype("rvdnav_window")
LINE = struct_dtype("rvdnav_line")
MODEL_EDGE = struct_dtype("rvdnav_model_edge")
SEEN_EDGE = struct_dtype("rvdnav_seen_edge")
EDGE_COVERAGE = struct_dtype("rvdnav_edge_coverage")
EDGE_SAMPLE = struct_dtype("rvdnav_edge_sample")
MEASURED_LINE = struct_dtype("rvdnav_measured_line")
EDGE_POINT = struct_dtype("rvdnav_edge_point")
EDGE_LINE = struct_dtype("rvdnav_edge_line")
POSE_LINE = struct_dtype("rvdnav_pose_line")
EDGE_EVIDENCE = struct_dtype("rvdnav_edge_evidence")
MATCH = struct_dtype("rvdnav_match")
SURFACE_POINT = struct_dtype("rvdnav_surface_point")
VIEW_RESULT = struct_dtype("rvdnav_view_result")
FRAME_RESULT = struct_dtype("rvdnav_frame_result")
