"""The even faces beside the edges against exact geometry, and what they are good for against a drawn shadow."""

from __future__ import annotations

import numpy as np
import pytest
from drawn_scene import bracket_target, example_rig, pose
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.faces import face_widths, surroundings, with_slopes
from rvdnav.navigator.geometry import project_edges, rectified_cameras
from rvdnav.navigator.sampling import SampledEdges


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


def test_the_blur_of_a_view_is_its_agreeing_samples_median() -> None:
    camera = np.array([0, 0, 0, 0, 1])
    zeros = np.zeros(5)
    sampled = SampledEdges(
        camera=camera,
        edge=np.zeros(5, np.int64),
        q=np.zeros((5, 2)),
        n=np.zeros((5, 2)),
        sigma=zeros,
        polarity=np.ones(5, np.int64),
        blur=np.array([0.6, 0.7, 0.9, 5.0, 0.8]),
        slope_shift=zeros,
        slope=zeros,
        attempted=np.zeros((3, 8), np.int64),
        spans=np.zeros((3, 8, 2, 3)),
    )
    agreeing = np.array([True, True, True, False, True])
    known = surroundings(np.zeros((3, 8)), sampled, agreeing)
    # 0 where nothing was sampled: the configured blur.
    assert known.blur.tolist() == [0.7, 0.8, 0.0]


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
