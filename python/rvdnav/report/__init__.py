"""Reports: self-contained HTML pages, of a run and of a reconstruction."""

from rvdnav.report.cloud import write_cloud_report
from rvdnav.report.edges import edge_mask
from rvdnav.report.run import write_report
from rvdnav.report.strip import Picture, draw_picture, strip_indices

__all__ = ["Picture", "draw_picture", "edge_mask", "strip_indices", "write_cloud_report", "write_report"]
