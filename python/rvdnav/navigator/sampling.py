"""Edge samples: the target's edges at a pose, measured in the grey values of the views."""

from __future__ import annotations

import attrs
import numpy as np

from rvdnav.core import Core
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import FAR_PX, moved_ends, project_edges, rectified_cameras, within_reach
from rvdnav.navigator.views import Images
from rvdnav.pose import PoseError
from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray
from rvdnav.rig import Rig

# Corners blend two edges: this much of an edge's ends is not sampled, px.
_END_MARGIN_PX = 3.0
_MAX_SAMPLES_PER_EDGE = 80
# A part of an edge that is shorter than this is not worth a look, px.
_MIN_PART_PX = 10.0
# The most that the core takes; each round may find up to twice the blur of the one before.
_MAX_BLUR_PX = 10.0


@attrs.frozen(eq=False)
class Surroundings:
    """What is known of the grey values beside the edges, in each view.

    face (cameras, edges): width, px, of the even face that an edge bounds, positive where it lies towards the normal
    (-dy, dx) of the edge's projection, negative where away from it, 0 where unknown.  blur (cameras, edges):
    standard deviation of the steps' blur, px; 0 where unknown.
    """

    face: FloatArray
    blur: FloatArray


@attrs.frozen(eq=False)
class SampledEdges:
    """Profiles across the edges of all views in which a step was found; arrays of one length n.

    camera, edge (n,).  q (n, 2): where the step was found, rectified px.  n (n, 2): unit normal, to the same side all
    along an edge.  sigma (n,): px, from the profile's own noise.  polarity (n,): +1 brighter towards the normal, -1
    darker.  blur (n,): of the step, px.  slope_shift (n,): px, by how much the step moves towards n if the grey beside
    it may slope, slope (n,): the steeper slope then, parts of the contrast a px; 0 where the face is unknown.
    attempted (cameras, edges): profiles on the image, of what is seen of the edges.  spans (cameras, edges, 2,
    3): ends of what each camera sees of them, m in C.
    """

    camera: IntArray
    edge: IntArray
    q: FloatArray
    n: FloatArray
    sigma: FloatArray
    polarity: IntArray
    blur: FloatArray
    slope_shift: FloatArray
    slope: FloatArray
    attempted: IntArray
    spans: FloatArray

    def count(self, chosen: BoolArray) -> IntArray:
        """How many (cameras, edges) of each edge's samples are among the chosen ones (n,)."""
        count = np.zeros_like(self.attempted)
        np.add.at(count, (self.camera[chosen], self.edge[chosen]), 1)
        return count

    def medians(self, values: FloatArray, chosen: BoolArray | None = None) -> FloatArray:
        """(cameras, edges) of values (n,), of each edge's samples or the chosen ones (n,); NaN where there are none."""
        key = self.camera * self.attempted.shape[1] + self.edge
        if chosen is not None:
            key, values = key[chosen], values[chosen]
        order = np.lexsort((values, key))
        values = np.append(values[order], np.nan)
        end = np.searchsorted(key[order], np.arange(1, self.attempted.size + 1))
        start = np.append(0, end[:-1])
        middle = 0.5 * (values[(start + end - 1) // 2] + values[(start + end) // 2])
        return np.where(end > start, middle, np.nan).reshape(self.attempted.shape)


def sample_edges(
    core: Core,
    rig: Rig,
    images: Images,
    T_world_target: FloatArray,
    model: EdgeModel,
    half_width: float,
    polarity: IntArray,
    surroundings: Surroundings | None = None,
    offsets: FloatArray | None = None,
) -> SampledEdges:
    """Profiles across what is seen of the target's edges, half_width px to both sides of where the pose puts them.

    polarity (cameras, edges): of the steps to be found, +1 brighter towards the normal (-dy, dx) of the edge's
    projection, -1 darker, 0 either.  surroundings: without them a step is taken to stand between even greys.  offsets
    (cameras, edges, 2), px: by which the edges' ends lie off their projections towards that normal, none if not given.

    A view without image gives none; one at least has an image.  Raises PoseError for a target that is not in front of
    the cameras.
    """
    cameras = rectified_cameras(rig)
    attempted = np.zeros((len(images), len(model)), np.int64)
    spans = np.repeat(model.edge_points[None], len(images), axis=0)
    camera_parts, found_parts = [], []
    for camera, image in enumerate(images):
        if image is None:
            continue
        pieces = model.visible_pieces(T_world_target, cameras.centers[camera])
        xy, _ = project_edges(cameras, camera, T_world_target, pieces.points)
        if offsets is not None:
            xy = moved_ends(xy, model.parts(pieces.edge, pieces.points), offsets[camera, pieces.edge])
        span = xy[:, 1] - xy[:, 0]
        length = np.linalg.norm(span, axis=1)
        chosen = within_reach(xy)
        if model.faces is not None:
            chosen &= length >= _MIN_PART_PX
        if not chosen.any():
            continue
        pieces, xy, span, length = pieces.only(chosen), xy[chosen], span[chosen], length[chosen]
        spans[camera] = pieces.spans(model.edge_points)
        margin = np.minimum(_END_MARGIN_PX / np.maximum(length, 1e-9), 0.45)[:, None]
        ends = np.stack([xy[:, 0] + margin * span, xy[:, 1] - margin * span], axis=1)
        step = max(1.0, float(length.max(initial=0.0)) / _MAX_SAMPLES_PER_EDGE)
        wanted = polarity[camera, pieces.edge]
        face, blur = np.zeros(len(wanted)), 0.0
        if surroundings is not None:
            known = surroundings.face[camera, pieces.edge]
            face = np.where(np.abs(known) <= FAR_PX, known, 0.0)
            blur = np.minimum(surroundings.blur[camera, pieces.edge], _MAX_BLUR_PX)
        found = core.measure_edges(
            camera, image, ends.reshape(-1, 4), wanted, half_width, step, face=face, blur_sigma=blur
        )
        found["edge"] = pieces.edge[found["edge"]]
        np.add.at(attempted[camera], pieces.edge, _profiles_on_image(rig, camera, ends, step))
        camera_parts.append(np.full(len(found), camera, np.int64))
        found_parts.append(found)
    if not found_parts:
        raise PoseError("no edge of the target is in sight")
    found = np.concatenate(found_parts)
    return SampledEdges(
        camera=np.concatenate(camera_parts),
        edge=found["edge"].astype(np.int64),
        q=np.column_stack([found["x"], found["y"]]),
        n=np.column_stack([found["nx"], found["ny"]]),
        sigma=found["sigma"].astype(np.float64),
        polarity=found["polarity"].astype(np.int64),
        blur=found["blur"].astype(np.float64),
        slope_shift=found["slope_shift"].astype(np.float64),
        slope=found["slope"].astype(np.float64),
        attempted=attempted,
        spans=spans,
    )


def _profiles_on_image(rig: Rig, camera: int, ends: FloatArray, step: float) -> IntArray:
    """How many profiles along each edge (m, 2, 2) have their middle on the image."""
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    count = np.maximum((length / step).astype(np.int64), 1)
    edge = np.repeat(np.arange(len(ends)), count)
    number = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
    fraction = (number + 0.5) / count[edge]
    uv = rig.rect_to_raw(camera, ends[edge, 0] + fraction[:, None] * (ends[edge, 1] - ends[edge, 0]))
    inside = (uv > 0.0).all(axis=1) & (uv < np.array([rig.width - 1, rig.height - 1])).all(axis=1)
    return np.bincount(edge, inside, minlength=len(ends)).astype(np.int64)
