"""Where in an image the target is, for the faults that aim at it."""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.rig import Rig
from rvdnav.target import Target
from rvdnav.trajectory import Truth


@attrs.frozen
class Region:
    """A box in an image, pixels; [x0, x1) by [y0, y1), and it may reach beyond the image."""

    x0: float
    y0: float
    x1: float
    y1: float

    @property
    def width(self) -> float:
        """Along the rows, px."""
        return self.x1 - self.x0

    @property
    def height(self) -> float:
        """Along the columns, px."""
        return self.y1 - self.y0


def target_region(rig: Rig, target: Target, truth: Truth | None, timestamp_ns: int, camera: int) -> Region:
    """The box around the target's points at the true pose; the middle third of the image where that is unknown."""
    T = None if truth is None else truth.at(timestamp_ns)
    if T is not None:
        points = np.array(list(target.points.values())) @ T[:3, :3].T + T[:3, 3]
        uv = rig.project(camera, points)
        if np.isfinite(uv).all():
            (x0, y0), (x1, y1) = uv.min(axis=0), uv.max(axis=0)
            return Region(float(x0), float(y0), float(x1), float(y1))
    return Region(rig.width / 3.0, rig.height / 3.0, rig.width / 1.5, rig.height / 1.5)
