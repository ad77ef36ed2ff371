"""The even faces beside the edges against exact geometry, and what they are good for against a drawn shadow."""

from __future__ import annotations

import numpy as np
import pytest
from drawn_scene import bracket_target, example_rig, pose
from readable_navigator.faces import edge_blur, with_slopes
from readable_navigator.sampling import SampledEdges
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.faces import face_widths
from rvdnav.navigator.geometry import project_edges, rectified_cameras


@pytest.mark.parametrize("camera", [0, 1])
def test_a_face_lies_on_the_side_of_its_bar_and_is_as_wide(camera: int) -> None:
    rig, bracket = example_rig(), bracket_target().bracket
    cameras = rectified_cameras(rig)
    T = pose(0.6, 0.03, 0.09, 12.0, -9.0, 6.0)
    widths = face_widths(cameras, T, EdgeModel.of_bracket(bracket))[camera]
    xy, _ = project_edges(cameras, camera, T, bracket.edge_points)
    for edge, width in enumerate(widths):
        start, end = xy[edge]
        # A left turn from the edge's direction in an image whose y runs down.
        normal = np.array([-(end - start)[1], (end - start)[0]]) / np.linalg.norm(end - start)
        # The bar's front face is the convex hull of its two edges.
        inside = np.vstack([xy[edge], xy[edge ^ 1]]).mean(axis=0)
        assert np.sign(width) == np.sign(normal @ (inside - start))
        distances = np.abs((xy[edge ^ 1] - start) @ normal)
        assert abs(width) == pytest.approx(distances.min())


def test_an_edge_has_a_blur_of_its_own_where_it_is_clearly_another() -> None:
    """Edge 0 is blurred along the motion, 1 by chance wider, 2 hardly seen; the second view shows nothing at all."""
    counts = {0: 15, 1: 40, 2: 3, 3: 40}
    blurs = {0: 2.4, 1: 0.85, 2: 2.4, 3: 0.75}
    edge = np.repeat(list(counts), list(counts.values()))
    blur = np.array([blurs[k] for k in edge])
    zeros, count = np.zeros(len(edge)), len(edge)
    wild = np.arange(count) == count - 1
    blur[wild] = 50.0
    sampled = SampledEdges(
        camera=np.zeros(count, np.int64),
        edge=edge,
        q=np.zeros((count, 2)),
        n=np.zeros((count, 2)),
        sigma=zeros,
        polarity=np.ones(count, np.int64),
        blur=blur,
        slope_shift=zeros,
        slope=zeros,
        attempted=np.zeros((2, 4), np.int64),
        spans=np.zeros((2, 4, 2, 3)),
    )
    found = edge_blur(sampled, ~wild, np.full((2, 4), 0.9))
    of_view = np.median(blur[~wild])
    assert found[0].tolist() == [2.4, of_view, of_view, of_view]
    assert found[1].tolist() == [0.9, 0.9, 0.9, 0.9]


def test_a_slope_counts_where_all_the_edge_shows_it() -> None:
    """Once steep along the whole edge, once in a few profiles only."""
    count = 9
    slope = np.concatenate([np.full(count, 0.2), np.where(np.arange(count) < 3, 0.2, 0.001)])
    sampled = SampledEdges(
        camera=np.repeat([0, 1], count),
        edge=np.repeat([3, 2], count),
        q=np.zeros((2 * count, 2)),
        n=np.tile([0.6, 0.8], (2 * count, 1)),
        sigma=np.full(2 * count, 0.1),
        polarity=np.ones(2 * count, np.int64),
        blur=np.full(2 * count, 0.7),
        slope_shift=np.full(2 * count, 0.1),
        slope=slope,
        attempted=np.full((2, 8), count),
        spans=np.zeros((2, 8, 2, 3)),
    )
    corrected, shift = with_slopes(sampled)
    moved = corrected.q
    assert shift[0, 3] == pytest.approx(0.1, rel=0.02)
    assert shift[1, 2] < 0.001
    np.testing.assert_allclose(moved[:count], np.tile([0.06, 0.08], (count, 1)), rtol=0.02)
    assert np.abs(moved[count:]).max() < 0.001
