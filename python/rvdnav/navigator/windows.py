"""Search windows of Hough space from a predicted pose."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rvdnav.core import layout
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import FAR_PX, line_of, moved_ends, project_edges, within_reach
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.pose import PredictedPose, RectifiedCameras
from rvdnav.pose.arrays import FloatArray, IntArray
from rvdnav.pose.cameras import project_along

# Nearer the target's edges lie farther apart, and a window of this part of the longest one still tells them apart.
_MAX_PART = 0.16


def predicted_windows(
    prediction: PredictedPose,
    model: EdgeModel,
    cameras: RectifiedCameras,
    camera: int,
    polarity: IntArray,
    offsets: FloatArray,
    settings: NavigatorSettings,
) -> NDArray[np.void] | None:
    """WINDOW records of the target's edges, or None where the prediction is too vague to be of use.

    Edges that the prediction puts beyond every image have none.

    polarity (m,): +1 where an edge was brighter towards the normal (-dy, dx) of its projection, -1 darker, 0 unknown.
    offsets (m, 2), px: by which its ends lie off the projection towards that normal.

    The half-widths follow from the prediction's covariance through the projection's derivative.  Raises PoseError for a
    target that is not in front of the camera.
    """
    edge_points = model.edge_points
    xy, _ = project_edges(cameras, camera, prediction.T_world_target, edge_points)
    xy = moved_ends(xy, np.tile([0.0, 1.0], (len(model), 1)), offsets)
    rho, theta, t = line_of(xy)
    sigma = _across_sigma(prediction, edge_points, cameras, camera, theta)
    length = np.maximum(t[:, 1] - t[:, 0], 1.0)
    half_rho = settings.window_min_rho_px + settings.window_sigmas * sigma.max(axis=1)
    if half_rho.max() > max(settings.window_max_rho_px, _MAX_PART * float(length.max())):
        return None
    windows = np.zeros(len(edge_points), layout.WINDOW)
    windows["edge"] = np.arange(len(edge_points))
    d = xy[:, 1] - xy[:, 0]
    agree = d[:, 0] * np.sin(theta) - d[:, 1] * np.cos(theta) > 0.0
    windows["polarity"] = np.where(agree, polarity, -polarity)
    windows["rho"] = rho
    windows["theta"] = theta
    # rho is the distance to the foot of the perpendicular, which can lie far along the line: a turn moves it too.
    lever = np.abs(t.mean(axis=1))
    half_theta = settings.window_min_theta + settings.window_sigmas * sigma.max(axis=1) / length
    windows["half_theta"] = half_theta
    windows["half_rho"] = half_rho + lever * settings.window_sigmas * sigma.max(axis=1) / length
    windows["t_min"] = t[:, 0]
    windows["t_max"] = t[:, 1]
    windows = windows[within_reach(xy) & (windows["half_rho"] <= FAR_PX)]
    return windows if len(windows) else None


def _across_sigma(
    prediction: PredictedPose, edge_points: FloatArray, cameras: RectifiedCameras, camera: int, theta: FloatArray
) -> FloatArray:
    """Standard deviations (m, 2) of the edges' ends across them, px."""
    normals = np.repeat(np.column_stack([np.cos(theta), np.sin(theta)]), 2, axis=0)
    index = np.full(len(normals), camera)
    _, J = project_along(cameras, index, prediction.T_world_target, edge_points.reshape(-1, 3), normals)
    variance = np.einsum("ni,ij,nj->n", J, prediction.covariance, J)
    sigma: FloatArray = np.sqrt(np.maximum(variance, 0.0)).reshape(-1, 2)
    return sigma
