"""Scenario files: what they give, and that every fault is named."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
import pytest
from conftest import CAMCHAIN, TARGET
from rvdnav.cli.app import execute
from rvdnav.errors import InputError
from rvdnav.simulation import Background, Course, Motion, box_target, bracket_target, load_scenario
from rvdnav.simulation.mesh import box, cylinder, frame, prism
from rvdnav.target import load_target
from rvdnav.target_writer import save_target
from scipy.spatial.transform import Rotation

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "scenarios"
SCENARIO = """\
name: small
seed: 3
frames: 5
rate_hz: 4
rig: rig
target:
  bracket: {long_base_mm: 180, short_base_mm: 90, height_mm: 140, bar_width_mm: 14, bar_thickness_mm: 6}
motion:
  x_m: {start: 1.5, end: 0.5, ease: 1.0}
  z_m: {start: 0.1, amplitude: 0.02, period_s: 2.0, phase_deg: 90}
  phi_deg: 10
lights: {led: 0.5, sun: 1.0, towards_sun_W: [-2, 0, 0]}
background: {kind: earth, nadir_W: [0, 3, 0]}
sensor: {read_noise_dn: 2.0}
samples_per_pixel: 4
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "rig").mkdir()
    (tmp_path / "rig" / "camchain.yaml").write_text(CAMCHAIN)
    (tmp_path / "target.yaml").write_text(TARGET)
    return tmp_path


def written(folder, text=SCENARIO, old="", new=""):
    assert old in text
    (folder / "scenario.yaml").write_text(text.replace(old, new, 1) if old else text)
    return folder / "scenario.yaml"


def test_a_file_gives_its_scenario(folder):
    scenario = load_scenario(written(folder))
    assert (scenario.name, scenario.seed, scenario.frames, scenario.rate, scenario.samples) == ("small", 3, 5, 4.0, 4)
    assert scenario.background is Background.EARTH
    np.testing.assert_array_equal(scenario.nadir_W, [0.0, 1.0, 0.0])
    np.testing.assert_array_equal(scenario.lights.towards_sun_W, [-1.0, 0.0, 0.0])
    assert (scenario.lights.led, scenario.lights.sun, scenario.lights.ambient) == (0.5, 1.0, 0.01)
    assert (scenario.sensor.read_noise, scenario.sensor.prnu) == (2.0, 0.006)
    assert [scenario.timestamp_ns(frame) for frame in (0, 1)] == [1_700_000_000_000_000_000, 1_700_000_000_250_000_000]
    # At rest at both ends, half the way at half the time; the sine starts at its crest and has run half a period.
    np.testing.assert_allclose(scenario.T_world_target(0)[:3, 3], [1.5, 0.0, 0.12])
    np.testing.assert_allclose(scenario.T_world_target(2)[:3, 3], [1.0, 0.0, 0.1])
    np.testing.assert_allclose(scenario.T_world_target(4)[:3, 3], [0.5, 0.0, 0.08])
    # phi is applied in the sense of the paper's equation (9): minus phi about x in the right-handed sense.
    np.testing.assert_allclose(
        scenario.T_world_target(0)[:3, :3], Rotation.from_euler("x", -10, degrees=True).as_matrix()
    )


def test_speed_varies_as_much_as_ease_says():
    steps = {}
    for ease in (0.0, 0.5, 1.0):
        course = Course(start=1.5, end=0.5, ease=ease)
        values = np.array([course.at(t, 2.0) for t in np.linspace(0.0, 2.0, 201)])
        assert values[0] == 1.5
        assert values[-1] == pytest.approx(0.5)
        steps[ease] = -np.diff(values)
    np.testing.assert_allclose(steps[0.0], 0.005)
    assert steps[0.5].max() == pytest.approx(0.00625, rel=1e-3)
    assert steps[1.0].max() == pytest.approx(0.0075, rel=1e-3)
    assert steps[1.0][0] < 1e-4


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("name: small\n", "", "name is missing"),
        ("seed: 3", "seed: -1", "seed is not a whole number from 0 to"),
        ("seed: 3", "seed: 1.5", "seed is not a whole number"),
        ("frames: 5", "frames: 0", "frames is not a whole number from 1 to 10000"),
        ("rate_hz: 4", "rate_hz: 0", "rate_hz is less than"),
        ("rig: rig", "rig: nowhere", "rig '.*nowhere' is not a folder"),
        ("name: small", "name: small\ncolour: red", "colour is not known; the keys are name, seed"),
        ("  bracket:", "  brackett:", "target.brackett is not known; did you mean bracket?"),
        ("  bracket:", "  box: {size_mm: [1, 1, 1]}\n  bracket:", "target needs exactly one of"),
        ("short_base_mm: 90", "short_base_mm: 14", "target.bracket is impossible: the bars fill the bracket"),
        ("height_mm: 140, ", "", "target.bracket.height_mm is missing"),
        ("bar_width_mm: 14", "bar_width_mm: -14", "target.bracket is impossible: a size is not positive"),
        ("  x_m: {start: 1.5, end: 0.5, ease: 1.0}\n", "", "motion.x_m is missing"),
        ("ease: 1.0", "ease: 2.0", "motion.x_m.ease is not between 0 and 1"),
        ("ease: 1.0", "speed: 1.0", "motion.x_m.speed is not known"),
        ("period_s: 2.0", "period_s: 0", "motion.z_m.period_s is not positive"),
        (", period_s: 2.0", "", "motion.z_m.period_s is missing"),
        ("phi_deg: 10", "roll: 10", "motion.roll is not known"),
        ("phi_deg: 10", "phi_deg: .nan", "motion.phi_deg is not finite"),
        ("end: 0.5", "end: -0.5", "the target is behind a camera in frame 3"),
        ("led: 0.5", "led: -0.5", "lights.led is negative"),
        (", towards_sun_W: [-2, 0, 0]", "", "lights.towards_sun_W is missing"),
        ("[-2, 0, 0]", "[0, 0, 0]", "lights.towards_sun_W has no length"),
        ("{led: 0.5, sun: 1.0, towards_sun_W: [-2, 0, 0]}", "{led: 0, ambient: 0}", "lights: there is no light"),
        ("kind: earth", "kind: moon", "background.kind 'moon' is none of stars, earth, wall"),
        ("kind: earth", "kind: wall", "background.nadir_W belongs to the background 'earth'"),
        ("kind: earth, nadir_W: [0, 3, 0]", "kind: wall, distance_m: 0", "background.distance_m is less than"),
        ("read_noise_dn", "read_noise", "sensor.read_noise is not known"),
        ("{read_noise_dn: 2.0}", "{level_dn: 0.5}", "sensor.level_dn is less than 1"),
        ("{read_noise_dn: 2.0}", "{prnu: -1}", "sensor.prnu is negative"),
        ("{read_noise_dn: 2.0}", "{gamma: 0}", "sensor.gamma is less than 0.05"),
        ("bar_thickness_mm: 6", "bar_thickness_mm: 6, edge_radius_mm: 3", "edge_radius is half of a bar's width or"),
        (
            "bar_thickness_mm: 6",
            "bar_thickness_mm: 6, edge_radius_mm: -3",
            "bracket is impossible: edge_radius is not a length",
        ),
        ("seed: 3", "seed: 3\nfiles: {calibration: [1, 2]}", "files.calibration is not a list of 3 numbers"),
        ("seed: 3", "seed: 3\nfiles: {calibration: [1, 2, -1]}", "files.calibration is negative"),
        ("seed: 3", "seed: 3\nfiles: {tolerance_mm: 1000}", "the tolerance of P1 is not between 0"),
        ("seed: 3", "seed: 3\nfiles: {omit: [seed]}", "files.omit 'seed' is none of timing, edge_radius"),
        ("seed: 3", "seed: 3\nfiles: {target_points_mm: 500}", "the bracket's points"),
        ("samples_per_pixel: 4", "samples_per_pixel: none", "samples_per_pixel is not a number"),
    ],
)
def test_every_fault_is_named(folder, capsys, old, new, fault):
    path = written(folder, old=old, new=new)
    with pytest.raises(InputError, match=rf"scenario\.yaml: .*{fault}"):
        load_scenario(path)
    assert execute(["simulate", str(path), "--out", str(folder / "out")]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert not (folder / "out").exists()


def test_a_target_may_come_from_a_file(folder):
    inline = "bracket: {long_base_mm: 180, short_base_mm: 90, height_mm: 140, bar_width_mm: 14, bar_thickness_mm: 6}"
    scenario = load_scenario(written(folder, old=inline, new="file: target.yaml"))
    assert scenario.target == load_target(folder / "target.yaml")
    with pytest.raises(InputError, match=r"nothing\.yaml: no such file"):
        load_scenario(written(folder, old=inline, new="file: nothing.yaml"))
    (folder / "wire.yaml").write_text(
        "name: w\nunits: m\npoints: {A: [0,0,0], B: [1,0,0], C: [0,1,0]}\nedges: [[A, B]]\n"
    )
    with pytest.raises(InputError, match="neither a four-bar bracket nor faces"):
        load_scenario(written(folder, old=inline, new="file: wire.yaml"))


def test_the_bracket_of_given_sizes_is_the_papers(folder):
    made = bracket_target("test-bracket", 0.18, 0.09, 0.14, 0.014, 0.006)
    read = load_target(folder / "target.yaml")
    assert made.points.keys() == read.points.keys()
    for name, point in made.points.items():
        np.testing.assert_allclose(point, read.points[name], atol=1e-9)
    assert (made.lines, made.bars, made.bar_thickness) == (read.lines, read.bars, read.bar_thickness)


@pytest.mark.parametrize(
    "target",
    [
        bracket_target("yes", 0.24, 0.15, 0.12, 0.02, 0.008),
        box_target("a box: of 3 sizes", np.array([0.2, 0.3, 0.25])),
        attrs.evolve(box_target("soap", np.array([0.2, 0.3, 0.25])), edge_radius=0.0125),
    ],
    ids=["bracket", "box", "rounded"],
)
def test_a_target_is_written_as_it_is_read(tmp_path, target):
    save_target(target, tmp_path / "target.yaml")
    read = load_target(tmp_path / "target.yaml")
    for name, point in target.points.items():
        np.testing.assert_allclose(read.points[name], point, atol=1e-12)
    for part in ("name", "lines", "bars", "bar_thickness", "edge_radius", "edges", "faces", "dimensions_known"):
        assert getattr(read, part) == getattr(target, part)


def test_a_box_has_twelve_edges_and_six_faces_that_look_outwards():
    target = box_target("box", np.array([0.2, 0.3, 0.25]))
    lengths = sorted(round(float(np.linalg.norm(target.points[a] - target.points[b])), 9) for a, b in target.edges)
    assert lengths == [0.2] * 4 + [0.25] * 4 + [0.3] * 4
    for face in target.faces:
        a, b, c, _ = (target.points[name] for name in face)
        assert np.cross(b - a, c - b) @ a > 0.0


def volume(mesh) -> float:
    """By the divergence theorem: right only for a closed surface whose triangles all look outwards."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def test_solids_are_closed_and_look_outwards():
    shift = np.array([0.3, -0.2, 0.5])
    assert volume(box(shift, shift + np.array([0.1, 0.2, 0.3]))) == pytest.approx(0.006)
    outer, inner = (np.array([[0, -s, -s], [0, s, -s], [0, s, s], [0, -s, s]]) + shift for s in (0.2, 0.15))
    assert volume(frame(outer, inner, 0.01)) == pytest.approx((0.4**2 - 0.3**2) * 0.01)
    assert volume(prism(outer[::-1], 0.01)) == pytest.approx(0.4**2 * 0.01)
    assert volume(cylinder(shift, 0.1, 0.2, sides=360)) == pytest.approx(np.pi * 0.01 * 0.2, rel=1e-3)
    assert volume(cylinder(shift, 0.1, 0.2, hole=0.05, sides=360)) == pytest.approx(np.pi * 0.0075 * 0.2, rel=1e-3)


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.yaml")), ids=lambda path: path.stem)
def test_the_examples_are_sound(path):
    scenario = load_scenario(path)
    assert scenario.name == path.stem
    assert scenario.frames >= 16


def test_the_papers_run_covers_its_range_with_its_motion():
    scenario = load_scenario(EXAMPLES / "paper.yaml")
    x, y, z = np.array([scenario.T_world_target(frame)[:3, 3] for frame in range(scenario.frames)]).T
    assert (x[0], x[-1]) == (pytest.approx(1.5), pytest.approx(0.3))
    speed = -np.diff(x) * scenario.rate
    assert speed.max() > 2.0 * speed.min() > 0.0
    assert 0.035 < np.ptp(z) < 0.045
    assert np.abs(y).max() < 0.01
    assert isinstance(scenario.motion, Motion)
