"""What an eye sees of edges: against half-spaces of convex hulls, and exact geometry."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from readable_navigator.neighbours import neighbour_separation
from rvdnav.navigator.edge_model import edge_model
from rvdnav.navigator.visibility import Faces
from rvdnav.pose import RectifiedCameras
from rvdnav.target import Target
from scipy.spatial import ConvexHull

from drawn_solid import box_target, frame_target, panel_target  # isort: skip

MARGIN = 1e-3
PARTS = np.linspace(0.02, 0.98, 25)[:, None]


def solid(seed: int, count: int, centre: np.ndarray) -> tuple[ConvexHull, list[np.ndarray], np.ndarray]:
    """A random convex solid: its hull, its triangles counter-clockwise from outside, and its edges (m, 2, 3)."""
    rng = np.random.default_rng(seed)
    hull = ConvexHull(centre + rng.normal(size=(count, 3)))
    triangles = []
    for simplex, plane in zip(hull.simplices, hull.equations, strict=True):
        a, b, c = hull.points[simplex]
        triangles.append(np.array([a, b, c] if np.cross(b - a, c - a) @ plane[:3] > 0.0 else [a, c, b]))
    pairs = {tuple(sorted((s[i], s[j]))) for s in hull.simplices for i, j in ((0, 1), (1, 2), (2, 0))}
    return hull, triangles, np.array([[hull.points[a], hull.points[b]] for a, b in sorted(pairs)])


def inside_length(hull: ConvexHull, eye: np.ndarray, place: np.ndarray) -> float:
    """How much of the segment from the eye to a place lies within a hull: clipped by every half-space."""
    low, high = 0.0, 1.0
    for *normal, offset in hull.equations:
        at_eye, at_place = np.dot(normal, eye) + offset, np.dot(normal, place) + offset
        if at_eye > 0.0 and at_place > 0.0:
            return 0.0
        if at_eye > 0.0:
            low = max(low, at_eye / (at_eye - at_place))
        elif at_place > 0.0:
            high = min(high, at_eye / (at_eye - at_place))
    return max(high - low, 0.0) * float(np.linalg.norm(place - eye))


@settings(max_examples=30)
@given(st.integers(0, 10**6), st.integers(5, 9))
def test_edges_of_convex_solids_are_seen_where_no_ray_enters_one(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    near, near_faces, near_edges = solid(seed + 1, count, np.zeros(3))
    far, far_faces, far_edges = solid(seed + 2, count, np.array([6.0, *rng.normal(size=2)]))
    eye = np.array([-8.0, *rng.uniform(-4.0, 4.0, 2)])
    edges = np.concatenate([near_edges, far_edges])
    faces = Faces.of(near_faces + far_faces, edges)
    places = edges[:, :1] + PARTS * (edges[:, 1:] - edges[:, :1])
    seen = faces.visible(eye, places)
    for edge in range(len(edges)):
        for place, visible in zip(places[edge], seen[edge], strict=True):
            through = max(inside_length(hull, eye, place) for hull in (near, far))
            if through > MARGIN:
                assert not visible
            elif through < 1e-9:
                assert visible


@given(st.integers(0, 10**6))
def test_a_face_that_is_not_convex_hides_what_lies_behind_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    corner = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], float)  # an L of two rectangles
    polygon = np.column_stack([np.zeros(6), corner])
    ends = np.column_stack([np.full(2, 1.0), rng.uniform(-0.5, 2.5, (2, 2))])[None]
    eye = np.array([-3.0, *rng.uniform(0.0, 2.0, 2)])
    places = ends[:, :1] + PARTS * (ends[:, 1:] - ends[:, :1])
    seen = Faces.of([polygon], ends).visible(eye, places)[0]
    hit = eye + (0.0 - eye[0]) / (places[0, :, :1] - eye[0]) * (places[0] - eye)
    u, v = hit[:, 1], hit[:, 2]
    in_l = ((u > 0) & (u < 2) & (v > 0) & (v < 1)) | ((u > 0) & (u < 1) & (v > 0) & (v < 2))
    clear = np.min(np.abs(np.concatenate([hit[:, 1:] - k for k in (0.0, 1.0, 2.0)], axis=1)), axis=1) > MARGIN
    assert (seen == ~in_l)[clear].all()


def test_visible_pieces_end_where_the_face_before_them_ends() -> None:
    points = {"A": (0, -1, -1), "B": (0, 1, -1), "C": (0, 1, 1), "D": (0, -1, 1), "E": (2, -3, 0), "F": (2, 3, 0)}
    target = Target("shade", points, edges=[("E", "F"), ("A", "B")], faces=[("A", "D", "C", "B")])
    # From x = -2 the square covers y from -2 to 2 at x = 2.
    pieces = edge_model(target).visible_pieces(np.eye(4), np.array([-2.0, 0.0, 0.0]))
    assert pieces.edge.tolist() == [0, 0, 1]
    np.testing.assert_allclose(pieces.points[:2, :, 1], [[-3.0, -2.0], [2.0, 3.0]], atol=6.0 / 64)
    assert (np.abs(pieces.points[:2, :, 1]) >= 2.0).all()
    np.testing.assert_array_equal(pieces.points[2], [points["A"], points["B"]])
    spans = pieces.spans(edge_model(target).edge_points)
    np.testing.assert_array_equal(spans[0], [points["E"], points["F"]])


@pytest.mark.parametrize(("eye", "count"), [((-1, 0, 0), 4), ((-1, 0.9, 0), 7), ((-1, 0.9, 0.9), 9), ((1, 0, 0), 4)])
def test_a_box_shows_the_edges_of_the_faces_in_sight(eye: tuple[float, float, float], count: int) -> None:
    pieces = edge_model(box_target()).visible_pieces(np.eye(4), np.array(eye))
    assert len(pieces.edge) == len(set(pieces.edge)) == count


def test_a_panel_and_a_frame_are_seen_from_both_sides() -> None:
    for target in (panel_target(), frame_target()):
        model = edge_model(target)
        for x in (-1.0, 1.0):
            assert len(model.visible_pieces(np.eye(4), np.array([x, 0.1, 0.2])).edge) == len(model)
    one_sided = Target("panel", panel_target().points, edges=panel_target().edges, faces=panel_target().faces[:1])
    assert len(edge_model(one_sided).visible_pieces(np.eye(4), np.array([1.0, 0.0, 0.0])).edge) == 0


def test_edges_are_named_once() -> None:
    bars = frame_target()
    again = Target("twice", bars.points, edges=[*bars.edges, *((b, a) for a, b in bars.edges)])
    assert edge_model(again).names == edge_model(bars).names == tuple(f"{a}-{b}" for a, b in bars.edges)


def test_faces_at_a_grazing_angle_show_no_edges_to_measure_but_neighbours() -> None:
    model = edge_model(box_target((0.2, 0.2, 0.2)))
    # From 1.9 m before the front; beside it by 1.5 degrees of elevation above the side, then by 6.
    for degrees, count in ((1.5, 4), (6.0, 7)):
        eye = np.array([-2.0, 0.1 + 2.0 * np.tan(np.radians(degrees)), 0.0])
        assert len(model.visible_pieces(np.eye(4), eye).edge) == count
        assert len(model.visible_pieces(np.eye(4), eye, grazing=True).edge) == 7


def test_neighbours_are_those_a_few_pixels_beside() -> None:
    cameras = RectifiedCameras(500.0, np.zeros((1, 3)), np.eye(3))
    # At 1 m: two parallel lines 3 px apart, one 20 px off, one across them all.
    ends = np.array([[[-100, 0], [100, 0]], [[-90, 3], [90, 3]], [[-100, 23], [100, 23]], [[0, -50], [0, 50]]])
    points = {f"{i}{j}": (*ends[i, j] / 500.0, 1.0) for i in range(4) for j in range(2)}
    model = edge_model(Target("lines", points, edges=[(f"{i}0", f"{i}1") for i in range(4)]))
    separation = neighbour_separation(cameras, np.eye(4), model)
    np.testing.assert_allclose(separation, [[3.0, 3.0, 0.0, 0.0]], atol=1e-9)
