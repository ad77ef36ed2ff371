"""Edges of a target that run close beside each other in an image: the step of one may be taken for the other's.

The far edge of a face that is seen at a grazing angle, or the back edge of a thin panel, lies within a few pixels of
the near one.  Which of them the grey values show there, no geometry tells.
"""

from __future__ import annotations

import numpy as np
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import project_edges
from rvdnav.pose import RectifiedCameras
from rvdnav.pose.arrays import FloatArray

# Edges further apart than this are not confused; profiles reach half as far.
_REACH_PX = 5.0
# Sine of the angle up to which edges run beside each other.
_PARALLEL = 0.25
_PLACES = 9
# Part of an edge that a neighbour must accompany.
_ACCOMPANIED = 0.3


def neighbour_separation(cameras: RectifiedCameras, T_world_target: FloatArray, model: EdgeModel) -> FloatArray:
    """Mean distance (cameras, edges), px, of the edge next to each along the part where it is near; 0 where there is
    none.  Raises PoseError for an edge that is not in front of its camera."""
    separation = np.zeros((len(cameras.centers), len(model)))
    for camera, eye_W in enumerate(cameras.centers):
        pieces = model.visible_pieces(T_world_target, eye_W, grazing=True)
        edges = np.unique(pieces.edge)
        xy, _ = project_edges(cameras, camera, T_world_target, pieces.spans(model.edge_points)[edges])
        separation[camera, edges] = _separation(xy)
    return separation


def _separation(xy: FloatArray) -> FloatArray:
    """Of segments (m, 2, 2) in one image."""
    part = np.linspace(0.05, 0.95, _PLACES)[:, None]
    start, span = xy[:, 0], xy[:, 1] - xy[:, 0]
    places = start[:, None] + part * span[:, None]
    # From every place (i, p) to every edge j.
    offset = places[:, :, None] - start
    along = np.einsum("ipjk,jk->ipj", offset, span) / np.maximum(np.einsum("jk,jk->j", span, span), 1e-12)
    distance = np.linalg.norm(offset - along[..., None] * span, axis=-1)
    near = (distance < _REACH_PX) & (along >= 0.0) & (along <= 1.0)
    direction = span / np.maximum(np.linalg.norm(span, axis=1, keepdims=True), 1e-12)
    sine = direction[:, None, 0] * direction[:, 1] - direction[:, None, 1] * direction[:, 0]
    near &= (np.abs(sine) < _PARALLEL)[:, None]
    itself = np.arange(len(xy))
    near[itself, :, itself] = False
    mean = np.where(near, distance, 0.0).sum(axis=1) / np.maximum(near.sum(axis=1), 1)
    separation: FloatArray = np.where(near.mean(axis=1) >= _ACCOMPANIED, mean, 0.0).max(axis=1, initial=0.0)
    return separation
