"""The command line: files, exit codes and one clear line for a user's mistake."""

import errno
import json
import os
import shutil
import signal
import subprocess
import sys

import attrs
import cv2
import numpy as np
import pytest
import rvdnav.cli.run
from drawn_scene import EXAMPLE
from rvdnav.blackbox.digests import write_digests
from rvdnav.cli.app import execute
from rvdnav.corrections import Corrections, ParameterCorrection, PointCorrection
from rvdnav.output import read_solutions
from rvdnav.sequence import open_sequence, read_tum, write_tum
from rvdnav.solution import LearnedDimensions, Reason, Solution, State
from solutions import FRAMES, Scripted, true_poses


class Blind(Scripted):
    """A navigator that never finds anything."""

    def process(self, frame):
        return Solution(timestamp_ns=frame.timestamp_ns, state=State.SEARCHING, reasons={Reason.NO_TARGET})


@pytest.fixture
def sequence(make_sequence, monkeypatch):
    monkeypatch.setattr(rvdnav.cli.run, "Navigator", Scripted)
    monkeypatch.setattr(rvdnav.cli.run, "Core", lambda rig, target: None)
    monkeypatch.setattr(rvdnav.cli.run, "edge_mask", lambda core, camera, image: cv2.Canny(image, 50, 150) > 0)
    return make_sequence(FRAMES)


def add_truth(sequence):
    stamps = [frame.timestamp_ns for frame in open_sequence(sequence)]
    write_tum(sequence / "groundtruth.tum", list(true_poses(stamps).items()))


def stderr_line(capsys):
    out, err = capsys.readouterr()
    assert "Traceback" not in out + err
    (line,) = err.splitlines()
    assert line.startswith("rvdnav: ")
    return line


def test_run_writes_three_files_and_sums_up(sequence, tmp_path, capsys):
    out = tmp_path / "new" / "out"
    assert execute(["run", str(sequence), "--out", str(out)]) == 0
    assert sorted(path.name for path in out.iterdir()) == [
        "plotly.min.js",
        "poses.tum",
        "report.html",
        "solutions.jsonl",
    ]
    lines = [json.loads(line) for line in (out / "solutions.jsonl").read_text().splitlines()]
    assert [line["state"] for line in lines] == ["SEARCHING", *["TRACKING"] * 4, "COASTING", *["TRACKING"] * 2]
    page = (out / "report.html").read_text()
    assert page.count("data:image/jpeg;base64,") == 4
    assert "<h1>Run over sequence" in page
    text = capsys.readouterr().out
    for words in ("6 (75.0 %)", "COASTING", "median sigma position", "10.0 ms (100.0 frames/s)", "report.html"):
        assert words in text
    assert "position error" not in text  # there is no truth


def test_the_share_of_published_frames_decides_the_exit_code(sequence, tmp_path, capsys):
    out = ["--out", str(tmp_path / "out")]
    assert execute(["run", str(sequence), *out, "--least-published", "75"]) == 0
    assert execute(["run", str(sequence), *out, "--least-published", "76"]) == 1
    assert "fewer than 76 % of the frames were published" in capsys.readouterr().err


def test_summaries_as_json(sequence, tmp_path):
    add_truth(sequence)
    out, summary = tmp_path / "out", tmp_path / "run.json"
    given = ["--set", "max_speed=0.5", "--fault", "black_left:2"]
    assert execute(["run", str(sequence), "--out", str(out), "--json", str(summary), *given]) == 0
    run = json.loads(summary.read_text())
    assert (run["frames"], run["published"], run["states"]["COASTING"]) == (8, 6, 1)
    assert run["settings"] == {"max_speed": 0.5}
    assert run["faults"] == ["black_left:2"]
    assert execute(["evaluate", str(sequence), str(out), "--json", str(tmp_path / "errors.json")]) == 0
    errors = json.loads((tmp_path / "errors.json").read_text())
    assert {name: errors[name] for name in run["errors"]} == run["errors"]
    assert (errors["frames"], errors["published"], errors["wrong"]) == (8, 6, 0)
    assert execute(["run", str(sequence), "--out", str(out), "--json", str(tmp_path / "no" / "run.json")]) == 2


def test_settings_that_do_not_go_together(tmp_path, capsys):
    out = tmp_path / "out"
    assert execute(["run", str(EXAMPLE), "--out", str(out), "--set", "range_min=2"]) == 2
    assert "range_max = 1.7 is not above range_min = 2" in stderr_line(capsys)
    assert not out.exists()


def test_info_tells_what_is_there(tmp_path, capsys):
    assert execute(["info", str(EXAMPLE)]) == 0
    text = capsys.readouterr().out
    for words in ("of 24 of 24 frames", "4 frames/s", "704 x 576 px", "120.23 mm", "four-bar bracket", "180 x 140 mm"):
        assert words in text
    assert execute(["info", str(EXAMPLE / "target.yaml")]) == 0
    text = capsys.readouterr().out
    assert "bracket-180" in text
    assert "baseline" not in text
    assert execute(["info", str(EXAMPLE / "rig.yaml")]) == 0
    text = capsys.readouterr().out
    assert "calibration exactly" in text
    assert "bracket-180" not in text
    (tmp_path / "other.yaml").write_text("a: 1\n")
    for path in (tmp_path / "other.yaml", tmp_path / "absent", tmp_path):
        assert execute(["info", str(path)]) == 2
        assert str(path) in stderr_line(capsys)


def test_without_a_command_there_is_help(capsys):
    assert execute([]) == 0
    text = capsys.readouterr().out
    assert "Commands:" in text
    module = subprocess.run([sys.executable, "-m", "rvdnav", "--version"], capture_output=True, text=True, check=True)
    assert module.stdout.startswith("rvdnav ")


def test_help_loads_nothing_that_commands_work_with():
    code = "import sys; from rvdnav.cli.app import execute; execute(['--help']); print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"numpy", "cv2", "plotly", "attrs"} & set(loaded)


def test_run_twice_gives_the_same_bytes(sequence, tmp_path):
    for name in ("a", "b"):
        execute(["run", str(sequence), "--out", str(tmp_path / name)])
    for file in ("poses.tum", "solutions.jsonl", "report.html"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()


def test_filtered_poses_stand_in_a_file_of_their_own(tmp_path):
    assert execute(["run", str(EXAMPLE), "--out", str(tmp_path / "out"), "--smoothed"]) == 0
    solutions = read_solutions(tmp_path / "out")
    smoothed = read_tum(tmp_path / "out" / "smoothed.tum")
    published = [s for s in solutions if s.published]
    assert smoothed.timestamps_ns.tolist() == [s.timestamp_ns for s in published]
    expected = [s.smoothed_T_world_target for s in published]
    np.testing.assert_allclose(smoothed.T_world_target, expected, atol=1e-8)
    assert execute(["run", str(EXAMPLE), "--out", str(tmp_path / "out"), "--fault", "dropped:2-23"]) == 0
    assert not (tmp_path / "out" / "smoothed.tum").exists()  # of the earlier run


def test_run_with_truth_reports_errors_and_evaluate_agrees(sequence, tmp_path, capsys):
    add_truth(sequence)
    out = tmp_path / "out"
    assert execute(["run", str(sequence), "--out", str(out)]) == 0
    assert "position error" in capsys.readouterr().out
    assert "Errors by range" in (out / "report.html").read_text()
    assert execute(["evaluate", str(sequence), str(out)]) == 0
    text = capsys.readouterr().out
    assert "6 of 8" in text
    assert "within 20 mm and 2 deg: 100.0 %" in text
    assert "wrong (> 20 mm or > 2 deg (1 + range / 1 m)): 0" in text
    assert "mean NEES / 6" in text
    assert all(len(line) <= 80 for line in text.splitlines() if "plots:" not in line)
    assert "Errors and 3σ band" in (out / "evaluation.html").read_text()


def test_learnt_dimensions_are_told(sequence, tmp_path, monkeypatch, capsys):
    class Learning(Scripted):
        def process(self, frame):
            learned = LearnedDimensions({"long_base": 0.18012}, {"long_base": 1.4e-4}, 5, known=False)
            return attrs.evolve(super().process(frame), dimensions=learned)

    monkeypatch.setattr(rvdnav.cli.run, "Navigator", Learning)
    assert execute(["run", str(sequence), "--out", str(tmp_path / "out")]) == 0
    text = capsys.readouterr().out
    for words in ("Dimensions learnt from 5 frames", "long base", "180.12", "0.14", "not yet known well enough"):
        assert words in text
    page = (tmp_path / "out" / "report.html").read_text()
    for words in ("Dimensions learnt", "<td>180.12</td><td>0.14</td>", "not yet enough"):
        assert words in page


def test_corrections_and_their_alarm_are_told(sequence, tmp_path, monkeypatch, capsys):
    class Correcting(Scripted):
        def process(self, frame):
            solution = super().process(frame)
            if not solution.published:
                return solution
            told = Corrections(
                {
                    "cam0.fx": ParameterCorrection(-0.3, 0.41, 1.34),
                    "cam1_cam0.ry": ParameterCorrection(0.0, 4e-4, 5e-4),
                },
                {"P1": PointCorrection((1e-4, 0.0, -2e-3), (1.1e-4, 1.1e-4, 1.1e-4), 3e-4)},
                calibration_scale=0.7,
                target_scale=2.6,
                calibration_distance=0.2,
                target_distance=6.7,
                frames=6,
            )
            reasons = solution.reasons | {Reason.TARGET_TOLERANCE}
            return attrs.evolve(solution, corrections=told, reasons=reasons)

    monkeypatch.setattr(rvdnav.cli.run, "Navigator", Correcting)
    assert execute(["run", str(sequence), "--out", str(tmp_path / "out")]) == 0
    text = capsys.readouterr().out
    for words in (
        "largest corrections by 6 frames: cam0.fx −0.30 px ± 0.41 px (stated ± 1.3 px)",
        "P1 +0.10, +0.00, −2.00 mm ± 0.11, 0.11, 0.11 mm (stated ± 0.3 mm)",
        "TARGET_TOLERANCE in 6 of 8 frames: the target seems to differ",
    ):
        assert words in text
    page = (tmp_path / "out" / "report.html").read_text()
    for words in (
        "Corrections learnt",
        "<td>cam0.fx</td><td>−0.30 px</td><td>± 0.41 px</td><td>± 1.3 px</td>",
        "<td>cam1_cam0.ry</td><td>+0.000°</td><td>± 0.023°</td><td>± 0.029°</td>",
        "TARGET_TOLERANCE in 6 of 8 frames",
        "2.60 times (target)",
    ):
        assert words in page


def test_faults_change_what_the_navigator_is_given(sequence, tmp_path, monkeypatch):
    given = []

    class Watching(Scripted):
        def process(self, frame):
            given.append((frame.timestamp_ns, None if frame.left is None else int(frame.left.pixels.max())))
            return super().process(frame)

    monkeypatch.setattr(rvdnav.cli.run, "Navigator", Watching)
    faults = ["--fault", "late:2", "--fault", "black_left:3-4,6"]
    assert execute(["run", str(sequence), "--out", str(tmp_path / "out"), *faults]) == 0
    stamps = [frame.timestamp_ns for frame in open_sequence(sequence)]
    assert [stamp for stamp, _ in given] == [stamps[i] for i in (0, 1, 3, 2, 4, 5, 6, 7)]
    assert {stamps.index(stamp) for stamp, brightest in given if brightest == 0} == {3, 4, 6}


def test_what_became_of_the_faults_is_told(sequence, tmp_path, capsys):
    faults = ["--fault", "black:4-6", "--fault", "noise_x4:1"]
    assert execute(["run", str(sequence), "--out", str(tmp_path / "out"), *faults]) == 0
    rows = [line.split("│")[1:-1] for line in capsys.readouterr().out.splitlines() if line.count("│") == 6]
    assert [[cell.strip() for cell in row] for row in rows] == [
        ["black", "3", "1", "1 frame", "-"],  # the made-up run refuses frame 5
        ["noise_x4", "1", "0", "-", "-"],
    ]


def test_a_lost_target_leaves_a_black_box_that_replays(tmp_path, capsys):
    out = tmp_path / "out"
    approach = str(EXAMPLE)
    assert execute(["run", approach, "--out", str(out), "--fault", "late:1", "--fault", "black:3-13"]) == 0
    (box,) = (out / "blackbox").iterdir()
    told = capsys.readouterr().out
    assert f"rvdnav replay {box}" in told
    assert f'<a href="blackbox/{box.name}/">' in (out / "report.html").read_text()
    assert execute(["evaluate", approach, str(out)]) == 0
    assert f'<a href="blackbox/{box.name}/">' in (out / "evaluation.html").read_text()
    capsys.readouterr()
    assert execute(["replay", str(box)]) == 0
    assert capsys.readouterr().out == "12 frames replayed, identical\n"  # last seen at 0.5 s, lost after 2 s more

    lines = (box / "solutions.jsonl").read_text().splitlines()
    lines[3] = lines[3].replace("COASTING", "SEARCHING")
    (box / "solutions.jsonl").write_text("\n".join([*lines, ""]))
    assert execute(["replay", str(box)]) == 2
    assert "solutions.jsonl: is not as it was recorded" in stderr_line(capsys)
    write_digests(box)
    assert execute(["replay", str(box)]) == 1
    assert "frame 3 at" in (text := capsys.readouterr().out)
    assert 'differs in state:\n  recorded "SEARCHING"\n  replayed "COASTING"\n' in text


def test_black_boxes_of_an_earlier_run_are_gone(sequence, tmp_path):
    old = tmp_path / "out" / "blackbox" / "1"
    old.mkdir(parents=True)
    assert execute(["run", str(sequence), "--out", str(tmp_path / "out")]) == 0
    assert not old.parent.exists()


@pytest.mark.parametrize(
    ("writer", "left"), [("write_solutions", []), ("write_report", ["poses.tum", "solutions.jsonl"])]
)
def test_a_full_disk_is_one_line(sequence, tmp_path, monkeypatch, capsys, writer, left):
    def full(*_args, **_keywords):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(rvdnav.cli.run, writer, full)
    out = tmp_path / "out"
    assert execute(["run", str(sequence), "--out", str(out)]) == 2
    assert "cannot be written" in (line := stderr_line(capsys))
    assert line.endswith("No space left on device")
    assert (sorted(path.name for path in out.iterdir()) if out.exists() else []) == left


def test_a_folder_whose_name_is_no_text(sequence, tmp_path, capsys):
    odd = sequence.rename(os.fsdecode(os.fsencode(tmp_path) + b"/odd\xff"))
    out = tmp_path / "out"
    assert execute(["run", str(odd), "--out", str(out)]) == 0
    assert capsys.readouterr().err == ""
    assert sorted(path.name for path in out.iterdir()) == [
        "plotly.min.js",
        "poses.tum",
        "report.html",
        "solutions.jsonl",
    ]
    solutions = read_solutions(out)
    assert len(solutions) == 8
    assert any(solution.published for solution in solutions)
    assert "<h1>Run over odd\ufffd" in (out / "report.html").read_text()


def test_a_closed_pipe_loses_nothing_but_the_text(tmp_path):
    command = [sys.executable, "-c", "from rvdnav.cli import main; main()", "run", str(EXAMPLE), "--out", str(tmp_path)]
    read, write = os.pipe()
    os.close(read)
    result = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, text=True, check=False)
    os.close(write)
    assert (result.returncode, result.stderr) == (0, "")
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "plotly.min.js",
        "poses.tum",
        "report.html",
        "solutions.jsonl",
    ]


def test_notes_of_one_kind_are_counted(sequence, tmp_path, capsys):
    for image in sorted((sequence / "cam1" / "data").iterdir())[1:5]:
        image.write_bytes(image.read_bytes()[:60])
    assert execute(["run", str(sequence), "--out", str(tmp_path / "out")]) == 0
    assert stderr_line(capsys).endswith("(and 3 more like it)")


def test_a_run_over_another_sequence_is_not_evaluated(sequence, tmp_path, capsys):
    out = tmp_path / "out"
    assert execute(["run", str(sequence), "--out", str(out)]) == 0
    other = tmp_path / "other"
    shutil.copytree(sequence, other)
    an_hour = 3600 * 10**9
    for image in sorted(other.glob("cam?/data/*.png")):
        image.rename(image.with_name(f"{int(image.stem) + an_hour}.png"))
    for listing in other.glob("cam?/data.csv"):
        listing.unlink()
    add_truth(other)
    capsys.readouterr()
    assert execute(["evaluate", str(other), str(out)]) == 2
    assert "is it a run over another sequence?" in stderr_line(capsys)


def test_every_frame_dropped_is_bad_input(sequence, tmp_path, capsys):
    assert execute(["run", str(sequence), "--out", str(tmp_path / "out"), "--fault", "dropped:all"]) == 2
    assert "holds no frames" in stderr_line(capsys)


def test_no_pose_is_exit_code_1_with_the_files_written(sequence, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(rvdnav.cli.run, "Navigator", Blind)
    add_truth(sequence)
    assert execute(["run", str(sequence), "--out", str(tmp_path / "out")]) == 1
    assert "0 (0.0 %)" in capsys.readouterr().out
    assert (tmp_path / "out" / "report.html").exists()
    assert execute(["evaluate", str(sequence), str(tmp_path / "out")]) == 1


def test_a_truth_of_another_time_is_no_hindrance_to_run(sequence, tmp_path, capsys):
    write_tum(sequence / "groundtruth.tum", [(5, np.eye(4))])
    out = tmp_path / "out"
    assert execute(["run", str(sequence), "--out", str(out)]) == 0
    assert "no frame has a true pose within 1 us: the nearest is" in stderr_line(capsys)
    assert execute(["evaluate", str(sequence), str(out)]) == 2
    assert "no frame of the run has a true pose" in stderr_line(capsys)


def test_oddities_of_the_sequence_are_told_once(sequence, tmp_path, capsys):
    image = sorted((sequence / "cam1" / "data").iterdir())[2]
    image.write_bytes(image.read_bytes()[:60])
    assert execute(["run", str(sequence), "--out", str(tmp_path / "out")]) == 0
    notes = capsys.readouterr().err.splitlines()
    assert sum(image.name in note for note in notes) == 1
    assert all(note.startswith("rvdnav: note: ") for note in notes)


@pytest.mark.parametrize(
    ("arguments", "fault"),
    [
        (["run", "{tmp}/nowhere", "--out", "{tmp}/out"], "{tmp}/nowhere"),
        (["run", "{sequence}", "--out", "{tmp}/file"], "{tmp}/file: not a folder"),
        (["evaluate", "{sequence}", "{tmp}"], "groundtruth.tum"),
        (["bench", "{tmp}/nowhere"], "{tmp}/nowhere"),
        (["replay", "{tmp}/nowhere"], "nowhere/memory.json: no such file"),
        (["run", "{sequence}"], "--out"),
        (["run", "{sequence}", "--out", "x", "--fast"], "--fast"),
        (["run", "--out", "x"], "SEQUENCE"),
        (["run", "{sequence}", "--out", "x", "--fault", "fog:all"], "no fault 'fog'"),
        (["run", "{sequence}", "--out", "x", "--fault", "black:7-8"], "sequence: fault black: there is no frame 8"),
        (["fly"], "fly"),
        (["run", "{sequence}", "--out", ""], "the value after --out is empty"),
        (["run", "{sequence}", "--out="], "the value after --out is empty"),
        (["run", "", "--out", "{tmp}/out"], "the value after run is empty"),
        (["run", "{sequence}", "--out", "{sequence}/cam0"], "cam0: lies in cam0, a camera's folder"),
        (["run", "{sequence}", "--out", "{sequence}/cam1/data/out"], "out: lies in cam1, a camera's folder"),
    ],
)
def test_a_mistake_gets_one_line_and_exit_code_2(sequence, tmp_path, capsys, arguments, fault):
    (tmp_path / "file").write_text("")
    before = sorted(tmp_path.rglob("*"))
    places = {"tmp": tmp_path, "sequence": sequence}
    assert execute([argument.format(**places) for argument in arguments]) == 2
    assert fault.format(**places) in stderr_line(capsys)
    assert sorted(tmp_path.rglob("*")) == before


def test_bad_calibration_leaves_no_output(sequence, tmp_path, capsys):
    camchain = (sequence / "camchain.yaml").read_text()
    (sequence / "camchain.yaml").write_text(camchain.replace("66.8", ".nan"))
    assert execute(["run", str(sequence), "--out", str(tmp_path / "out")]) == 2
    assert "camchain.yaml" in stderr_line(capsys)
    assert not (tmp_path / "out").exists()


def test_an_empty_sequence_is_bad_input(make_sequence, tmp_path, capsys):
    assert execute(["run", str(make_sequence(0)), "--out", str(tmp_path / "out")]) == 2
    assert "sequence" in stderr_line(capsys)
    assert not (tmp_path / "out").exists()


STRUCK = """
import os, signal, sys
import rvdnav.cli.run
from rvdnav import Navigator
from rvdnav.cli import main

class Struck(Navigator):
    def process(self, frame):
        os.kill(os.getpid(), int(os.environ["STRUCK_BY"]))
        return super().process(frame)

rvdnav.cli.run.Navigator = Struck
if "IGNORED" not in os.environ:  # a shell may start its jobs with interrupts ignored
    signal.signal(signal.SIGINT, signal.default_int_handler)
main()
"""


@pytest.mark.parametrize(
    ("ignored", "number", "code"),
    [(False, signal.SIGINT, 130), (False, signal.SIGTERM, 143), (True, signal.SIGTERM, 143)],
)
def test_an_interrupt_leaves_no_output(tmp_path, ignored, number, code):
    command = [sys.executable, "-c", STRUCK, "run", str(EXAMPLE), "--out", str(tmp_path / "out")]
    environment = os.environ | {"STRUCK_BY": str(int(number))}
    if ignored:  # by the parent
        command = ["sh", "-c", "trap '' INT TERM; exec \"$@\"", "sh", *command]
        environment["IGNORED"] = "1"
    result = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert (result.returncode, result.stderr) == (code, "")
    assert list(tmp_path.iterdir()) == []


def test_a_damaged_run_is_bad_input(sequence, tmp_path, capsys):
    add_truth(sequence)
    out = tmp_path / "out"
    execute(["run", str(sequence), "--out", str(out)])
    with (out / "solutions.jsonl").open("a") as file:
        file.write("{}\n")
    capsys.readouterr()
    assert execute(["evaluate", str(sequence), str(out)]) == 2
    assert "solutions.jsonl: line 9" in stderr_line(capsys)


def test_version_and_help(capsys):
    assert execute(["--version"]) == 0
    assert capsys.readouterr().out == f"rvdnav {rvdnav.__version__}\n"
    assert execute(["--help"]) == 0
    text = capsys.readouterr().out
    assert all(command in text for command in ("run", "evaluate", "reconstruct", "replay", "bench"))


def test_the_program_itself_exits_with_the_code(tmp_path):
    program = [sys.executable, "-c", "from rvdnav.cli import main; main()", "run", str(tmp_path), "--out", "x"]
    result = subprocess.run(program, capture_output=True, text=True, check=False, cwd=tmp_path)
    assert result.returncode == 2
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize("text", ["1 0 0 0 0 1", "1 0 0 0 0 0 0.9", "-1 0 0 0 0 0 1"])
def test_a_bad_initial_pose_is_told_in_one_line(make_sequence, tmp_path, capsys, text):
    command = ["run", str(make_sequence(1)), "--out", str(tmp_path / "out"), "--initial-pose", text]
    assert execute(command) == 2
    assert "initial pose" in stderr_line(capsys)
    assert not (tmp_path / "out").exists()
