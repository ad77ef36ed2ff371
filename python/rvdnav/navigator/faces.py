"""The even faces that the target's edges bound, as they are seen in the views."""

from __future__ import annotations

import numpy as np

from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import edge_normals, project_edges
from rvdnav.pose import RectifiedCameras
from rvdnav.pose.arrays import FloatArray

# Blur up to which an image is sharp, px.
_SHARP_PX = 1.05


def face_widths(cameras: RectifiedCameras, T_world_target: FloatArray, model: EdgeModel) -> FloatArray:
    """(cameras, edges) of a bracket's front edges the width of their bar, px, positive where it lies
    towards the normal (-dy, dx) of the edge's projection, negative where away from it; else 0.

    Raises PoseError for a target that is not in front of the cameras.
    """
    count = len(cameras.centers)
    if model.bracket is None:
        return np.zeros((count, len(model)))
    return np.stack(
        [_bar_widths(project_edges(cameras, k, T_world_target, model.edge_points)[0]) for k in range(count)]
    )


def _bar_widths(xy: FloatArray) -> FloatArray:
    """How far (m,) the bar's other edge is from each of the edges (m, 2, 2), towards their normals (-dy, dx)."""
    other = xy[np.arange(len(xy)) ^ 1]
    across = np.einsum("mek,mk->me", other - xy[:, :1], edge_normals(xy))
    nearest: FloatArray = across[np.arange(len(xy)), np.abs(across).argmin(axis=1)]
    return nearest


def blur_excess(blur: FloatArray) -> FloatArray:
    """What of steps' blurs, px, goes beyond that of a lens in focus."""
    excess: FloatArray = np.sqrt(np.maximum(blur**2 - _SHARP_PX**2, 0.0))
    return excess
