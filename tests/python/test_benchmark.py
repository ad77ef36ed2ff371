"""The speed table, over a scripted navigator whose stage times are known."""

import pytest
import rvdnav.benchmark
from rvdnav.benchmark import benchmark
from rvdnav.cli.app import execute
from rvdnav.errors import InputError
from rvdnav.sequence import open_sequence
from solutions import FRAMES, Scripted


@pytest.fixture
def sequence(make_sequence, monkeypatch):
    monkeypatch.setattr(rvdnav.benchmark, "Navigator", Scripted)
    return make_sequence(FRAMES)


def test_acquisition_is_every_frame_afresh_and_tracking_what_follows_a_pose(sequence):
    result = benchmark(open_sequence(sequence))
    assert result.acquisition.frames == FRAMES
    assert result.acquisition.stages == pytest.approx({"edges": 0.002, "refine": 0.004})  # always the run's first
    assert result.tracking.frames == 5  # 2, 3, 4, 5 and 7: those after 1, 2, 3, 4 and 6
    assert result.tracking.stages == pytest.approx({"edges": 0.002, "refine": 0.008})
    assert 0 < result.acquisition.frame < 1
    assert result.canny > 0
    assert result.hough > 0


def test_frames_of_one_camera_are_not_timed(sequence):
    for image in sorted((sequence / "cam1" / "data").iterdir())[1:]:
        image.write_bytes(b"")
    assert benchmark(open_sequence(sequence)).acquisition.frames == 1
    for image in (sequence / "cam1" / "data").iterdir():
        image.write_bytes(b"")
    with pytest.raises(InputError, match="no stereo frames"):
        benchmark(open_sequence(sequence))


def test_the_table(sequence, capsys):
    assert execute(["bench", str(sequence)]) == 0
    text = capsys.readouterr().out
    for row in ("edges", "refine", "whole frame", "frames/s", "cv2.Canny(image, 50, 150)", "cv2.HoughLines"):
        assert row in text
    assert "8.00" in text


def test_without_a_sequence_the_example_is_taken(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(rvdnav, "__file__", str(tmp_path / "a" / "b" / "__init__.py"))
    assert execute(["bench"]) == 2
    assert "examples/approach: no such file or folder" in capsys.readouterr().err
