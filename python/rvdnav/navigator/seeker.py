"""Tracking of any straight-edged target by the core's single stages: which poses its prediction and the images allow.

The core's frame call follows the eight edges of a bracket, one line each.  Here the number of edges is free, and each
may be one of several lines.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rvdnav.core import LINE, MATCH, Core, FrameResult, ViewResult
from rvdnav.navigator.association import Association, associate
from rvdnav.navigator.candidates import EdgeCandidates, edge_candidates
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.expectation import Expectation
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.navigator.stage_times import lap, now
from rvdnav.navigator.views import Views
from rvdnav.pose import RectifiedCameras
from rvdnav.pose.arrays import FloatArray

_BRACKET_APEXES = 8
# Poses that are looked into, the likeliest first.
_MOST_POSES = 4


def seek(
    core: Core,
    views: Views,
    expected: Expectation,
    model: EdgeModel,
    cameras: RectifiedCameras,
    settings: NavigatorSettings,
    times: dict[str, float],
) -> list[tuple[Association, FrameResult]]:
    """The likeliest poses near the predicted one, each with the lines that it was made of; the likeliest first.

    Raises PoseError for a target that is not in front of the cameras.
    """
    start = now()
    prediction, polarity = expected.prediction, expected.polarity
    candidates: list[EdgeCandidates] = []
    for camera, view in enumerate(views):
        if view is not None:
            candidates += edge_candidates(
                core, view.edgels, prediction, model, cameras, camera, polarity[camera], settings
            )
    associations = associate(prediction, candidates, _MOST_POSES)
    found = [(association, chosen_lines(views, candidates, association, len(model))) for association in associations]
    lap(times, "hough", start)
    return found


def chosen_lines(
    views: Views, candidates: list[EdgeCandidates], association: Association | None, edges: int
) -> FrameResult:
    """What the frame call would give for the chosen lines; no lines without an association."""
    results: list[ViewResult | None] = [None, None]
    for camera, view in enumerate(views):
        if view is None:
            continue
        lines = np.zeros(edges, LINE)
        if association is not None:
            for edge, choice in zip(candidates, association.chosen, strict=True):
                if edge.camera == camera and choice >= 0:
                    lines[edge.edge] = _line(edge, int(choice))
        results[camera] = ViewResult(
            lines=lines,
            line_found=lines["found"] != 0,
            apexes=np.zeros((_BRACKET_APEXES, 2)),
            apex_found=np.zeros(_BRACKET_APEXES, np.bool_),
            edge_count=len(view.edgels),
            peak_count=0,
            segment_count=0,
            bar_count=0,
            mean_grey=view.mean_grey,
            saturated=view.saturated,
            limits=frozenset(),
            stage_ns={},
        )
    return FrameResult(
        views=(results[0], results[1]),
        bracket=None,
        apexes_W=np.zeros((_BRACKET_APEXES, 3)),
        apex_found=np.zeros(_BRACKET_APEXES, np.bool_),
        matches=np.zeros(0, MATCH),
        limits=frozenset(),
        stage_ns={},
    )


def _line(edge: EdgeCandidates, choice: int) -> NDArray[np.void]:
    line = np.zeros((), LINE)
    theta = edge.theta[choice]
    along: FloatArray = edge.xy @ np.array([-np.sin(theta), np.cos(theta)])
    line["found"] = 1
    line["votes"] = round(float(edge.support[choice]) * edge.length)
    line["rho"], line["theta"] = edge.rho[choice], theta
    line["t_min"], line["t_max"] = along.min(), along.max()
    return line
