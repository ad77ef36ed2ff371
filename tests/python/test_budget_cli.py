"""``rvdnav budget``: its page, exit codes and one clear line for a user's mistake."""

from __future__ import annotations

import shutil
from pathlib import Path

import attrs
import numpy as np
import pytest
import rvdnav.budget.budget
from conftest import TARGET
from drawn_scene import EXAMPLE, wide_rig
from rvdnav.budget import Check
from rvdnav.cli.app import execute
from rvdnav.rig import save_rig

SMALL = ["--ranges", "0.5,1", "--angles", "0,30"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A rig with the covariance of its calibration, and a target."""
    path = tmp_path / "rig"
    path.mkdir()
    deviations = np.array([0.2, 0.2, 0.2, 0.2, 1e-3, 1e-3, 1e-5, 1e-5] * 2 + [1e-5] * 6)
    save_rig(attrs.evolve(wide_rig(), calibration_covariance=np.diag(deviations**2)), path)
    (path / "target.yaml").write_text(TARGET)
    return path


def test_tables_and_page(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    arguments = ["budget", str(folder), "--out", str(out), *SMALL, "--require", "0.01mm", "--require", "5deg"]
    assert execute([*arguments, "--at", "0.7"]) == 0
    assert sorted(path.name for path in out.iterdir()) == ["budget.html", "plotly.min.js"]
    page = (out / "budget.html").read_text()
    assert "<h1>rig" in page
    text = capsys.readouterr().out
    for shown in (text, page):
        for words in (
            "covariance of rig.yaml",
            "line displacement",
            "half the baseline",
            "Not met",
            "Met",
            "0.7 m, 0°",
        ):
            assert words in shown, words
    assert max(map(len, text.splitlines())) <= 100


def test_a_rig_is_named_by_its_file_and_the_target_by_an_option(folder: Path, tmp_path: Path) -> None:
    target = folder / "target.yaml"
    target.rename(tmp_path / "other.yaml")
    arguments = ["budget", str(folder / "camchain.yaml"), "--target", str(tmp_path / "other.yaml")]
    assert execute([*arguments, "--out", str(tmp_path / "out"), *SMALL]) == 0


def test_what_has_no_figures_is_counted_and_told_why(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(
        rvdnav.budget.budget, "check", lambda _, distance, angle, done: Check(distance, angle, np.ones(6), np.ones(6))
    )
    arguments = ["budget", str(folder), "--out", str(tmp_path / "out"), "--ranges", "0.02,0.5,1", "--angles", "0,30"]
    assert execute([*arguments, "--check"]) == 0
    text, page = capsys.readouterr().out, (tmp_path / "out" / "budget.html").read_text()
    for shown in (text, page):
        assert "ranges and angles with a pose: 4 of 6; at the others (–): " in shown
        assert "designs with a pose: 8 of 8" in shown
        assert "corners of ranges and angles checked: 2 of 4; at the others (–): there is no pose" in shown


@pytest.mark.parametrize(("ratio", "code"), [(1.08, 0), (0.85, 1)])
def test_a_check_that_fails_is_told(
    folder: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    ratio: float,
    code: int,
) -> None:
    drawn = []

    def check(_: object, distance: float, angle: float, *, done: object) -> Check:
        drawn.append((distance, round(np.degrees(angle))))
        return Check(distance, angle, np.ones(6), np.array([1.0, 1.0, 1.0, 1.0, 1.0, ratio]))

    monkeypatch.setattr(rvdnav.budget.budget, "check", check)
    assert execute(["budget", str(folder), "--out", str(tmp_path / "out"), *SMALL, "--check"]) == code
    assert drawn == [(0.5, 0), (0.5, 30), (1.0, 0), (1.0, 30)]
    assert ("NO" in capsys.readouterr().out) is bool(code)


FAULTS = [
    (["nowhere"], "nowhere: no such file or folder"),
    (["{folder}/target.yaml"], "neither a folder nor a camchain.yaml or rig.yaml"),
    (["{folder}", "--target", "nowhere.yaml"], "nowhere.yaml: no such file"),
    (["{folder}", "--require", "1 inch"], "--require '1 inch'"),
    (["{folder}", "--ranges", "1;2"], "--ranges '1;2': not numbers"),
    (["{folder}", "--ranges", "0,1"], "0 is out of range"),
    (["{folder}", "--ranges", "nan"], "nan is out of range"),
    (["{folder}", "--angles", "90"], "90 is out of range"),
    (["{folder}", "--at", "-1"], "--at -1: not a range"),
    (["{folder}", "--at", "0.02"], "too little of target test-bracket is in view"),
    (["{folder}", "--noise", "-1"], "--noise -1: not a number from 0 on"),
    (["{folder}", "--tolerance", "nan"], "--tolerance nan: not a number from 0 on"),
    (["{folder}", "--contrast", "0"], "--contrast 0: not a number above 0"),
]


@pytest.mark.parametrize(("arguments", "fault"), FAULTS, ids=[fault for _, fault in FAULTS])
def test_mistakes(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], fault: str
) -> None:
    out = tmp_path / "out"
    given = [word.replace("{folder}", str(folder)) for word in arguments]
    assert execute(["budget", *given, "--out", str(out)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("rvdnav: ")
    assert fault in line
    assert not out.exists()


def test_nothing_that_errs(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    save_rig(attrs.evolve(wide_rig(), calibration_covariance=np.zeros((22, 22))), folder)
    nothing = [f"--{name}=0" for name in ("noise", "displacement", "tolerance", "timing")]
    # What is left are the side faces, which head-on at 0.6 m are in sight.
    assert execute(["budget", str(folder), "--out", str(tmp_path / "out"), *SMALL, "--at", "0.6", *nothing]) == 0
    text = (folder / "target.yaml").read_text()
    (folder / "target.yaml").write_text(text.replace("bar_thickness: 6.0", "bar_thickness: 0.0"))
    assert execute(["budget", str(folder), "--out", str(tmp_path / "none"), *SMALL, *nothing]) == 2
    assert "nothing is assumed to err" in capsys.readouterr().err


def test_a_target_without_bracket(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points = "points: {A: [0, 0, 0], B: [0, 0.1, 0], C: [0, 0, 0.1]}"
    (folder / "target.yaml").write_text(f"name: frame\nunits: m\n{points}\nedges: [[A, B], [B, C], [C, A]]\n")
    assert execute(["budget", str(folder), "--out", str(tmp_path / "out"), *SMALL]) == 0
    assert "every other edge" in capsys.readouterr().out


def test_a_rig_without_a_calibration_covariance(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "unstated"
    folder.mkdir()
    for name in ("camchain.yaml", "target.yaml"):
        shutil.copy(EXAMPLE / name, folder)
    arguments = ["budget", str(folder), "--out", str(tmp_path), "--ranges", "0.8", "--angles", "0"]
    assert execute(arguments) == 0
    assert "none in rig.yaml" in capsys.readouterr().out
