"""The far edges of side faces as evidence: a bar whose side face is lit like its front ends there.

They say that the bar is where the pose puts it, but take no part in the refinement.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.bracket import Bracket
from rvdnav.core import Core
from rvdnav.navigator.geometry import line_of, project_edges, rectified_cameras
from rvdnav.navigator.sampling import sample_edges
from rvdnav.navigator.sides import side_separation
from rvdnav.pose import LineMeasurements, fit_edge_lines, line_residuals
from rvdnav.pose.arrays import FloatArray
from rvdnav.rig import Rig

# A back edge nearer to the front edge than this cannot be told from it, px.
_MIN_SEPARATION_PX = 2.0
_HALF_WIDTH_PX = 2.0
# How far a back edge's line may lie off; the thickness is less exactly known than the front face, px.
_MAX_OFFSET_PX = 1.0
_TRUSTED = 0.2


def back_coverage(
    core: Core,
    rig: Rig,
    images: tuple[NDArray[np.uint8] | None, ...],
    T_world_target: FloatArray,
    bracket: Bracket,
) -> FloatArray:
    """(cameras, edges) part of the profiles across each back edge that show a step where the pose puts it.

    0 where the side face is out of sight or too narrow to tell its back edge from the front one.
    """
    cameras = rectified_cameras(rig)
    depth = np.array([bracket.thickness, 0.0, 0.0])
    back = attrs.evolve(bracket, outer=bracket.outer + depth, inner=bracket.inner + depth)
    edges = len(bracket.edge_points)
    covered = np.zeros((len(images), edges))
    sampled = sample_edges(
        core, rig, images, T_world_target, back, _HALF_WIDTH_PX, np.zeros((len(images), edges), np.int64)
    )
    fits = fit_edge_lines(sampled.camera, sampled.edge, sampled.q, sampled.n, sampled.sigma)
    lines = LineMeasurements(fits.camera, fits.edge, back.edge_points[fits.edge], fits.rho, fits.theta, fits.cov)
    offsets, _ = line_residuals(T_world_target, lines, cameras)
    near = np.zeros((len(images), edges), np.bool_)
    near[fits.camera, fits.edge] = np.abs(offsets).max(axis=1) < _MAX_OFFSET_PX
    agreed = fits.weights > _TRUSTED
    np.add.at(covered, (sampled.camera[agreed], sampled.edge[agreed]), 1.0)
    for camera, image in enumerate(images):
        if image is None:
            continue
        xy, _ = project_edges(cameras, camera, T_world_target, bracket.edge_points)
        index = np.full(edges, camera)
        separation = side_separation(cameras, T_world_target, bracket, index, np.arange(edges), line_of(xy)[1])
        near[camera] &= np.abs(separation) > _MIN_SEPARATION_PX
    part: FloatArray = np.where(near, covered / np.maximum(sampled.attempted, 1), 0.0)
    return part
