"""From a stereo frame to points in W, each with its standard deviation."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.core import Core
from rvdnav.pose.arrays import FloatArray

UNMATCHED = (
    "the other zero crossings have no match to rely on: one camera alone sees them, they lie outside the range, or "
    "several in the right image are much alike"
)
_Q8 = 256.0
_Q15 = 32768.0


@attrs.frozen(eq=False)
class Cloud:
    """n points of the visible surface, row by row of the rectified left view."""

    points_W: FloatArray
    """(n, 3), m in W."""
    sigma: FloatArray
    """(n,) standard deviation of each along the left camera's ray, m; across the ray it is next to none."""
    grey: NDArray[np.uint8]
    """(n,) grey level of the left view there."""
    left: FloatArray
    """(n, 2) rectified px of the left view."""
    disparity: FloatArray
    """(n,) px, x_left - x_right."""
    sigma_disparity: FloatArray
    """(n,) px."""
    score: FloatArray
    """(n,) correlation of the grey windows in both views, -1 .. 1."""
    crossings: int
    """Zero crossings of the left view; those that are no points found no match to rely on in the right one."""

    def __len__(self) -> int:
        return len(self.points_W)

    @property
    def depth(self) -> FloatArray:
        """(n,) x_W, the distance forward of the baseline, m."""
        depth: FloatArray = self.points_W[:, 0]
        return depth


def reconstruct(core: Core, left: NDArray[np.uint8], right: NDArray[np.uint8]) -> Cloud:
    """The surface that both images (h, w) show: zero crossings of the Laplacian of Gaussian, matched coarse to fine.

    ``core`` is of the stereo rig; its settings match_min_score_q8, match_uniqueness_q8, match_max_gradient_q8,
    match_half_window, range_min, range_max and edge_floor hold.  An edge along the epipolar rows has no disparity and
    gives no points.  sigma covers the noise and what the views differ by, not the calibration.

    Raises CoreError for a rig of one camera or images of another size.
    """
    found, crossings = core.surface(left, right)
    return Cloud(
        points_W=np.array(found["p_W"]),
        sigma=np.array(found["sigma"]),
        grey=found["grey"].astype(np.uint8),
        left=np.column_stack([found["x_q8"], found["y_q8"]]) / _Q8,
        disparity=found["disparity_q8"] / _Q8,
        sigma_disparity=np.array(found["sigma_disparity"]),
        score=found["score_q15"] / _Q15,
        crossings=crossings,
    )
