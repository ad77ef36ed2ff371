"""Edge samples: the target's edges at a pose, measured in the grey values of the views."""

from __future__ import annotations

import attrs
import numpy as np
from rvdnav.core import SEEN_EDGE, Core
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import rectified_cameras, rectified_ends
from rvdnav.navigator.views import Images
from rvdnav.navigator.visibility import Pieces
from rvdnav.pose import PoseError
from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray
from rvdnav.rig import Rig

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
    shown = [k for k, image in enumerate(images) if image is not None]
    of_view = [model.visible_pieces(T_world_target, cameras.centers[k]) for k in shown]
    camera = np.repeat(shown, [len(pieces.edge) for pieces in of_view])
    edge = np.concatenate([pieces.edge for pieces in of_view])
    points = np.concatenate([pieces.points for pieces in of_view])
    seen = np.zeros(len(edge), SEEN_EDGE)
    seen["camera"], seen["polarity"] = camera, polarity[camera, edge]
    seen["ends"] = ends = rectified_ends(cameras, camera, T_world_target, points)
    if not (ends[:, :, 2] > 0.0).all():
        raise PoseError("a point of the target is not in front of the camera")
    if offsets is not None:
        of_edge = offsets[camera, edge]
        seen["offset"] = of_edge[:, :1] + model.parts(edge, points) * (of_edge[:, 1:] - of_edge[:, :1])
    if surroundings is not None:
        seen["face"] = surroundings.face[camera, edge]
        seen["blur"] = np.minimum(surroundings.blur[camera, edge], _MAX_BLUR_PX)
    found, coverage = core.sample_edges(images, seen, half_width, 0.0 if model.faces is None else _MIN_PART_PX)
    placed = coverage["placed"] != 0
    if not placed.any():
        raise PoseError("no edge of the target is in sight")
    attempted = np.zeros((len(images), len(model)), np.int64)
    np.add.at(attempted, (camera, edge), coverage["profiles"])
    spans = np.repeat(model.edge_points[None], len(images), axis=0)
    for k in shown:
        spans[k] = Pieces(edge, points).only(placed & (camera == k)).spans(model.edge_points)
    return SampledEdges(
        camera=camera[found["edge"]],
        edge=edge[found["edge"]],
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
