from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml
from conftest import TARGET
from rvdnav.errors import InputError
from rvdnav.target import EDGE_NAMES, Bar, Target, load_target
from rvdnav.trapezoid import Trapezoid

BOX = """\
name: box
units: m
points:
  a: [0, 0, 0]
  b: [0.2, 0, 0]
  c: [0.2, 0.3, 0]
  d: [0, 0.3, 0]
  e: [0, 0, 0.4]
edges: [[a, b], [b, c], [c, d], [d, a], [a, e]]
faces: [[a, b, c, d]]
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "target.yaml"
    path.write_text(text)
    return path


def test_bracket_in_metres(tmp_path: Path) -> None:
    target = load_target(write(tmp_path, TARGET))
    assert target.name == "test-bracket"
    assert target.dimensions_known
    assert target.bars[0] == Bar("long_base", ("P1", "P2"), ("Q1", "Q2"))
    assert target.lines["l4"] == ("P4", "P1")
    assert target.bar_thickness == pytest.approx(0.006)
    np.testing.assert_allclose(target.points["P3"], [0.0, 0.045, 0.140])
    bracket = target.bracket
    assert bracket is not None
    np.testing.assert_array_equal(bracket.outer, [target.points[f"P{i}"] for i in (1, 2, 3, 4)])
    np.testing.assert_array_equal(bracket.inner, [target.points[f"Q{i}"] for i in (1, 2, 3, 4)])
    assert bracket.thickness == target.bar_thickness


def test_front_edges_in_their_order(tmp_path: Path) -> None:
    target = load_target(write(tmp_path, TARGET))
    ends = {
        "l1_outer": "P1 P2",
        "l1_inner": "Q1 Q2",
        "l2_outer": "P3 P4",
        "l2_inner": "Q3 Q4",
        "l3_outer": "P2 P3",
        "l3_inner": "Q2 Q3",
        "l4_outer": "P4 P1",
        "l4_inner": "Q4 Q1",
    }
    assert tuple(ends) == EDGE_NAMES
    assert target.bracket is not None
    expected = [[target.points[name] for name in pair.split()] for pair in ends.values()]
    np.testing.assert_array_equal(target.bracket.edge_points, expected)


def test_bracket_is_found_by_topology_not_by_the_names_of_its_points(tmp_path: Path) -> None:
    text = TARGET.replace("P", "corner_").replace("Q", "inside_")
    text = text.replace("outer: [corner_2, corner_3], inner: [inside_2, inside_3]",
                        "outer: [corner_3, corner_2], inner: [inside_3, inside_2]")  # fmt: skip
    text = text.replace("l2: [corner_3, corner_4]", "l2: [corner_4, corner_3]")
    renamed, plain = load_target(write(tmp_path, text)).bracket, load_target(write(tmp_path, TARGET)).bracket
    assert renamed is not None
    assert plain is not None
    np.testing.assert_array_equal(renamed.edge_points, plain.edge_points)


def test_sizes_of_the_bracket(tmp_path: Path) -> None:
    bracket = load_target(write(tmp_path, TARGET)).bracket
    assert bracket is not None
    assert bracket.long_base == pytest.approx(0.180)
    assert bracket.short_base == pytest.approx(0.090)
    np.testing.assert_allclose(bracket.heights, 0.140)
    np.testing.assert_allclose(bracket.bar_widths, 0.014, atol=1e-9)


def test_shared_target(shared_data: Path) -> None:
    target = load_target(shared_data / "sequences" / "approach" / "target.yaml")
    assert target.name == "bracket-180"
    assert target.bracket is not None


def test_any_straight_edged_target(tmp_path: Path) -> None:
    target = load_target(write(tmp_path, BOX))
    assert target.bracket is None
    assert target.edges[-1] == ("a", "e")
    assert target.faces == (("a", "b", "c", "d"),)
    np.testing.assert_array_equal(target.points["c"], [0.2, 0.3, 0.0])


def test_unknown_dimensions(tmp_path: Path) -> None:
    assert not load_target(write(tmp_path, TARGET + "dimensions: unknown\n")).dimensions_known
    assert load_target(write(tmp_path, TARGET + "dimensions: known\n")).dimensions_known


def without_coordinates(points: str) -> str:
    """The bracket's file with only names and topology."""
    kept = [
        line for line in TARGET.splitlines() if not line.startswith(("  P", "  Q", "long_", "short_", "height", "bar_"))
    ]
    return "\n".join(kept).replace("points:", points) + "\ndimensions: unknown\n"


@pytest.mark.parametrize("points", ["points: [P1, P2, P3, P4, Q1, Q2, Q3, Q4]", "points: [Q1]", ""])
def test_unknown_dimensions_need_names_and_topology_alone(tmp_path: Path, points: str) -> None:
    target = load_target(write(tmp_path, without_coordinates(points)))
    assert not target.dimensions_known
    assert target.bar_thickness == 0.0
    assert set(target.points) == {"P1", "P2", "P3", "P4", "Q1", "Q2", "Q3", "Q4"}
    shape = Trapezoid(0.18, 0.09, 0.14, 0.014, 0.014, 0.014)
    sized, known = target.resized(shape), load_target(write(tmp_path, TARGET))
    assert sized.dimensions_known
    assert sized.bar_thickness == pytest.approx(0.007)
    for name, point in known.points.items():
        np.testing.assert_allclose(sized.points[name], point, atol=1e-9)


def test_sizes_beside_unknown_dimensions_are_not_read(tmp_path: Path) -> None:
    text = TARGET.replace("long_base: 180.0", "long_base: 999").replace("[0.0, -90.0, 0.0]", "[1, 2, 3]")
    target = load_target(write(tmp_path, text + "dimensions: unknown\n"))
    assert target.bar_thickness == pytest.approx(0.006)
    assert not np.allclose(target.points["P1"], [1e-3, 2e-3, 3e-3])


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("points: []", "points: [P1, X]", "points has 'X', which is no corner"),
        ("l2: [P3, P4]", "l5: [P3, P4]", "dimensions can be unknown only for a four-bar bracket"),
        ("points: []", "points: 7", "points is not a mapping"),
        ("outer: [P1, P2], inner", "outer: [P1, P3], inner", "0 bars lie along line l1"),
    ],
)
def test_malformed_unknown_dimensions(tmp_path: Path, old: str, new: str, fault: str) -> None:
    text = without_coordinates("points: []")
    assert old in text
    with pytest.raises(InputError, match=fault):
        load_target(write(tmp_path, text.replace(old, new, 1)))


@pytest.mark.parametrize("value", ["180.15", "180.0"])
def test_stated_sizes_may_be_rounded(tmp_path: Path, value: str) -> None:
    load_target(write(tmp_path, TARGET.replace("long_base: 180.0", f"long_base: {value}")))


FAULTS = [
    ("units: mm\n", "", "units is missing"),
    ("units: mm", "units: inch", "units 'inch' is not supported"),
    ("name: test-bracket\n", "", "name is missing"),
    ("bar_thickness: 6.0\n", "", "bar_thickness is missing"),
    ("bar_thickness: 6.0", "bar_thickness: -6.0", "bar_thickness is not a length"),
    ("points:", "spots:", "spots is not known; did you mean points?"),
    ("P1: [0.0, -90.0, 0.0]", "P1: [0.0, -90.0]", "points.P1 is not a list of 3 numbers"),
    ("P1: [0.0, -90.0, 0.0]", "P1: [0.0, .nan, 0.0]", "points.P1 is not finite"),
    ("P1: [0.0, -90.0, 0.0]", "P1: [0.0, 90.0, 0.0]", "points P1 and P2 coincide"),
    ("  P1: [0.0, -90.0, 0.0]\n", "", "unknown point 'P1'"),
    ("l1: [P1, P2]", "l1: [P1, P9]", "line l1 names an unknown point 'P9'"),
    ("l1: [P1, P2]", "l1: [P1]", "lines.l1 needs two names"),
    ("l1: [P1, P2]", "l1: [P1, P1]", "line l1 names a point twice"),
    ("l1: [P1, P2]", "l1: [P1, P3]", "do not form a closed loop"),
    ("inner: [Q1, Q2]", "inner: [Q2, Q1]", "different inner points"),
    ("outer: [P1, P2], inner", "outer: [P1, P3], inner", "0 bars lie along line l1"),
    ("long_base: 180.0", "long_base: 181.0", "long_base is 181 but the points give 180"),
    ("short_base: 90.0", "short_base: 89.8", "short_base is 89.8 but the points give 90"),
    ("\nheight: 140.0", "\nheight: 141", "height is 141 but the points give 140"),
    ("bar_width: 14.0", "bar_width: 13.8", "bar_width is 13.8 but the points give 14"),
    ("long_base: 180.0", "long_base: wide", "long_base is not a number"),
    ("bars:", "beams:", "beams is not known; did you mean bars?"),
    ("name: long_base, outer", "outer", "bars[0].name is missing"),
    ("P3: [0.0, 45.0, 140.0]", "P3: [0.0, 90.0, 0.1]", "three of the bracket's points P1..P4 are collinear"),
    ("P3: [0.0, 45.0, 140.0]", "P3: [5.0, 45.0, 140.0]", "does not lie in a plane"),
    ("Q3: [0.0, 34.794559, 126.0]", "Q3: [0.0, 34.794559, 146.0]", "do not lie inside"),
    ("  P1:", "  1:", "a key that is not a text"),
]


@pytest.mark.parametrize(("old", "new", "fault"), FAULTS)
def test_malformed_target_is_one_clear_line(tmp_path: Path, old: str, new: str, fault: str) -> None:
    assert old in TARGET
    path = write(tmp_path, TARGET.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load_target(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert fault in message
    assert "\n" not in message


def flattened(text: str) -> str:
    """The bracket with every point on l1's line."""
    lines = text.splitlines()
    for i, line in enumerate(lines):
        if line.startswith(("  P", "  Q")):
            name, (_, y, z) = line[2:4], yaml.safe_load(line[6:])
            lines[i] = f"  {name}: [0.0, {y + 3 * z}, 0.0]"
    return "\n".join(lines)


def test_collinear_points(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="the points are collinear"):
        load_target(write(tmp_path, flattened(TARGET)))


def test_mirrored_bracket(tmp_path: Path) -> None:
    mirrored = load_target(write(tmp_path, TARGET))
    points = {name: point * (1.0, -1.0, 1.0) for name, point in mirrored.points.items()}
    with pytest.raises(ValueError, match="do not run from y to z"):
        Target("mirrored", points, mirrored.lines, mirrored.bars, mirrored.bar_thickness)


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("faces: [[a, b, c, d]]", "faces: [[a, b, c, e]]", "is not planar"),
        ("faces: [[a, b, c, d]]", "faces: [[a, b]]", "fewer than three"),
        ("faces: [[a, b, c, d]]", "faces: [[a, b, c, x]]", "unknown point 'x'"),
        ("[a, e]]", "[a, e, b]]", "edges needs two names"),
        ("[a, e]]", "a]", "edges is not a list of lists"),
        ("units: m\n", "units: m\ndimensions: guessed\n", "neither 'known' nor 'unknown'"),
    ],
)
def test_malformed_edges_and_faces(tmp_path: Path, old: str, new: str, fault: str) -> None:
    with pytest.raises(InputError, match=fault):
        load_target(write(tmp_path, BOX.replace(old, new)))


@pytest.mark.parametrize(
    ("stated", "sigma"),
    [
        ("", 3e-4),  # as measured with calipers
        ("tolerance: 0\n", 0.0),
        ("tolerance: 0.002\n", 2e-3),
        ("tolerance: {a: 0.001}\n", 1e-3),
        ("tolerance: {b: 0.001}\n", 3e-4),
        ("tolerance: 0\nedge_radius: 0.01\n", 4.142e-3),  # a silhouette that is seen over the corner
        ("tolerance: 0.003\nedge_radius: 0.01\n", 5.114e-3),
    ],
)
def test_how_well_a_point_is_known(tmp_path: Path, stated: str, sigma: float) -> None:
    target = load_target(write(tmp_path, BOX + stated))
    assert target.point_sigma("a") == pytest.approx(sigma, rel=1e-3)
