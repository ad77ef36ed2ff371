"""Edges of a target that run close beside each other in an image: the step of one may be taken for the other's.

The far edge of a face that is seen at a grazing angle, or the back edge of a thin panel, lies within a few pixels of
the near one.  Which of them the grey values show there, no geometry tells.
"""

from __future__ import annotations

import numpy as np

from rvdnav.pose import RectifiedCameras
from rvdnav.pose.arrays import FloatArray, IntArray

# Edges further apart than this are not confused; profiles reach half as far.
_REACH_PX = 5.0
_PLACES = 9
# Part of an edge that a neighbour must accompany.
_ACCOMPANIED = 0.3


def neighbour_separation(
    cameras: RectifiedCameras, T_world_target: FloatArray, spans: FloatArray, camera: IntArray, edge: IntArray
) -> FloatArray:
    """Mean distance (k,), px, of the measured edge next to each along the part where it is near; 0 where there is none.

    spans (cameras, edges, 2, 3): see `SampledEdges`.  camera, edge (k,): of the measured lines.
    """
    separation = np.zeros(len(camera))
    part = np.linspace(0.05, 0.95, _PLACES)[:, None]
    for index in np.unique(camera):
        rows = np.flatnonzero(camera == index)
        points_W = spans[index, edge[rows]].reshape(-1, 3) @ T_world_target[:3, :3].T + T_world_target[:3, 3]
        xy = cameras.project(np.full(len(points_W), index), points_W).reshape(-1, 2, 2)
        start, span = xy[:, 0], xy[:, 1] - xy[:, 0]
        places = start[:, None] + part * span[:, None]
        # From every place (i, p) to every edge j.
        offset = places[:, :, None] - start
        along = np.einsum("ipjk,jk->ipj", offset, span) / np.maximum(np.einsum("jk,jk->j", span, span), 1e-12)
        distance = np.linalg.norm(offset - along[..., None] * span, axis=-1)
        near = (distance < _REACH_PX) & (along >= 0.0) & (along <= 1.0)
        near[np.arange(len(rows)), :, np.arange(len(rows))] = False
        mean = np.where(near, distance, 0.0).sum(axis=1) / np.maximum(near.sum(axis=1), 1)
        separation[rows] = np.where(near.mean(axis=1) >= _ACCOMPANIED, mean, 0.0).max(axis=1, initial=0.0)
    return separation
