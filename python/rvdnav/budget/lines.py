"""The lines that the views give at a pose, where they truly are, and what pixel noise does to them."""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.budget.design import Design
from rvdnav.navigator.geometry import line_covariance, line_of, project_edges
from rvdnav.navigator.sides import side_separation
from rvdnav.pose import LineMeasurements, PoseError
from rvdnav.pose.arrays import FloatArray, IntArray

# As the navigator samples and fits edges: not at the corners, up to so many profiles, neighbours of which share pixels,
# and never stating less than this scatter.
_END_MARGIN_PX = 3.0
_MAX_SAMPLES = 80
_MIN_SAMPLES = 5
_CORRELATION = 2.0
_LEAST_SCATTER_PX = 0.025
# Places along an edge that are looked at for whether they are on the image.
_PLACES = (np.arange(64) + 0.5) / 64


@attrs.frozen(eq=False)
class ExpectedLines:
    """lines: with the covariances and shifts that the estimator states for them.  noise (n, 2, 2): covariance of (rho,
    theta) by the pixels' noise.  part (n, 2): where on its edge the ends of a line are, 0 at the edge's first end and 1
    at the other.  span (n, 2): what is measured of a line's image, in the same way between its ends."""

    lines: LineMeasurements
    noise: FloatArray
    part: FloatArray
    span: FloatArray


def expected_lines(design: Design, T_world_target: FloatArray) -> ExpectedLines:
    """What is measured at a pose (4, 4).  Raises PoseError where nothing is, or the target isn't in front."""
    camera, edge, points_C, ends, span, step = [], [], [], [], [], []
    for i in design.views:
        pieces = design.model.visible_pieces(T_world_target, design.cameras.centers[i])
        in_sight = set(pieces.edge.tolist())
        seen_C = pieces.spans(design.model.edge_points)
        xy, _ = project_edges(design.cameras, i, T_world_target, seen_C)
        longest = float(np.linalg.norm(xy[:, 1] - xy[:, 0], axis=1).max())
        for k in design.edges:
            measured = _measured_span(design, i, xy[k]) if k in in_sight else None
            if measured is not None:
                camera.append(i)
                edge.append(k)
                points_C.append(seen_C[k])
                ends.append(xy[k])
                span.append(measured)
                step.append(max(1.0, longest / _MAX_SAMPLES))
    if not camera:
        raise PoseError("no edge of the target is in view")
    rho, theta, _ = line_of(np.array(ends))
    index, number, spans = np.array(camera), np.array(edge), np.array(span)
    noise = _fit_covariance(np.array(ends), spans, theta, np.array(step))
    profile = design.assumptions.profile_sigma
    stated = max(profile, _LEAST_SCATTER_PX) ** 2 * noise
    shift = np.zeros(len(index))
    if design.model.bracket is not None:
        separation = side_separation(design.cameras, T_world_target, design.model.bracket, index, number, theta)
        shift = design.assumptions.side_part * np.abs(separation)
    lines = LineMeasurements(index, number, points_C, rho, theta, stated, shift)
    edges_C = design.model.edge_points[number]
    along_C = edges_C[:, 1:] - edges_C[:, :1]
    part = np.einsum("nki,nki->nk", lines.endpoints_C - edges_C[:, :1], along_C) / np.square(along_C).sum(axis=2)
    return ExpectedLines(lines, profile**2 * noise, part, spans)


def ends_along(design: Design, T_world_target: FloatArray, lines: LineMeasurements) -> FloatArray:
    """Places (n, 2), px, of the projected ends of the edges along their lines, t = -x sin(theta) + y cos(theta)."""
    points_W = lines.endpoints_C.reshape(-1, 3) @ T_world_target[:3, :3].T + T_world_target[:3, 3]
    xy = design.cameras.project(np.repeat(lines.camera, 2), points_W).reshape(-1, 2, 2)
    along: FloatArray = xy[:, :, 1] * np.cos(lines.theta)[:, None] - xy[:, :, 0] * np.sin(lines.theta)[:, None]
    return along


def shared_corners(edge_points: FloatArray) -> IntArray:
    """Number (m, 2) of the corner that each end of edges (m, 2, 3) is; edges that meet share it."""
    _, which = np.unique(np.round(edge_points.reshape(-1, 3), 9), axis=0, return_inverse=True)
    return which.reshape(-1, 2).astype(np.int64)


def _measured_span(design: Design, camera: int, xy: FloatArray) -> tuple[float, float] | None:
    """The part of an edge's image (2, 2) that is on the camera's image and sampled; None where it is too short."""
    length = float(np.linalg.norm(xy[1] - xy[0]))
    uv = design.rig.rect_to_raw(camera, xy[0] + _PLACES[:, None] * (xy[1] - xy[0]))
    on_image = design.rig.on_image(uv)
    margin = _END_MARGIN_PX / max(length, 1e-9)
    usable = _PLACES[on_image & (np.abs(_PLACES - 0.5) < 0.5 - margin) & (np.abs(_PLACES - 0.5) < 0.5 * design.part)]
    if len(usable) == 0 or (usable[-1] - usable[0]) * length < _MIN_SAMPLES:
        return None
    return float(usable[0]), float(usable[-1])


def _fit_covariance(ends: FloatArray, span: FloatArray, theta: FloatArray, step: FloatArray) -> FloatArray:
    """Covariance (n, 2, 2) of (rho, theta) of straight lines through profiles that err by 1 px each.

    ends (n, 2, 2) px; span (n, 2) of them with a profile every step (n,), px.
    """
    t = ends[:, :, 1] * np.cos(theta)[:, None] - ends[:, :, 0] * np.sin(theta)[:, None]
    reach = t[:, :1] + span * (t[:, 1:] - t[:, :1])
    middle, length = reach.mean(axis=1), np.abs(reach[:, 1] - reach[:, 0])
    offset = _CORRELATION / np.maximum(length / step, 1.0)
    return line_covariance(offset, 12.0 * offset / length**2, middle)
