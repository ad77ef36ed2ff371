"""Rendered edges and lights lie where the camera model and physics put them."""

from __future__ import annotations

import attrs
import cv2
import numpy as np
import pytest
from rvdnav.camera import CameraModel
from rvdnav.pose.so3 import inverse_T
from rvdnav.rig import Rig
from rvdnav.simulation import Background, Course, Lights, Motion, Scenario, box_target, bracket_target, scene
from rvdnav.simulation.lens import RayTable
from rvdnav.simulation.mesh import Material, Part, frame, polygon
from rvdnav.simulation.patterns import PixelPatterns
from rvdnav.simulation.render import Renderer
from rvdnav.simulation.rounding import rounded_frame
from rvdnav.simulation.solids import solid
from rvdnav.simulation.spacecraft import BRACKET_REFLECTANCE
from rvdnav.simulation.variant import load_mitsuba, usable_variant

LEFT = CameraModel(704, 576, 668.42, 669.15, 356.83, 283.41, [-0.2034, 0.0617, 0.00052, -0.00041])
RIGHT = CameraModel(704, 576, 671.96, 672.31, 347.27, 291.94, [-0.1987, 0.0583, -0.00038, 0.00055])
AXES = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
RIG = Rig((LEFT, RIGHT), (AXES + 0.12 * np.eye(4)[2][:, None] * np.eye(4)[3], AXES))


def scenario(**changes) -> Scenario:
    place = Motion(x=Course(0.6, 0.6), z=Course(-0.12, -0.12), theta=Course(0.1, 0.1), psi=Course(0.05, 0.05))
    target = bracket_target("bracket", 0.18, 0.09, 0.14, 0.014, 0.006)
    made = Scenario(name="test", seed=1, frames=1, rate=8.0, rig=RIG, target=target, motion=place, samples=49)
    return attrs.evolve(made, **changes)


def test_rays_inside_the_pixels_are_the_camera_models():
    rng = np.random.default_rng(1)
    for columns, rows in (
        (slice(0, 30), slice(0, 20)),
        (slice(674, 704), slice(556, 576)),
        (slice(340, 370), slice(280, 300)),
    ):
        du, dv = rng.uniform(-0.5, 0.5, (2, 20, 30, 3))
        rays = RayTable(LEFT, columns, rows).rays(slice(0, 20), du, dv)
        v, u = np.mgrid[rows, columns].astype(float)
        expected = np.stack([u[..., None] + du, v[..., None] + dv], axis=-1)
        seen = cv2.projectPoints(rays.reshape(-1, 3), np.zeros(3), np.zeros(3), LEFT.K, LEFT.distortion)[0]
        np.testing.assert_allclose(seen.reshape(expected.shape), expected, atol=1e-5)


@pytest.mark.parametrize("samples", [1, 2, 9, 16, 37])
def test_rays_are_spread_over_cells_rows_and_columns(samples):
    rng = np.random.default_rng(2)
    u, v = (0.5 + offset for offset in PixelPatterns(samples, rng).draw((7, 5), rng))
    assert u.shape == v.shape == (7, 5, samples)
    assert 0.0 <= min(u.min(), v.min()) <= max(u.max(), v.max()) < 1.0
    side = int(samples**0.5)
    u, v = u[..., : side * side], v[..., : side * side]
    cells = np.floor(side * u) * side + np.floor(side * v)
    for strata in (cells, np.floor(side * side * u), np.floor(side * side * v)):
        np.testing.assert_array_equal(np.sort(strata, axis=2), np.broadcast_to(np.arange(side * side), strata.shape))
    assert samples == 1 or len(np.unique(u[..., 0])) > 30  # every pixel has its own


def edge_pixels(camera: int, ends: tuple[str, str], made: Scenario, depth: float = 0.0) -> np.ndarray:
    """Pixels (200, 2) along an edge of the target, or of the bars' back, by OpenCV."""
    a, b = (made.target.points[name] + (depth, 0.0, 0.0) for name in ends)
    points = a + np.linspace(0.0, 1.0, 200)[:, None] * (b - a)
    T = inverse_T(made.rig.T_world_cam[camera]) @ made.T_world_target(0)
    model = made.rig.cameras[camera]
    return cv2.projectPoints(points, cv2.Rodrigues(T[:3, :3])[0], T[:3, 3], model.K, model.distortion)[0].reshape(-1, 2)


EDGES = [
    (0, ("P1", "P2"), 0.0, 0.5, 0),
    (1, ("P1", "P2"), 0.0, 0.5, 0),
    (0, ("P4", "P1"), 0.006, 0.8, 1),  # the left camera sees a little of this bar's outer side
    (1, ("P4", "P1"), 0.0, 0.8, 1),
    (1, ("P2", "P3"), 0.0, 0.25, 1),
]


@pytest.mark.parametrize(("camera", "ends", "depth", "share", "axis"), EDGES)
def test_edges_against_the_sky_lie_where_the_camera_projects_them(camera, ends, depth, share, axis):
    """The part of a row (axis 0) or column (axis 1) that the bar covers ends at the edge."""
    made = scenario()
    along = edge_pixels(camera, ends, made, depth)
    u, v = along[round(share * 199)].round().astype(int)
    half = (7, 10) if axis == 0 else (10, 7)
    columns, rows = slice(u - half[0], u + half[0] + 1), slice(v - half[1], v + half[1] + 1)
    light = Renderer(load_mitsuba("scalar_rgb"), made, columns=columns, rows=rows).render(0, camera)
    across, start = (1, columns.start) if axis == 0 else (0, rows.start)
    solid = 1.0 - light.sky
    covered_first = solid.take(0, axis=across).mean() > 0.5
    found = start - 0.5 + (solid if covered_first else light.sky).sum(axis=across)
    lines = np.arange(rows.start, rows.stop) if axis == 0 else np.arange(columns.start, columns.stop)
    order = np.argsort(along[:, 1 - axis])
    expected = np.interp(lines, along[order, 1 - axis], along[order, axis])
    assert np.abs(found - expected).max() < 0.1  # 49 rays a pixel
    assert abs((found - expected).mean()) < 0.015


def white_card(monkeypatch, made: Scenario) -> None:
    """In place of the target, a card of 0.2 m of the reference reflectance, held towards the cameras."""
    corners = [(0.0, y, z) for y, z in ((-0.1, -0.1), (-0.1, 0.1), (0.1, 0.1), (0.1, -0.1))]
    middle = np.mean(list(made.target.points.values()), axis=0)
    card = Part(polygon(middle + corners), Material(BRACKET_REFLECTANCE))
    monkeypatch.setattr(scene, "target_parts", lambda *_: [card])


@pytest.mark.parametrize(
    "lights",
    [Lights(1.0, 0.0, 0.0), Lights(0.0, 1.0, 0.0, (-1.0, 0.5, 0.3)), Lights(0.0, 0.0, 1.0)],
    ids=["led", "sun", "ambient"],
)
def test_a_card_of_the_reference_reflectance_gives_the_unit_of_light(monkeypatch, lights):
    place = Motion(x=Course(0.8, 0.8), z=Course(0.06, 0.06))
    made = scenario(lights=lights, motion=place, target=box_target("box", np.array([0.1, 0.1, 0.1])), samples=16)
    white_card(monkeypatch, made)
    u, v = made.rig.project(0, np.array([0.8, 0.0, 0.06])).round().astype(int)
    renderer = Renderer(load_mitsuba("scalar_rgb"), made, columns=slice(u - 4, u + 4), rows=slice(v - 4, v + 4))
    signal = renderer.render(0, 0).signal
    assert signal.mean() == pytest.approx(1.0, abs=0.02)
    assert signal.std() < (0.03 if lights.ambient else 0.01)  # the renderer's own noise stays below the sensor's


def test_the_earths_limb_lies_where_its_angle_puts_it(monkeypatch):
    made = scenario(background=Background.EARTH, nadir_W=(0.45, 1.0, 0.1), samples=1)
    made = attrs.evolve(
        made, lights=Lights(0.0, 1.0, 0.0, (-0.3, -1.0, 0.0)), target=box_target("box", np.full(3, 0.01))
    )
    column = 600
    rays = LEFT.unproject(np.column_stack([np.full(576, column), np.arange(576.0)])) @ RIG.T_world_cam[0][:3, :3].T
    angles = np.degrees(np.arccos(rays @ made.nadir_W / np.linalg.norm(rays, axis=1)))
    radius = np.degrees(np.arcsin(6371.0 / 6871.0))
    limb = int(np.argmin(np.abs(angles - radius)))
    assert 60 < limb < 516
    renderer = Renderer(load_mitsuba("scalar_rgb"), made, columns=slice(column, column + 2), rows=slice(0, 576))
    brightness = renderer.render(0, 0).signal.mean(axis=1)
    assert brightness[limb + 8 :].min() > 0.1
    assert brightness[: limb - 40].max() < 0.02
    rising = int(np.argmax(brightness > 0.5 * brightness[limb + 8]))
    assert abs(rising - limb) < 8  # the air is some pixels high


@pytest.mark.skipif(usable_variant().startswith("scalar"), reason="there is no LLVM library of version 19 or later")
def test_the_fast_variant_gives_the_same_picture_and_the_same_bits_again():
    made = scenario()
    u, v = edge_pixels(0, ("P1", "P2"), made)[100].round().astype(int)
    window = {"columns": slice(u - 12, u + 4), "rows": slice(v - 8, v + 8)}
    slow = Renderer(load_mitsuba("scalar_rgb"), made, **window).render(0, 0)
    fast, again = (Renderer(load_mitsuba(usable_variant()), made, **window).render(0, 0) for _ in range(2))
    np.testing.assert_array_equal(fast.signal, again.signal)
    np.testing.assert_array_equal(fast.sky, again.sky)
    assert np.abs(fast.sky - slow.sky).max() < 0.03  # a ray that grazes the edge may fall to either side of it
    assert fast.signal.mean() == pytest.approx(slow.signal.mean(), rel=0.01)
    assert np.abs(fast.signal - slow.signal).mean() < 0.02


MOVING = Motion(x=Course(0.6, 0.6), z=Course(-0.12, -0.02), y=Course(0.0, 0.05), theta=Course(0.1, 0.1))
"""0.1 m and 0.05 m in the second between two frames at 1 Hz: some 67 rows and columns."""


@pytest.mark.parametrize(
    "timing",
    [
        {"line_delay_ns": 2_000_000},
        {"scan": "top_field_first", "field_delay_ns": 20_000_000},
        {"scan": "bottom_field_first", "field_delay_ns": 30_000_000, "line_delay_ns": 1_000_000},
        {"exposure_ns": 40_000_000},
    ],
    ids=["rolling", "top", "bottom", "exposure"],
)
def test_every_row_shows_its_own_moment(timing):
    """The edge in each row is where the camera projects it at that row's time, and blurred by the motion about it."""
    made = scenario(motion=MOVING, rate=1.0, frames=2, rig=attrs.evolve(RIG, **timing), samples=64)
    ends, half = ("P1", "P2"), (12, 9)
    along = np.linspace(0.0, 1.0, 400)[:, None]

    def crossing(row: int, delay: float) -> float:
        T = inverse_T(made.rig.T_world_cam[0]) @ made.T_world_target(0, delay)
        a, b = (T[:3, :3] @ made.target.points[name] + T[:3, 3] for name in ends)
        line = made.rig.cameras[0].project(a + along * (b - a))
        order = np.argsort(line[:, 1])
        return float(np.interp(row, line[order, 1], line[order, 0]))

    delays, exposure = 1e-9 * made.rig.row_delays_ns, 1e-9 * made.rig.exposure_ns
    v = round(edge_pixels(0, ends, made)[100, 1])
    u = round(crossing(v, delays[v]))
    columns, rows = slice(u - half[0], u + half[0] + 1), slice(v - half[1], v + half[1] + 1)
    light = Renderer(load_mitsuba("scalar_rgb"), made, columns=columns, rows=rows).render(0, 0)
    solid = 1.0 - light.sky
    covered_first = solid[:, 0].mean() > 0.5
    found = columns.start - 0.5 + (solid if covered_first else light.sky).sum(axis=1)
    lines = range(rows.start, rows.stop)
    expected = np.array([crossing(row, delays[row]) for row in lines])
    at_rest = np.array([crossing(row, 0.0) for row in lines])
    spread = [
        abs(crossing(row, delays[row] + exposure / 2) - crossing(row, delays[row] - exposure / 2)) for row in lines
    ]
    assert np.abs(found - expected).max() < 0.15
    assert abs((found - expected).mean()) < 0.03
    assert np.ptp(expected - at_rest) > 1.0 or min(spread) > 2.0
    partly = ((solid > 0.02) & (solid < 0.98)).sum(axis=1)
    assert np.abs(partly - np.array(spread)).max() < 2.5


def test_the_scalar_variant_moves_as_the_fast_one_does():
    if usable_variant().startswith("scalar"):
        pytest.skip("there is no LLVM library of version 19 or later")
    made = scenario(motion=MOVING, rate=1.0, frames=2, rig=attrs.evolve(RIG, exposure_ns=40_000_000), samples=16)
    u, v = edge_pixels(0, ("P1", "P2"), made)[100].round().astype(int)
    window = {"columns": slice(u - 12, u + 4), "rows": slice(v - 4, v + 4)}
    slow, fast = (
        Renderer(load_mitsuba(name), made, **window).render(0, 0) for name in ("scalar_rgb", usable_variant())
    )
    assert np.abs(fast.sky - slow.sky).max() < 0.07


def closed(mesh) -> float:
    """Volume, m³, by the divergence theorem, of a mesh that looks outwards."""
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def test_a_frame_with_rounded_edges_has_the_volume_of_one():
    bracket = scenario().target.bracket
    radius = 0.002
    sharp = closed(frame(bracket.outer, bracket.inner, bracket.thickness))
    rounded = rounded_frame(bracket.outer, bracket.inner, bracket.thickness, radius)
    # What is cut off an edge has the area r² (1 - pi/4) about its centroid, which lies 0.2234 r inside both faces; the
    # eight steps of the quarter circle cut off a little more.
    area = radius**2 * (1.0 - np.pi / 4.0) + 0.5 * radius**2 * (np.pi / 2.0 - 8.0 * np.sin(np.pi / 16.0))
    length = 0.0
    for loop, sign in ((bracket.outer, -1.0), (bracket.inner, 1.0)):
        sides = np.roll(loop, -1, axis=0) - loop
        lengths = np.linalg.norm(sides, axis=1)
        directions = sides / lengths[:, None]
        turns = np.arccos(np.einsum("ij,ij->i", np.roll(directions, 1, axis=0), directions))
        length += lengths.sum() + sign * 2.0 * (0.2234 * radius) * np.tan(turns / 2.0).sum()
    assert sharp - closed(rounded) == pytest.approx(2.0 * area * length, rel=0.01)
    # Seen along x the outline is the sharp one's, and no point is outside it.
    np.testing.assert_allclose(
        np.ptp(rounded.vertices, axis=0), [bracket.thickness, *np.ptp(bracket.outer, axis=0)[1:]]
    )


def test_a_rounded_box_has_its_volume_and_its_extent():
    size, radius = np.array([0.1, 0.15, 0.2]), 0.01
    made = attrs.evolve(box_target("box", size), edge_radius=radius)
    faces, between = solid(made)
    inside = size - 2.0 * radius
    area = 2.0 * (inside[0] * inside[1] + inside[1] * inside[2] + inside[2] * inside[0])
    exact = np.prod(inside) + area * radius + np.pi * radius**2 * inside.sum() + 4.0 / 3.0 * np.pi * radius**3
    volume = sum(closed(face) for face in faces) + closed(between)
    assert volume == pytest.approx(exact, rel=1e-3)
    np.testing.assert_allclose(np.abs(between.vertices).max(axis=0), 0.5 * size, atol=1e-12)
    centers = np.clip(between.vertices, -0.5 * inside, 0.5 * inside)
    np.testing.assert_allclose(np.linalg.norm(between.vertices - centers, axis=1), radius, rtol=1e-9)


@pytest.mark.parametrize(
    ("target", "fault"),
    [
        (attrs.evolve(box_target("box", np.array([0.1, 0.1, 0.1])), edge_radius=0.05), "leaves nothing of a face"),
        (attrs.evolve(bracket_target("b", 0.18, 0.09, 0.14, 0.014, 0.006), edge_radius=0.003), "is half of a bar's"),
        (
            attrs.evolve(box_target("box", np.full(3, 0.1)), edge_radius=0.01, faces=[("B0", "B1", "B3", "B2")]),
            "three faces",
        ),
    ],
)
def test_edges_that_cannot_be_rounded(target, fault):
    with pytest.raises(ValueError, match=fault):
        scenario(target=target)
