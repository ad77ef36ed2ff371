"""The paper's experiment: the chart against exact geometry, the operators' measures, the report."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from drawn_scene import bracket_target, example_rig
from rvdnav.cli.app import execute
from rvdnav.core import Core, unpack_edges
from rvdnav.experiment import compare_edges, compare_thinning
from rvdnav.experiment.chart import CONTRASTS, LEVELS, draw_chart
from rvdnav.experiment.sobel import THRESHOLDS, detail_by_kind, plain_sobel, quality
from rvdnav.experiment.thinning import pack_edges
from rvdnav.output import read_solutions

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "approach"


@pytest.fixture(scope="module")
def core() -> Core:
    return Core(example_rig(), bracket_target())


def test_the_charts_edges_lie_where_it_says() -> None:
    """A strong step of a blurred picture without noise has its largest gradient at the places, to a pixel."""
    chart = draw_chart(704, 576, 0.0, seed=1)
    strong = chart.contrast == CONTRASTS[-1]
    gradient = np.hypot(*(cv2.Sobel(chart.image, cv2.CV_64F, dx, dy, ksize=3) for dx, dy in ((1, 0), (0, 1))))
    for level in LEVELS:
        x, y = np.round(chart.places[strong & (chart.level == level)]).astype(int).T
        assert np.median(gradient[y, x]) > 0.7 * 4.0 * level * CONTRASTS[-1] * 0.5
    assert gradient[chart.distance > 4.0].max() <= 4.0  # rounding alone


def test_the_charts_noise_is_that_of_the_sensor() -> None:
    noisy, clean = draw_chart(704, 576, 2.0, seed=1), draw_chart(704, 576, 0.0, seed=1)
    difference = noisy.image.astype(float) - clean.image
    flat = clean.distance > 6.0
    for level in LEVELS:
        here = flat & (np.abs(clean.image - level) <= 0.5)
        expected = np.sqrt(4.0 * (1.0 + 0.025 * level) + 1.0 / 12.0)
        assert difference[here].std() == pytest.approx(expected, rel=0.03)


def test_the_plain_operator_counts_a_step_in_grey_levels(core: Core) -> None:
    image = np.full((576, 704), 50, np.uint8)
    image[:, 300:] = 90
    response = plain_sobel(core.smooth(0, image))
    assert response[100:400, 290:310].max(axis=1) == pytest.approx(40.0, abs=0.5)
    assert response[100:400, 310:].max() == 0.0


def test_quality_of_perfect_empty_and_full_maps() -> None:
    chart = draw_chart(704, 576, 1.0, seed=1)
    perfect = quality(chart, chart.distance <= 1.0)
    assert (perfect.detail, perfect.noise) == (1.0, 0.0)
    nothing = quality(chart, np.zeros(chart.distance.shape, bool))
    assert (nothing.detail, nothing.noise) == (0.0, 0.0)
    assert quality(chart, np.ones(chart.distance.shape, bool)).noise == 1.0
    assert (detail_by_kind(chart, chart.distance <= 1.0) == 1.0).all()


def test_what_the_comparison_finds(core: Core) -> None:
    """In the shade the adaptive threshold shows edges that a plain one as quiet does not; in strong noise it shows
    more altogether."""
    trials = compare_edges(core)
    for trial in trials:
        assert trial.plain[trial.matched].noise <= trial.adaptive.noise
        if trial.matched:
            assert trial.plain[trial.matched - 1].noise > trial.adaptive.noise
        noise = [quality.noise for quality in trial.plain]
        assert noise == sorted(noise, reverse=True)
        shade = trial.detail[:, 0, -1]
        assert shade[0] > shade[1] + 0.3
    assert all(trial.adaptive.detail > trial.plain[trial.matched].detail for trial in trials[1:])
    assert len(trials[0].plain) == len(THRESHOLDS)


def test_thinning_keeps_what_is_connected(core: Core) -> None:
    trial = compare_edges(core)[1]
    ours, usual = compare_thinning(core, trial.chart, trial.plain_map)
    for thinning in (ours, usual):
        assert thinning.components[0] == thinning.components[1]
        assert thinning.thick == 0
        assert not (thinning.edges & ~trial.plain_map).any()
    assert ours.offset_px < usual.offset_px + 0.05


@pytest.mark.parametrize("width", [31, 32, 33, 704])
def test_packing_is_undone_by_unpacking(width: int) -> None:
    edges = np.random.default_rng(2).random((5, width)) < 0.3
    np.testing.assert_array_equal(unpack_edges(pack_edges(edges), width), edges)


def test_the_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    assert execute(["experiment", "paper", "--run", str(EXAMPLE), "--out", str(out)]) == 0
    text = capsys.readouterr().out
    assert str(out / "experiment.html") in text
    assert "24 of 24" in text
    assert sorted(path.name for path in out.iterdir()) == [
        "experiment.html",
        "plotly.min.js",
        "poses.tum",
        "solutions.jsonl",
    ]
    page = (out / "experiment.html").read_text()
    for number in range(9, 15):
        assert f"Figure {number}:" in page
    assert page.count("Section 3.1") == 4
    assert "24 of 24 frames published" in page


def test_a_report_that_cannot_be_written_leaves_the_results(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr("rvdnav.cli.experiment.write_paper_report", full)
    out = tmp_path / "out"
    assert execute(["experiment", "paper", "--run", str(EXAMPLE), "--out", str(out)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"rvdnav: {out / 'experiment.html'}: cannot be written, the results are there without it")
    assert line.endswith("No space left on device")
    assert sorted(path.name for path in out.iterdir()) == ["poses.tum", "solutions.jsonl"]
    solutions = read_solutions(out)
    assert (len(solutions), sum(solution.published for solution in solutions)) == (24, 24)


def test_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "out")
    assert execute(["experiment", "other", "--out", out]) == 2
    assert "only 'paper'" in capsys.readouterr().err
    assert execute(["experiment", "paper", "--run", str(tmp_path / "none"), "--out", out]) == 2
    assert "no such sequence or scenario" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    taken = tmp_path / "taken"
    taken.write_text("mine")
    for run in (EXAMPLE, EXAMPLE.parent / "scenarios" / "paper.yaml"):
        for place in (taken, taken / "below"):
            assert execute(["experiment", "paper", "--run", str(run), "--out", str(place)]) == 2
            assert capsys.readouterr().err.startswith(f"rvdnav: {taken}")
    assert taken.read_text() == "mine"
