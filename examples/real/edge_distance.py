"""How well a pose agrees with an image: the distance of the target's projected edges from the nearest edges in it.

The image's edges are Canny's, found without any knowledge of the target; the projection is OpenCV's.  So the measure
shares nothing with the navigator but the files and the question which edges are in sight.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.pose import inverse_T
from rvdnav.rig import Rig

_BLUR_PX = 1.0
_CANNY = (20, 50)
# An image edge that runs another way is none of the target's edge, but of the print beside it.
_PARALLEL = np.cos(np.radians(20.0))
# Where there is no edge at all nearby, it counts as this far, px: a step that nobody sees, or a pose far off.
_FARTHEST_PX = 10.0
_STEP_PX = 2.0
_BORDER_PX = 3.0
# Corners round off, and shorter parts of edges are all corner.
_END_PX = 4.0


def projected_edges(
    rig: Rig, camera: int, model: EdgeModel, T_world_target: NDArray[np.float64]
) -> list[tuple[int, NDArray[np.float64]]]:
    """Edge number and image points (n, 2), px, every two pixels along each part of an edge that a camera sees."""
    lens, T_cam_world = rig.cameras[camera], inverse_T(rig.T_world_cam[camera])
    K = np.array([[lens.fx, 0.0, lens.cx], [0.0, lens.fy, lens.cy], [0.0, 0.0, 1.0]])
    T = T_cam_world @ T_world_target
    pieces = model.visible_pieces(T_world_target, rig.T_world_cam[camera][:3, 3])
    parts = []
    for edge, ends in zip(pieces.edge, pieces.points, strict=True):
        points = ends[0] + np.linspace(0.0, 1.0, 400)[:, None] * (ends[1] - ends[0])
        in_camera = points @ T[:3, :3].T + T[:3, 3]
        if in_camera[:, 2].min() <= 0.0:
            continue
        uv, _ = cv2.projectPoints(in_camera, np.zeros(3), np.zeros(3), K, lens.distortion)
        uv = uv.reshape(-1, 2)
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(uv, axis=0), axis=1))])
        places = np.arange(0.0, along[-1], _STEP_PX)
        parts.append((int(edge), np.column_stack([np.interp(places, along, uv[:, axis]) for axis in (0, 1)])))
    return parts


def edge_distances(
    pixels: NDArray[np.uint8], rig: Rig, camera: int, model: EdgeModel, T_world_target: NDArray[np.float64]
) -> dict[int, NDArray[np.float64]]:
    """Edge number -> distances, px, of its places in sight from the image's nearest edge that runs the same way.

    pixels (h, w): the camera's image.  Places near the border of the image and the ends of edges are left out.
    """
    smooth = cv2.GaussianBlur(pixels, (0, 0), _BLUR_PX)
    gx, gy = (cv2.Sobel(smooth, cv2.CV_16S, *order) for order in ((1, 0), (0, 1)))
    found = cv2.Canny(gx, gy, *_CANNY, L2gradient=True) > 0
    length = np.maximum(np.hypot(gx.astype(np.float64), gy), 1e-9)
    limit = np.array([pixels.shape[1], pixels.shape[0]]) - 1 - _BORDER_PX
    distances: dict[int, NDArray[np.float64]] = {}
    for edge, uv in projected_edges(rig, camera, model, T_world_target):
        margin = round(_END_PX / _STEP_PX)
        uv = uv[margin : len(uv) - margin]
        uv = uv[(uv > _BORDER_PX).all(axis=1) & (uv < limit).all(axis=1)]
        if len(uv) < 2:
            continue
        way = uv[-1] - uv[0]
        normal = np.array([-way[1], way[0]]) / np.linalg.norm(way)
        alike = found & (np.abs(gx * normal[0] + gy * normal[1]) > _PARALLEL * length)
        if alike.any():
            from_edge = cv2.distanceTransform(1 - alike.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
            at = cv2.remap(from_edge, uv.astype(np.float32)[None], None, cv2.INTER_LINEAR).ravel().astype(np.float64)
        else:
            at = np.full(len(uv), _FARTHEST_PX)
        distances[edge] = np.concatenate([distances.get(edge, np.zeros(0)), np.minimum(at, _FARTHEST_PX)])
    return distances
