"""Binding of the C core: its stages and its frame call on numpy arrays."""

from rvdnav.core.calibration import LineEffect
from rvdnav.core.core import Core
from rvdnav.core.layout import BAR, EDGE_SAMPLE, EDGEL, LINE, MATCH, PEAK, SEEN_EDGE, SEGMENT, WINDOW
from rvdnav.core.library import LIBRARY_PATH
from rvdnav.core.measurement import Errors, RowMotion, TargetEdges, measure_pose
from rvdnav.core.pictures import FieldSigns, digest, field_signs, noise_median
from rvdnav.core.results import Bracket, FrameResult, ViewResult
from rvdnav.core.stages import unpack_edges

__all__ = [
    "BAR",
    "EDGEL",
    "EDGE_SAMPLE",
    "LIBRARY_PATH",
    "LINE",
    "MATCH",
    "PEAK",
    "SEEN_EDGE",
    "SEGMENT",
    "WINDOW",
    "Bracket",
    "Core",
    "Errors",
    "FieldSigns",
    "FrameResult",
    "LineEffect",
    "RowMotion",
    "TargetEdges",
    "ViewResult",
    "digest",
    "field_signs",
    "measure_pose",
    "noise_median",
    "unpack_edges",
]
