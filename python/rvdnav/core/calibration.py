"""What the calibration's errors do to measured lines."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from rvdnav.core import layout
from rvdnav.core.arrays import pointer
from rvdnav.core.context import c_rig
from rvdnav.core.library import ffi, lib
from rvdnav.core.status import check

if TYPE_CHECKING:  # the binding is below this and imports none of it
    from rvdnav.rig import Rig

FloatArray = NDArray[np.float64]


class LineEffect:
    """Derivatives of a rig's rectified views with respect to p parameters of its calibration, for lines seen in them.

    shift (cameras, 144, 2, p): of the rectified coordinates, px, of a raw pixel, as coefficients of products of
    Chebyshev polynomials of degrees up to 11 of the column and of the row, scaled to [-1, 1].  focal (p,): of the
    rectified focal length, px.  centers (cameras, 3, p): of the cameras' centres, m, rectified axes.
    """

    def __init__(self, rig: Rig, shift: FloatArray, focal: FloatArray, centers: FloatArray) -> None:
        self._rig = c_rig(rig)
        self._arrays = [np.ascontiguousarray(values, np.float64) for values in (shift, focal, centers)]
        self.in_c = ffi.new("rvdnav_calibration_effect *")
        self.in_c.struct_size = ffi.sizeof("rvdnav_calibration_effect")
        self.in_c.parameters = len(focal)
        for name, values in zip(("shift", "focal", "centers"), self._arrays, strict=True):
            setattr(self.in_c, name, pointer(values, "double *"))

    def derivatives(self, camera: NDArray[Any], rho: FloatArray, theta: FloatArray, ends: FloatArray) -> FloatArray:
        """(n, 2, p) of the distances, px, of edges' projected ends from their lines.

        camera (n,); rho (n,), px, and theta (n,): of the measured lines; ends (n, 2, 3): of their edges, rectified axes
        from the camera's centre, m.  Raises CoreError for an end that is not in front of its camera.
        """
        lines = np.empty(len(rho), layout.MEASURED_LINE)
        lines["camera"], lines["rho"], lines["theta"], lines["ends"], lines["reserved"] = camera, rho, theta, ends, 0
        out = np.empty((len(lines), 2, self.in_c.parameters))
        args = pointer(lines, "rvdnav_measured_line *"), len(lines), pointer(out, "double *")
        check(lib.rvdnav_calibration_derivatives(self._rig, self.in_c, *args))
        return out
