"""Reports: HTML pages of a run and of a reconstruction, which need no network."""

from rvdnav.report.cloud import write_cloud_report
from rvdnav.report.edges import edge_mask
from rvdnav.report.provenance import provenance
from rvdnav.report.run import write_report
from rvdnav.report.strip import Picture, draw_picture
from rvdnav.report.verdict import notable_frames

__all__ = [
    "Picture",
    "draw_picture",
    "edge_mask",
    "notable_frames",
    "provenance",
    "write_cloud_report",
    "write_report",
]
