"""The sequence folder: complete or not there, the same bytes every time, also after an interruption."""

from __future__ import annotations

import sys

import attrs
import numpy as np
import pytest
import yaml
from conftest import CAMCHAIN
from rvdnav.cli.app import execute
from rvdnav.errors import InputError
from rvdnav.rig import load_rig
from rvdnav.sequence import open_sequence
from rvdnav.simulation import Course, Files, Motion, Scenario, box_target, simulate
from rvdnav.simulation.variant import load_mitsuba


@pytest.fixture
def scenario(tmp_path):
    (tmp_path / "rig").mkdir()
    (tmp_path / "rig" / "camchain.yaml").write_text(CAMCHAIN)
    motion = Motion(x=Course(0.9, 0.8), z=Course(0.06, 0.06), theta=Course(0.5, 0.6))
    target = box_target("box", np.array([0.2, 0.2, 0.2]))
    return Scenario("small", 1, 2, 8.0, load_rig(tmp_path / "rig"), target, motion, samples=2)


def contents(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def render(scenario, out, **options):
    return simulate(scenario, out, variant="scalar_rgb", **options)


def test_a_sequence_is_whole_and_true(scenario, tmp_path):
    steps = []
    assert render(scenario, tmp_path / "new" / "out", progress=lambda *step: steps.append(step))
    assert steps == [(0, 4), (1, 4), (2, 4), (3, 4), (4, 4)]
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["out"]
    sequence = open_sequence(tmp_path / "new" / "out")
    frames = list(sequence)
    assert sequence.notices == []
    assert [frame.timestamp_ns for frame in frames] == [scenario.timestamp_ns(0), scenario.timestamp_ns(1)]
    assert sequence.rig == scenario.rig
    assert sequence.target.faces == scenario.target.faces
    np.testing.assert_allclose(sequence.truth.at(scenario.timestamp_ns(1)), scenario.T_world_target(1), atol=2e-9)
    for frame in frames:
        for camera, image in enumerate((frame.left, frame.right)):
            u, v = scenario.rig.project(camera, frame_middle(sequence, frame)).round().astype(int)
            assert image.pixels[v - 2 : v + 3, u - 2 : u + 3].mean() > 40  # the box, lit
            assert np.median(image.pixels[:4]) < 8  # the sky


def frame_middle(sequence, frame):
    return sequence.truth.at(frame.timestamp_ns)[:3, 3]


def test_files_may_say_otherwise(scenario, tmp_path):
    target = attrs.evolve(scenario.target, edge_radius=0.004)
    rig = attrs.evolve(scenario.rig, exposure_ns=1_000_000, line_delay_ns=50_000)
    files = Files(calibration=(0.5, 3.0, 0.1), target_sizes_mm=1.0, tolerance_mm=0.7)
    told, silent = (
        attrs.evolve(scenario, target=target, rig=rig, frames=1, files=attrs.evolve(files, omit=omit))
        for omit in ((), ("timing", "edge_radius"))
    )
    for made, name in ((told, "told"), (silent, "silent")):
        render(made, tmp_path / name)
    told_files, silent_files = (open_sequence(tmp_path / name) for name in ("told", "silent"))
    assert (told_files.target.edge_radius, silent_files.target.edge_radius) == (0.004, 0.0)
    assert (told_files.rig.line_delay_ns, told_files.rig.exposure_ns) == (50_000, 1_000_000)
    assert (silent_files.rig.line_delay_ns, silent_files.rig.exposure_ns) == (0, 0)
    for sequence in (told_files, silent_files):
        np.testing.assert_allclose(list(sequence.target.tolerance.values()), 0.0007)
        errors = [abs(sequence.target.points[name] - point).max() for name, point in target.points.items()]
        assert 1e-4 < max(errors) < 4e-3
        assert 0.1 < abs(sequence.rig.cameras[0].cx - rig.cameras[0].cx) < 12.0
    images = [path.read_bytes() for path in sorted((tmp_path / "told").rglob("*.png"))]
    assert images == [path.read_bytes() for path in sorted((tmp_path / "silent").rglob("*.png"))]
    meta = yaml.safe_load((tmp_path / "silent" / "meta.yaml").read_text())
    assert meta["timing"]["line_delay_ns"] == 50_000
    np.testing.assert_allclose(meta["true_points_mm"]["B0"], 1e3 * target.points["B0"])


def test_an_interrupted_run_goes_on_to_the_same_bytes(scenario, tmp_path):
    def stop(done, total):
        if done == 3:
            raise KeyboardInterrupt

    render(scenario, tmp_path / "whole")
    with pytest.raises(KeyboardInterrupt):
        render(scenario, tmp_path / "out", progress=stop)
    assert not (tmp_path / "out").exists()
    partial = tmp_path / "out.partial"
    images = sorted(partial.rglob("*.png"))
    assert len(images) == 3
    images[0].write_bytes(images[0].read_bytes()[:100])  # as a machine that lost its power may leave it
    (images[0].parent / "half.part").write_bytes(b"")
    steps = []
    assert render(scenario, tmp_path / "out", progress=lambda *step: steps.append(step))
    assert steps == [(2, 4), (3, 4), (4, 4)]
    assert not partial.exists()
    assert contents(tmp_path / "out") == contents(tmp_path / "whole")
    assert not render(scenario, tmp_path / "out")  # it is complete
    other = attrs.evolve(scenario, seed=2)
    with pytest.raises(InputError, match="out: holds a sequence of another scenario"):
        render(other, tmp_path / "out")
    render(other, tmp_path / "other")
    assert contents(tmp_path / "other")["cam0/data.csv"] == contents(tmp_path / "out")["cam0/data.csv"]
    first = f"cam0/data/{scenario.timestamp_ns(0)}.png"
    assert contents(tmp_path / "other")[first] != contents(tmp_path / "out")[first]


def test_what_is_in_the_way_is_left_alone(scenario, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.txt").write_text("years of work")
    with pytest.raises(InputError, match="out: exists and is no simulated sequence"):
        render(scenario, tmp_path / "out")
    (tmp_path / "fresh.partial").mkdir()
    (tmp_path / "fresh.partial" / "thesis.txt").write_text("years of work")
    with pytest.raises(InputError, match=r"fresh\.partial: is in the way"):
        render(scenario, tmp_path / "fresh")
    (tmp_path / "next.partial").mkdir()
    (tmp_path / "next.partial" / "fingerprint").write_text("of another\n")
    with pytest.raises(InputError, match=r"next\.partial: is an unfinished run of another scenario"):
        render(scenario, tmp_path / "next")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"cannot be written|exists and is no"):
        render(scenario, tmp_path / "file" / "out")
    assert (tmp_path / "out" / "thesis.txt").read_text() == "years of work"


def test_two_processes_do_not_work_on_one_sequence(scenario, tmp_path):
    def again(done, total):
        with pytest.raises(InputError, match=r"out\.partial: another process is at work"):
            render(scenario, tmp_path / "out")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        render(scenario, tmp_path / "out", progress=again)


def test_a_missing_mitsuba_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    with pytest.raises(InputError, match=r"rendering: .*mitsuba.*; install rvdnav with the extra 'sim'"):
        load_mitsuba()


def test_the_command_makes_a_sequence_and_finds_it_complete(tmp_path, capsys):
    (tmp_path / "rig").mkdir()
    (tmp_path / "rig" / "camchain.yaml").write_text(CAMCHAIN)
    (tmp_path / "s.yaml").write_text(
        "{name: s, seed: 1, frames: 1, rate_hz: 8, rig: rig, target: {box: {size_mm: [90, 90, 90]}},"
        " motion: {x_m: 0.6}, samples_per_pixel: 1}"
    )
    out = tmp_path / "out"
    assert execute(["simulate", str(tmp_path / "s.yaml"), "--out", str(out)]) == 0
    assert capsys.readouterr().out == f"sequence: {out} (1 frames)\n"
    assert execute(["simulate", str(tmp_path / "s.yaml"), "--out", str(out)]) == 0
    assert "complete already" in capsys.readouterr().out
