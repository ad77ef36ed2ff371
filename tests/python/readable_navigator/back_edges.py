"""The far edges of side faces as evidence: a bar whose side face is lit like its front ends there.

They say that the bar is where the pose puts it, but take no part in the refinement.
"""

from __future__ import annotations

import attrs
import numpy as np
from rvdnav.bracket import Bracket
from rvdnav.core import Core
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import line_of, project_edges, rectified_cameras
from rvdnav.navigator.sides import side_separation
from rvdnav.navigator.views import Images
from rvdnav.pose import LineMeasurements, fit_edge_lines, line_residuals
from rvdnav.pose.arrays import BoolArray, FloatArray
from rvdnav.rig import Rig

from readable_navigator.sampling import sample_edges

# A back edge nearer to the front edge than this cannot be told from it, px.
_MIN_SEPARATION_PX = 2.0
_HALF_WIDTH_PX = 2.0
# How far a back edge's line may lie off; the thickness is less exactly known than the front face, px.
_MAX_OFFSET_PX = 1.0
_TRUSTED = 0.2


def back_coverage(
    core: Core,
    rig: Rig,
    images: Images,
    T_world_target: FloatArray,
    bracket: Bracket,
    wanted: BoolArray,
) -> FloatArray:
    """(cameras, edges) part of the profiles across each wanted back edge that show a step where the pose puts it.

    0 where it is not wanted (cameras, edges), and where the side face is out of sight or too narrow to tell its back
    edge from the front one.
    """
    distinct = wanted & _distinct_sides(rig, images, T_world_target, bracket)
    if not distinct.any():
        return np.zeros(wanted.shape)
    depth = np.array([bracket.thickness, 0.0, 0.0])
    front = EdgeModel.of_bracket(bracket)
    model = attrs.evolve(front, points=front.points + depth)
    either = np.zeros(wanted.shape, np.int64)
    sampled = sample_edges(core, rig, images, T_world_target, model, _HALF_WIDTH_PX, either)
    fits = fit_edge_lines(sampled.camera, sampled.edge, sampled.q, sampled.n, sampled.sigma)
    lines = LineMeasurements(fits.camera, fits.edge, model.edge_points[fits.edge], fits.rho, fits.theta, fits.cov)
    offsets, _ = line_residuals(T_world_target, lines, rectified_cameras(rig))
    near = np.zeros(wanted.shape, np.bool_)
    near[fits.camera, fits.edge] = np.abs(offsets).max(axis=1) < _MAX_OFFSET_PX
    covered = sampled.count(fits.weights > _TRUSTED)
    part: FloatArray = np.where(near & distinct, covered / np.maximum(sampled.attempted, 1), 0.0)
    return part


def _distinct_sides(rig: Rig, images: Images, T_world_target: FloatArray, bracket: Bracket) -> BoolArray:
    """(cameras, edges) whether the side face is in sight and wide enough."""
    cameras = rectified_cameras(rig)
    edges = np.arange(len(bracket.edge_points))
    distinct = np.zeros((len(images), len(edges)), np.bool_)
    for camera, image in enumerate(images):
        if image is None:
            continue
        xy, _ = project_edges(cameras, camera, T_world_target, bracket.edge_points)
        index = np.full(len(edges), camera)
        separation = side_separation(cameras, T_world_target, bracket, index, edges, line_of(xy)[1])
        distinct[camera] = np.abs(separation) > _MIN_SEPARATION_PX
    return distinct
