"""The paper's experiment repeated: its figures 9 to 14, and its claims about edge detection and thinning.

Rendering the run needs the extra `rvdnav[sim]`, the comparison of thinnings `rvdnav[experiment]`.
"""

from rvdnav.experiment.paper import REPORT, Run, navigate, write_paper_report
from rvdnav.experiment.sobel import EdgeTrial, compare_edges
from rvdnav.experiment.thinning import Thinning, compare_thinning

__all__ = [
    "REPORT",
    "EdgeTrial",
    "Run",
    "Thinning",
    "compare_edges",
    "compare_thinning",
    "navigate",
    "write_paper_report",
]
