"""The files of a run: whole or not at all, and what is read back."""

import errno
import json
import os
import shutil
import signal

import numpy as np
import pytest
from rvdnav.errors import InputError
from rvdnav.output import read_solutions, staged_directory, staged_report, write_solutions
from solutions import a_run

TIMES = [1_700_000_000_000_000_000 + 125_000_000 * i for i in range(8)]


def tree(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_files_arrive_together_in_a_new_folder(tmp_path):
    out = tmp_path / "deep" / "out"
    with staged_directory(out) as staging:
        (staging / "a.txt").write_text("1")
        (staging / "b.txt").write_text("2")
        assert not out.exists()
    assert tree(tmp_path) == ["deep", "deep/out", "deep/out/a.txt", "deep/out/b.txt"]


@pytest.mark.parametrize("fault", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_nothing_is_left_after_a_failure(tmp_path, fault):
    def fail(out):
        with staged_directory(out) as staging:
            (staging / "a.txt").write_text("new")
            raise fault

    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "a.txt").write_text("old")
    for out in (tmp_path / "old", tmp_path / "new" / "out"):
        with pytest.raises(fault):
            fail(out)
    assert tree(tmp_path) == ["old", "old/a.txt"]
    assert (tmp_path / "old" / "a.txt").read_text() == "old"


@pytest.fixture(params=[signal.SIGINT, signal.SIGTERM])
def interrupt(request):
    """Sends the program a signal that its handler, the same for both, makes a KeyboardInterrupt of."""
    previous = signal.signal(request.param, signal.default_int_handler)
    yield lambda: signal.raise_signal(request.param)
    signal.signal(request.param, previous)


@pytest.mark.parametrize(("module", "step"), [(os, "replace"), (shutil, "rmtree")])
def test_an_interrupt_waits_while_files_are_moved_and_removed(tmp_path, monkeypatch, interrupt, module, step):
    original = getattr(module, step)

    def struck(*arguments, **options):
        interrupt()
        return original(*arguments, **options)

    monkeypatch.setattr(module, step, struck)
    with pytest.raises(KeyboardInterrupt), staged_directory(tmp_path / "out") as staging:  # noqa: PT012
        (staging / "a.txt").write_text("1")
        (staging / "b.txt").write_text("2")
    assert tree(tmp_path) == ["out", "out/a.txt", "out/b.txt"]


def test_a_folder_takes_the_place_of_the_older_one(tmp_path):
    for name in ("old", "new"):
        with staged_directory(tmp_path / "out") as staging:
            (staging / "boxes" / name).mkdir(parents=True)
    assert tree(tmp_path) == ["out", "out/boxes", "out/boxes/new"]


def test_a_file_in_the_way_is_named(tmp_path):
    (tmp_path / "out").write_text("")
    with pytest.raises(InputError, match=r"out: not a folder"), staged_directory(tmp_path / "out" / "run"):
        pass


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match=r"out: cannot be written"), staged_directory(tmp_path / "out"):
        pass


def test_a_folder_in_a_files_place_is_named_and_the_staging_folder_goes(tmp_path):
    (tmp_path / "out" / "poses.tum" / "x").mkdir(parents=True)

    def publish():
        with staged_directory(tmp_path / "out") as staging:
            (staging / "poses.tum").write_text("")

    with pytest.raises(InputError, match=r"out: cannot be written"):
        publish()
    assert tree(tmp_path) == ["out", "out/poses.tum", "out/poses.tum/x"]


def test_the_run_is_read_back_as_written(tmp_path):
    run = a_run(TIMES)
    write_solutions(tmp_path, run)
    assert read_solutions(tmp_path) == tuple(run)
    poses = [line.split() for line in (tmp_path / "poses.tum").read_text().splitlines() if not line.startswith("#")]
    published = [s for s in run if s.published]
    assert len(poses) == len(published) == 6  # not the one searching and not the one coasting
    assert poses[0][0] == "1700000000.125000000"
    np.testing.assert_allclose([float(x) for x in poses[0][1:4]], published[0].T_world_target[:3, 3], atol=1e-9)


def test_damage_names_the_file_and_the_line(tmp_path):
    with pytest.raises(InputError, match=r"solutions\.jsonl"):
        read_solutions(tmp_path)
    write_solutions(tmp_path, a_run(TIMES))
    lines = (tmp_path / "solutions.jsonl").read_text().splitlines()
    (tmp_path / "solutions.jsonl").write_text("\n".join([*lines[:3], lines[3][:50], *lines[4:]]))
    with pytest.raises(InputError, match=r"solutions\.jsonl: line 4"):
        read_solutions(tmp_path)
    (tmp_path / "solutions.jsonl").write_text("")
    with pytest.raises(InputError, match="no frames"):
        read_solutions(tmp_path)


def test_pose_file_and_solutions_must_agree(tmp_path):
    write_solutions(tmp_path, a_run(TIMES))
    solutions = (tmp_path / "solutions.jsonl").read_text()
    (tmp_path / "solutions.jsonl").write_text("\n".join(solutions.splitlines()[:-1]))
    with pytest.raises(InputError, match=r"poses\.tum: its frames"):
        read_solutions(tmp_path)
    changed = [json.loads(line) for line in solutions.splitlines()]
    changed[2]["T_world_target"][0][3] += 1e-5
    (tmp_path / "solutions.jsonl").write_text("\n".join(json.dumps(one) for one in changed))
    with pytest.raises(InputError, match=r"poses\.tum: the pose at 1700000000250000000 ns"):
        read_solutions(tmp_path)


def test_a_report_that_cannot_be_written_leaves_the_results(tmp_path):
    (tmp_path / "poses.tum").write_text("results")
    (tmp_path / "report.html").write_text("of an earlier run")

    def write():
        with staged_report(tmp_path, "report.html") as page:
            page.write_text("half")
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with pytest.raises(InputError, match=r"report\.html: cannot be written, the results are there without it: .*space"):
        write()
    assert tree(tmp_path) == ["poses.tum"]
