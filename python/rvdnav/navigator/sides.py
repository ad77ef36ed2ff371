"""The bars' side faces: where one is in sight, the step seen at an edge of the front face may be the far end of it.

The bars reach back from the front face by their thickness.  From a camera that looks past an edge the front face ends
in the background and the step is the edge itself.  From one that sees the side face too, the step lies at the front
edge, at the back edge, or in between, as the light on the side face has it: nothing in the geometry tells which.
"""

from __future__ import annotations

import numpy as np

from rvdnav.bracket import Bracket
from rvdnav.pose import RectifiedCameras
from rvdnav.pose.arrays import FloatArray, IntArray


def side_separation(
    cameras: RectifiedCameras,
    T_world_target: FloatArray,
    bracket: Bracket,
    camera: IntArray,
    edge: IntArray,
    theta: FloatArray,
) -> FloatArray:
    """How far (k,), px, the back edge is seen beside the middle of each edge; 0 where the side face is out of sight.

    camera, edge (k,): of the measured lines; theta (k,): of their normals, to which side the distance counts.
    Raises PoseError for an edge that is not in front of its camera.
    """
    R, t = T_world_target[:3, :3], T_world_target[:3, 3]
    middle = bracket.edge_points.mean(axis=1)[edge]
    front = middle @ R.T + t
    back = (middle + np.array([bracket.thickness, 0.0, 0.0])) @ R.T + t
    outward = bracket.side_normals[edge] @ R.T
    in_sight = np.einsum("ki,ki->k", outward, cameras.centers[camera] - front) > 0.0
    shift = cameras.project(camera, back) - cameras.project(camera, front)
    separation: FloatArray = np.where(in_sight, np.cos(theta) * shift[:, 0] + np.sin(theta) * shift[:, 1], 0.0)
    return separation
