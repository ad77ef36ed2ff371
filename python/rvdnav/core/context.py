"""The core's context: calibration, target, settings and work memory, owned from Python."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rvdnav.core.arrays import aligned_block
from rvdnav.core.config import make_config
from rvdnav.core.library import ffi, lib
from rvdnav.core.status import check

if TYPE_CHECKING:  # the binding is below these and imports none of them
    from typing_extensions import Unpack

    from rvdnav.core.options import CoreOptions
    from rvdnav.rig import Rig
    from rvdnav.target import Target


class Context:
    """An rvdnav_context in memory of its own.

    ``target`` is needed for acquisition alone, and used if it is a four-bar bracket.  ``config``: the settings in use,
    with numbers where the core derives them from the rig.  Raises CoreError when the core refuses the rig or target,
    ValueError with the name and range of a setting out of its range.
    """

    def __init__(self, rig: Rig, target: Target | None = None, **config: Unpack[CoreOptions]) -> None:
        self._lent: tuple[int, Any, Any] | None = None
        self.config = make_config(**config)
        self.width = rig.width
        self.height = rig.height
        in_c = c_rig(rig)
        size = ffi.new("size_t *")
        check(lib.rvdnav_context_size(self.config, in_c, size))
        block, self._memory = aligned_block(size[0])
        handle = ffi.new("rvdnav_context **")
        check(lib.rvdnav_context_init(block, size[0], self.config, in_c, c_target(target), handle))
        self.handle = handle[0]
        check(lib.rvdnav_context_config(self.handle, self.config))

    def lend(self, size: int) -> Any:
        """Work memory of so many bytes for one call, the same from call to call."""
        if self._lent is None or self._lent[0] < size:
            self._lent = (size, *aligned_block(size))
        return self._lent[1]

    def set_target(self, target: Target | None) -> None:
        """Another target in place of the present one.  Raises CoreError when the core refuses it."""
        check(lib.rvdnav_context_set_target(self.handle, c_target(target)))


def c_rig(rig: Rig) -> Any:
    """An rvdnav_rig."""
    out = ffi.new("rvdnav_rig *")
    out.struct_size = ffi.sizeof("rvdnav_rig")
    out.width = rig.width
    out.height = rig.height
    out.camera_count = len(rig.cameras)
    out.focal_rect = rig.focal_rect
    out.baseline = rig.baseline if rig.is_stereo else 0.0
    for i, camera in enumerate(rig.cameras):
        in_c = out.camera[i]
        in_c.fx, in_c.fy, in_c.cx, in_c.cy = camera.fx, camera.fy, camera.cx, camera.cy
        in_c.k1, in_c.k2, in_c.p1, in_c.p2 = (float(k) for k in camera.distortion)
        in_c.R_rect_cam = np.asarray(rig.R_rect_cam(i), np.float64).ravel().tolist()
    return out


def c_target(target: Target | None) -> Any:
    """An rvdnav_target, or a null pointer without a target or for one that is no four-bar bracket."""
    bracket = None if target is None else target.bracket
    if bracket is None:
        return ffi.NULL
    out = ffi.new("rvdnav_target *")
    out.struct_size = ffi.sizeof("rvdnav_target")
    out.outer = bracket.outer.tolist()
    out.inner = bracket.inner.tolist()
    out.thickness = bracket.thickness
    return out
