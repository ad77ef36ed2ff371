"""Campaigns: plans, results that are complete and counted once, a worker killed, the bounds."""

from __future__ import annotations

import os
import re
import shutil
import signal
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from distributed import Client, LocalCluster
from rvdnav import InputError, Navigator, open_sequence
from rvdnav.campaign import Plan, Pool, Source, Trial, load_plan, run_campaign, summarise, upper_bound
from rvdnav.campaign.page import write_campaign_report
from rvdnav.campaign.store import RESULTS, SCHEMA, collect
from rvdnav.cli.app import execute
from rvdnav.evaluation import evaluate
from rvdnav.sequence import write_tum
from scipy.stats import binomtest

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "approach"
IN_TURN = Pool(jobs=1)


def write_plan(folder: Path, text: str) -> Path:
    path = folder / "campaign.yaml"
    path.write_text(text)
    return path


@pytest.fixture
def tiny(make_sequence: Callable[..., Path]) -> Path:
    """A sequence of small images, in which nothing is found, with true poses."""
    folder = make_sequence(frames=4)
    stamps = [frame.timestamp_ns for frame in open_sequence(folder)]
    T = np.eye(4)
    T[0, 3] = 0.7
    write_tum(folder / "groundtruth.tum", [(stamp, T) for stamp in stamps])
    return folder


def tiny_plan(folder: Path, trials: int) -> Plan:
    return Plan("tiny", tuple(Trial(Source(folder), "noise_x4:all", seed) for seed in range(trials)))


def test_a_plan_has_every_trial_once(tmp_path: Path) -> None:
    (tmp_path / "near.yaml").write_text("name: near\n")
    path = write_plan(
        tmp_path,
        f"name: all\nsequences: [{EXAMPLE}, {EXAMPLE}]\nscenarios: [near.yaml]\nseeds: {{first: 3, count: 2}}\n"
        'faults: [none, "black_left:1-2  late:5", none]\n',
    )
    plan = load_plan(path)
    shown = [(trial.source.name, trial.faults, trial.seed) for trial in plan.trials]
    assert shown == [
        ("approach", "none", 3),
        ("near-3", "none", 3),
        ("near-4", "none", 4),
        ("approach", "black_left:1-2 late:5", 3),
        ("approach", "black_left:1-2 late:5", 4),
        ("near-3", "black_left:1-2 late:5", 3),
        ("near-4", "black_left:1-2 late:5", 4),
    ]
    assert len({trial.key for trial in plan.trials}) == len(plan.trials)
    assert [fault.name for fault in plan.trials[3].parsed_faults()] == ["black_left", "late"]
    assert load_plan(path).digest == plan.digest
    (tmp_path / "near.yaml").write_text("name: nearer\n")  # another scene: other results
    assert load_plan(path).digest != plan.digest


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name: a\n", "neither sequences nor scenarios"),
        ("name: a\nsequences: [nowhere]\n", "nowhere: no such folder"),
        ("name: a\nscenarios: [nothing.yaml]\n", "nothing.yaml: no such file"),
        ("sequences: [.]\n", "name is missing"),
        ("name: a\nsequences: [.]\nseed: 1\n", "seed is not known; did you mean seeds"),
        ("name: a\nsequences: [.]\nseeds: [1.5]\n", "seeds is neither"),
        ("name: a\nsequences: [.]\nseeds: {first: 0, count: 0}\n", "seeds.count is not a whole number from 1 to"),
        ("name: a\nsequences: [.]\nfaults: [blue:1]\n", "there is no fault 'blue'"),
    ],
)
def test_plans_that_are_none(tmp_path: Path, text: str, words: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_plan(tmp_path, text)
    with pytest.raises(InputError, match=words):
        load_plan(path)
    assert execute(["campaign", str(path), "--out", str(tmp_path / "out")]) == 2
    assert str(path) in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_the_numbers_are_those_of_the_runs(tmp_path: Path) -> None:
    plan = Plan("example", (Trial(Source(EXAMPLE), "none", 0), Trial(Source(EXAMPLE), "dropped:0-19", 0)))
    rows = run_campaign(plan, tmp_path / "out", IN_TURN)
    assert rows.schema == SCHEMA
    sequence = open_sequence(EXAMPLE)
    navigator = Navigator(sequence.rig, sequence.target)
    expected = evaluate([navigator.process(frame) for frame in sequence], sequence.truth)
    undisturbed = rows.slice(0, len(sequence))
    np.testing.assert_allclose(undisturbed.column("position_error_m").to_pylist(), expected.position_m, rtol=1e-12)
    np.testing.assert_allclose(undisturbed.column("attitude_error_rad").to_pylist(), expected.attitude_rad, rtol=1e-9)
    summary = summarise(rows)
    assert (summary.overall.trials, summary.overall.frames) == (2, 24 + 4)
    assert summary.overall.judged == len(expected.position_m) + summary.by_fault[1].published
    fault_free = summary.by_fault[0]
    assert fault_free.published == expected.published
    assert fault_free.mean_nees_ratio == pytest.approx(expected.mean_nees_ratio)
    assert fault_free.position_m[0] == pytest.approx(expected.overall.position_m.median)
    for group, row in zip(summary.by_range, expected.rows, strict=True):
        assert group.frames >= row.frames
    write_campaign_report(tmp_path / "report.html", "example", summary, rows)
    page = (tmp_path / "report.html").read_text()
    assert "dropped:0-19" in page
    assert "28 frames" in page


def test_what_was_counted_and_why_not_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    partly = tmp_path / "partly"
    shutil.copytree(EXAMPLE, partly)
    truth = (partly / "groundtruth.tum").read_text().splitlines(keepends=True)
    (partly / "groundtruth.tum").write_text("".join(line for line in truth if line.startswith("#")) + truth[-1])
    plan, out = write_plan(tmp_path, f"name: some\nsequences: [{partly}]\nfaults: [black:3-4]\n"), tmp_path / "out"
    assert execute(["campaign", str(plan), "--out", str(out), "--jobs", "1"]) == 0
    text = capsys.readouterr().out
    page = (out / "campaign.html").read_text()
    unpublished = [i for i, row in enumerate(pq.read_table(out / RESULTS).to_pylist()) if not row["published"]]
    assert {3, 4} <= set(unpublished)
    for shown in (text, page):
        assert "0 of 1" in shown  # wrong, of those with a true pose
        assert f"Why {len(unpublished)} of 24 frames were not published" in shown
        assert "LEFT_UNUSABLE" in shown
    assert f"judged: 1 of {24 - len(unpublished)} published poses; the others have no true pose within 1 us" in text
    counts = dict(re.findall(r"([A-Z]{3,}[A-Z_]+) +│ +(\d+)", text))
    assert counts["LEFT_UNUSABLE"] == counts["RIGHT_UNUSABLE"] == "2"


def test_an_interrupted_campaign_goes_on_where_it_stopped(tmp_path: Path, tiny: Path) -> None:
    out = tmp_path / "out"
    plan = tiny_plan(tiny, 5)

    def stop(what: str, done: int, total: int) -> None:
        if what == "trials" and done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_campaign(plan, out, IN_TURN, stop)
    first = {part.name: part.stat().st_mtime_ns for part in (out / "trials").iterdir()}
    assert 2 <= len(first) < 5
    assert not (out / RESULTS).exists()
    rows = run_campaign(plan, out, IN_TURN)
    assert len(rows) == 5 * 4
    for name, written in first.items():
        assert (out / "trials" / name).stat().st_mtime_ns == written
    with pytest.raises(InputError, match="another plan"):
        run_campaign(tiny_plan(tiny, 4), out, IN_TURN)


def test_a_folder_of_something_else_is_left_alone(tmp_path: Path, tiny: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="in the way"):
        run_campaign(tiny_plan(tiny, 1), tmp_path, IN_TURN)
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_a_report_that_cannot_be_written_is_named(
    tmp_path: Path, tiny: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan, out = write_plan(tmp_path, f"name: tiny\nsequences: [{tiny}]\n"), tmp_path / "out"
    assert execute(["campaign", str(plan), "--out", str(out), "--jobs", "1"]) == 1  # nothing is found
    (out / "campaign.html").unlink()
    (out / "campaign.html").mkdir()
    capsys.readouterr()
    assert execute(["campaign", str(plan), "--out", str(out), "--jobs", "1"]) == 2
    assert capsys.readouterr().err.startswith(f"rvdnav: {out / 'campaign.html'}: cannot be written")


def test_damaged_results_are_named(tmp_path: Path, tiny: Path) -> None:
    plan = tiny_plan(tiny, 2)
    run_campaign(plan, tmp_path / "out", IN_TURN)
    part = tmp_path / "out" / "trials" / f"{plan.trials[1].key}.parquet"
    part.write_bytes(part.read_bytes()[:50])
    with pytest.raises(InputError, match=plan.trials[1].key):
        run_campaign(plan, tmp_path / "out", IN_TURN)


def test_a_cluster_that_loses_a_worker_loses_no_trial_and_counts_none_twice(tmp_path: Path, tiny: Path) -> None:
    plan, out = tiny_plan(tiny, 24), tmp_path / "out"
    killed: list[int] = []
    with LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster, Client(cluster) as client:
        victim = next(iter(client.run(os.getpid).values()))

        def kill() -> None:
            deadline = time.monotonic() + 60.0
            while not any((out / "trials").glob("*.parquet")) and time.monotonic() < deadline:
                time.sleep(0.005)
            os.kill(victim, signal.SIGKILL)
            killed.append(len(list((out / "trials").glob("*.parquet"))))

        killer = threading.Thread(target=kill)
        killer.start()
        rows = run_campaign(plan, out, Pool("dask", cluster.scheduler_address))
        killer.join()
    assert killed
    assert killed[0] < len(plan.trials)  # during the run, not after it
    seen = list(zip(rows.column("trial").to_pylist(), rows.column("timestamp_ns").to_pylist(), strict=True))
    assert len(seen) == len(set(seen)) == 24 * 4
    again = tmp_path / "again"
    assert drop_times(rows).equals(drop_times(run_campaign(plan, again, IN_TURN)))
    assert collect(out, [trial.key for trial in plan.trials]).equals(rows)


def drop_times(rows):
    return rows.drop_columns(["seconds"])


def test_a_scheduler_that_is_not_there(tmp_path: Path, tiny: Path) -> None:
    with pytest.raises(InputError, match="only a Dask or Ray cluster"):
        run_campaign(tiny_plan(tiny, 1), tmp_path / "a", Pool("local", "tcp://127.0.0.1:1"))
    assert execute(["campaign", "x.yaml", "--out", str(tmp_path / "b"), "--backend", "cloud"]) == 2


@pytest.mark.parametrize("jobs", ["0", "-2"])
def test_jobs_that_are_no_number_of_trials(jobs: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_plan(tmp_path, f"name: a\nsequences: [{EXAMPLE}]\nseeds: [1]\nfaults: [none]\n")
    assert execute(["campaign", str(path), "--out", str(tmp_path / "out"), "--jobs", jobs]) == 2
    assert capsys.readouterr().err.startswith(f"rvdnav: --jobs {jobs}: ")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("package", ["pyarrow", "joblib", "scipy.stats"])
def test_a_missing_package_is_named_in_one_line(
    package: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in [name for name in sys.modules if name.startswith(("rvdnav.campaign", "rvdnav.cli.campaign"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    assert execute(["campaign", str(tmp_path / "none.yaml"), "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert error.startswith("rvdnav: campaigns: ")
    assert package in error
    assert error.endswith("; install rvdnav with the extra 'campaign'\n")
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("events", "trials"), [(0, 1), (0, 59), (1, 40), (7, 100), (250, 1000)])
def test_the_bound_is_that_of_the_exact_binomial_test(events: int, trials: int) -> None:
    exact = binomtest(events, trials, alternative="less").proportion_ci(0.95, "exact").high
    assert upper_bound(events, trials) == pytest.approx(exact, rel=1e-9)


def test_nothing_seen_bounds_nothing() -> None:
    assert upper_bound(0, 0) == 1.0
    assert upper_bound(3, 3) == 1.0
    assert upper_bound(0, 59) == pytest.approx(1.0 - 0.05 ** (1.0 / 59.0))
