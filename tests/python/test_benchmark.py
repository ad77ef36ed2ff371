"""The speed table, over a scripted navigator whose stage times are known."""

import json

import compare
import numpy as np
import pytest
import rvdnav.benchmark
from rvdnav.benchmark import ACQUISITION, CANNY, TRACKING, TRACKING_ONE_CORE, Times, benchmark
from rvdnav.cli.app import execute
from rvdnav.errors import InputError
from rvdnav.jsonio import parse_object
from rvdnav.sequence import open_sequence
from solutions import FRAMES, Scripted


@pytest.fixture
def sequence(make_sequence, monkeypatch):
    monkeypatch.setattr(rvdnav.benchmark, "Navigator", Scripted)
    return make_sequence(FRAMES)


def test_acquisition_is_every_frame_afresh_and_tracking_what_follows_a_pose(sequence):
    result = benchmark(open_sequence(sequence), FRAMES)
    assert [len(result.whole[name].seconds) for name in (ACQUISITION, TRACKING, TRACKING_ONE_CORE)] == [FRAMES, 5, 5]
    assert result.stages[ACQUISITION] == pytest.approx({"edges": 0.002, "refine": 0.004})  # always the run's first
    assert result.stages[TRACKING] == pytest.approx({"edges": 0.002, "refine": 0.008})  # 2, 3, 4, 5 and 7
    assert all((times.seconds > 0).all() for times in (*result.whole.values(), *result.yardsticks.values()))
    assert result.yardsticks[CANNY].ratio == 1.0


def test_frames_are_shown_forth_and_back_at_even_times(make_sequence, monkeypatch):
    shown = {}

    class Listening(Scripted):
        def process(self, frame):
            shown[frame.timestamp_ns] = frame.left.pixels
            return super().process(frame)

    monkeypatch.setattr(rvdnav.benchmark, "Navigator", Listening)
    sequence = open_sequence(make_sequence(3))
    benchmark(sequence, 6)
    recorded = [frame.left.pixels for frame in sequence]
    order = [next(i for i, r in enumerate(recorded) if np.array_equal(r, s)) for _, s in sorted(shown.items())]
    assert order == [0, 1, 2, 1, 0, 1]
    assert len(set(np.diff(sorted(shown)))) == 1


def test_the_ratio_is_the_median_of_the_turns_ratios():
    times = Times([0.1, 0.4, 0.9], [0.1, 0.2, 0.3])
    assert times.ratio == 2.0
    assert times.percentile(50) == 0.4


def test_frames_of_one_camera_are_not_timed(sequence):
    for image in sorted((sequence / "cam1" / "data").iterdir())[2:]:
        image.write_bytes(b"")
    assert len(benchmark(open_sequence(sequence), 2).whole[ACQUISITION].seconds) == 2
    for image in (sequence / "cam1" / "data").iterdir():
        image.write_bytes(b"")
    with pytest.raises(InputError, match="no stereo frames"):
        benchmark(open_sequence(sequence), 2)


def test_the_table_and_the_record(sequence, tmp_path, capsys):
    path = tmp_path / "figures.json"
    assert execute(["bench", str(sequence), "--frames", str(FRAMES), "--json", str(path)]) == 0
    text = capsys.readouterr().out
    for row in ("edges", "refine", ACQUISITION, TRACKING, CANNY, "HoughLines", "solvePnP"):
        assert row in text
    assert "8.00" in text
    record = parse_object(path.read_text())
    assert record["times"][TRACKING]["count"] == 5
    assert record["machine"]["image"] == "70x58"


def test_a_record_is_compared_by_its_ratios_and_only_with_one_of_the_same_machine(tmp_path, monkeypatch, capsys):
    def compared(ratio, processor="one"):
        paths = []
        for name, r, p in (("before", 2.0, "one"), ("after", ratio, processor)):
            machine = {"processor": p, "image": "704x576", "isa": "scalar"}
            record = {"machine": machine, "times": {"tracking": {"ratio": r, "p50": 1.0 / r}}}
            paths.append(tmp_path / f"{name}.json")
            paths[-1].write_text(json.dumps(record))
        monkeypatch.setattr("sys.argv", ["compare.py", *map(str, paths)])
        with pytest.raises(SystemExit) as end:
            compare.main()
        return end.value.code

    assert compared(2.19) == 0
    assert "+9 %" in capsys.readouterr().out
    assert compared(2.21) == 1
    assert compared(2.0, processor="other") == 2


def test_without_a_sequence_the_example_is_taken(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(rvdnav, "__file__", str(tmp_path / "a" / "b" / "__init__.py"))
    assert execute(["bench"]) == 2
    assert "examples/approach: no such file or folder" in capsys.readouterr().err
