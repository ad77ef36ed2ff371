"""Everything that the navigator carries from one frame to the next."""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.conventions import check_rigid
from rvdnav.navigator.knowledge import Learned
from rvdnav.navigator.sizes import Sizes
from rvdnav.pose import FilterState
from rvdnav.pose.arrays import FloatArray, IntArray, float_array
from rvdnav.solution import State


@attrs.frozen(eq=False)
class Memory:
    """A navigator's memory; with it and the next frame the next solution is determined to the last bit.

    filter_state: of the constant-velocity filter, None before the first pose.  last_frame_ns: stamp of the newest
    frame, last_pose_ns of the last published one.  polarity (cameras, edges): of the edges as last published, see
    `Measurement.polarity`.  image_digests: of each camera's last image, None where there was none.  held_odds: while
    one view leaves two poses and neither is published, the filter follows the likelier; the logarithm of its odds.
    lasting_part (6, 6): of the last published covariance, what errs alike in all frames.  initial_pose (4, 4): given
    by the caller, until a pose is published or the target lost.  learned: of the lasting errors of target and rig.
    sizes: of a target of unknown size, None before it was first seen.  interlaced: logarithm of the odds that the
    images are, by the frames so far.
    """

    state: State
    filter_state: FilterState | None
    last_frame_ns: int | None
    last_pose_ns: int
    polarity: IntArray
    image_digests: tuple[bytes | None, ...]
    lasting_part: FloatArray
    learned: Learned
    held_odds: float | None = None
    initial_pose: FloatArray | None = None
    sizes: Sizes | None = None
    interlaced: float = 0.0

    @classmethod
    def blank(cls, cameras: int, edges: int, lasting: int) -> Memory:
        """Of a navigator that has seen nothing yet; lasting: how many parameters it learns."""
        unknown = np.zeros((cameras, edges), np.int64)
        learned = Learned.nothing(lasting)
        return cls(State.SEARCHING, None, None, 0, unknown, (None,) * cameras, np.zeros((6, 6)), learned)

    def check_fits(self, cameras: int, edges: int, lasting: int) -> None:
        """Raise ValueError unless its arrays are those of a navigator with so many cameras, edges and lasting
        parameters, and finite."""
        blank = Memory.blank(cameras, edges, lasting)
        if self.polarity.shape != blank.polarity.shape or len(self.image_digests) != cameras:
            raise ValueError("is of another number of cameras or edges")
        float_array(self.lasting_part, 6, 6)
        float_array(self.learned.information, lasting, lasting)
        float_array(self.learned.vector, lasting)
        float_array(self.learned.scales, len(blank.learned.scales))
        if self.initial_pose is not None:
            check_rigid(self.initial_pose)
        if self.filter_state is not None:
            check_rigid(self.filter_state.T)
            float_array(self.filter_state.velocity, 6)
            float_array(self.filter_state.covariance, 12, 12)
        if self.sizes is not None:
            float_array(self.sizes.vector, 6)
            for matrix in (self.sizes.information, self.sizes.common):
                float_array(matrix, 6, 6)
