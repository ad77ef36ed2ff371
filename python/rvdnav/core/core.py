"""The frame call."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rvdnav.core import layout
from rvdnav.core.arrays import Records, image_argument, pointer, records
from rvdnav.core.config import isa_name
from rvdnav.core.library import ffi, lib
from rvdnav.core.results import FrameResult, frame_result
from rvdnav.core.stages import Stages
from rvdnav.core.status import check

if TYPE_CHECKING:  # the binding is below these and imports none of them
    from typing_extensions import Unpack

    from rvdnav.core.options import CoreOptions
    from rvdnav.rig import Rig
    from rvdnav.target import Target


class Core(Stages):
    """The C core for one rig and target: the frame call and every stage by itself.

    Settings are the fields of rvdnav_config by name.  The views of a frame are processed on two threads, without the
    interpreter's lock.  One instance serves one thread at a time.
    """

    def __init__(self, rig: Rig, target: Target | None = None, **config: Unpack[CoreOptions]) -> None:
        super().__init__(rig, target, **config)
        runner = ffi.new("rvdnav_runner **")
        check(lib.rvdnav_runner_create(runner))
        self._T_world_core = _world_of_core(rig)
        self._runner = ffi.gc(runner[0], lib.rvdnav_runner_destroy)
        self._result = ffi.new("rvdnav_frame_result *")
        self._result.struct_size = ffi.sizeof("rvdnav_frame_result")

    @property
    def isa(self) -> str:
        """The instruction set in use: "scalar", "sse2", "avx2" or "neon"."""
        return isa_name(lib.rvdnav_context_isa(self.handle))

    def process(
        self,
        left: NDArray[np.uint8] | None,
        right: NDArray[np.uint8] | None,
        windows_left: Records = (),
        windows_right: Records = (),
    ) -> FrameResult:
        """One frame: images (h, w) or None, and the windows of Hough space (WINDOW records) where edges are expected.

        Without any window the bracket is acquired.  Raises CoreError when the core refuses the call, ValueError for an
        image that isn't 8-bit grey.
        """
        c_left, _keep_left = (ffi.NULL, None) if left is None else image_argument(left)
        c_right, _keep_right = (ffi.NULL, None) if right is None else image_argument(right)
        expected_left = records(windows_left, layout.WINDOW)
        expected_right = records(windows_right, layout.WINDOW)
        windows = (
            pointer(expected_left, "rvdnav_window *"),
            len(expected_left),
            pointer(expected_right, "rvdnav_window *"),
            len(expected_right),
        )
        check(lib.rvdnav_runner_process(self._runner, self.handle, c_left, c_right, *windows, self._result))
        record = np.frombuffer(ffi.buffer(self._result), layout.FRAME_RESULT)[0]
        acquired = len(expected_left) + len(expected_right) == 0
        return frame_result(record, (left is not None, right is not None), acquired, self._T_world_core)


def _world_of_core(rig: Rig) -> NDArray[np.float64]:
    """Maps the core's world to W: the same with two cameras.  With one camera W lies where its file says, while the
    core's world has its origin in the camera's centre and the axes z, y, -x of the rectified frame."""
    T = np.eye(4)
    if not rig.is_stereo:
        R_rect_core = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
        T[:3, :3] = rig.R_world_rect @ R_rect_core
        T[:3, 3] = rig.T_world_cam[0][:3, 3]
    return T
