"""Straight lines in an image that may be the images of the target's edges, several for each edge.

On a printed surface the strongest line near an edge is often not the edge.  So its window of Hough space is cut into
slices, and the highest peak of each is kept; the pose decides among them (`association`).
"""

from __future__ import annotations

import math

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.core import WINDOW, Core
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import line_of, project_edges, within_reach
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.pose import PredictedPose, RectifiedCameras
from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray
from rvdnav.pose.cameras import project_along

_MAX_HALF_RHO_PX = 60.0
_MAX_HALF_THETA = math.radians(15.0)
_SLICE_PX = 3.0
_MAX_LINES = 8
# Shorter parts of edges hold too few edge pixels to vote.
_MIN_LENGTH_PX = 12.0
_Q5 = 32.0


@attrs.frozen(eq=False)
class EdgeCandidates:
    """What may be the image of one edge in one view.

    camera, edge.  xy (2, 2): where the prediction puts the ends of its visible part, rectified px.  across (2, 6), px/m
    and px/rad: how they move across the edge with the pose.  half_rho: half-width of the window, px.  Arrays of one
    length c: rho px, theta rad: of the lines; offset (c, 2), px: of the lines from the predicted ends, across the edge;
    support (c,): votes as a part of the edge's length.
    """

    camera: int
    edge: int
    xy: FloatArray
    across: FloatArray
    half_rho: float
    rho: FloatArray
    theta: FloatArray
    offset: FloatArray
    support: FloatArray

    @property
    def length(self) -> float:
        """Of the visible part in the image, px."""
        return float(np.linalg.norm(self.xy[1] - self.xy[0]))


def edge_candidates(
    core: Core,
    edgels: NDArray[np.void],
    prediction: PredictedPose,
    model: EdgeModel,
    cameras: RectifiedCameras,
    camera: int,
    polarity: IntArray,
    settings: NavigatorSettings,
) -> list[EdgeCandidates]:
    """Candidates for every edge that is seen by a camera, from its edge pixels (EDGEL records).

    polarity (m,): of the edges as last seen, see `Measurement.polarity`.  Raises PoseError for a target that is not in
    front of the camera.
    """
    T = prediction.T_world_target
    pieces = model.visible_pieces(T, cameras.centers[camera])
    seen = np.unique(pieces.edge)
    spans = pieces.spans(model.edge_points)[seen]
    if len(seen) == 0:
        return []
    xy, _ = project_edges(cameras, camera, T, spans)
    _, theta, _ = line_of(xy)
    normals = np.column_stack([np.cos(theta), np.sin(theta)])
    index = np.full(2 * len(seen), camera)
    _, J = project_along(cameras, index, T, spans.reshape(-1, 3), np.repeat(normals, 2, axis=0))
    across = J.reshape(-1, 2, 6)
    sigma = np.sqrt(np.einsum("eki,ij,ekj->ek", across, prediction.covariance, across)).max(axis=1)
    d = xy[:, 1] - xy[:, 0]
    agree = d[:, 0] * normals[:, 1] - d[:, 1] * normals[:, 0] > 0.0
    towards = np.where(agree, polarity[seen], -polarity[seen])
    position = np.column_stack([edgels["x_q5"], edgels["y_q5"]]).astype(np.int32)
    found = []
    for i in np.flatnonzero((np.linalg.norm(d, axis=1) >= _MIN_LENGTH_PX) & within_reach(xy)):
        length = float(np.linalg.norm(d[i]))
        half_rho = min(settings.window_min_rho_px + settings.window_sigmas * float(sigma[i]), _MAX_HALF_RHO_PX)
        half_theta = settings.window_min_theta + settings.window_sigmas * float(sigma[i]) / length
        half_theta = min(half_theta, _MAX_HALF_THETA)
        middle = np.round(xy[i].mean(axis=0) * _Q5).astype(np.int32)
        beside = edgels[_beside(position - middle, float(theta[i]), 0.5 * length, half_rho, half_theta)]
        beside["x_q5"] -= middle[0]
        beside["y_q5"] -= middle[1]
        windows = _slices(float(theta[i]), half_rho, half_theta, 0.5 * length, int(towards[i]))
        peaks = core.hough_track(camera, beside, windows)
        peaks = peaks[peaks["votes"] > 0]
        peaks = peaks[np.argsort(-peaks["votes"].astype(np.int64), kind="stable")][:_MAX_LINES]
        lines = _about_principal_point(peaks, float(theta[i]), middle / _Q5)
        normal = np.column_stack([np.cos(lines[1]), np.sin(lines[1])])
        offset = (lines[0][:, None] - normal @ xy[i].T) / (normal @ normals[i])[:, None]
        support = np.minimum(peaks["votes"] / length, 1.0)
        found.append(EdgeCandidates(camera, int(seen[i]), xy[i], across[i], half_rho, *lines, offset, support))
    return found


def _beside(offset: IntArray, theta: float, half_length: float, half_rho: float, half_theta: float) -> BoolArray:
    """Which edge pixels, offset (n, 2) from the middle of an edge in Q5, may vote in its window."""
    c, s = math.cos(theta), math.sin(theta)
    across = np.abs(c * offset[:, 0] + s * offset[:, 1]) / _Q5
    along = np.abs(c * offset[:, 1] - s * offset[:, 0]) / _Q5
    reach = 1.2 * half_length + 8.0
    # Beyond the window as well, for a peak is compared with what stands beside it.
    inside: BoolArray = (along < reach) & (across < half_rho + reach * math.tan(half_theta) + 6.0)
    return inside


def _slices(theta: float, half_rho: float, half_theta: float, half_length: float, polarity: int) -> NDArray[np.void]:
    """WINDOW records that share a window about the middle of an edge among them."""
    count = max(math.ceil(2.0 * half_rho / _SLICE_PX), 1)
    half = half_rho / count
    windows = np.zeros(count, WINDOW)
    windows["polarity"] = polarity
    windows["rho"] = -half_rho + half * (2.0 * np.arange(count) + 1.0)
    windows["theta"] = theta
    windows["half_rho"] = half
    windows["half_theta"] = half_theta
    windows["t_min"], windows["t_max"] = -half_length, half_length
    return windows


def _about_principal_point(peaks: NDArray[np.void], theta: float, middle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """rho and theta of peaks that were found about a middle (2,); the half turn next to theta."""
    rho, angle = peaks["rho_q8"] / 256.0, np.radians(peaks["theta_q8"] / 256.0)
    turns = np.round((angle - theta) / np.pi)
    angle = angle - turns * np.pi
    rho = np.where(turns % 2 == 0, rho, -rho)
    return rho + middle[0] * np.cos(angle) + middle[1] * np.sin(angle), angle
