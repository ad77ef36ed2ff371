"""The edge pixels that the core sees in an image."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rvdnav.core import Core


def edge_mask(core: Core, camera: int, image: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """(h, w) mask of the thinned edges of one camera's image, by the core's own stages."""
    from rvdnav.core import unpack_edges

    bits, _ = core.detect_edges(camera, core.smooth(camera, image))
    return unpack_edges(core.thin(camera, core.filter_edges(camera, bits)), image.shape[1])
