"""Recordings in other layouts than our own give the same frames and rig as the same images in ours."""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from conftest import grey, png
from rvdnav import Sequence, open_sequence
from rvdnav.cli.app import execute
from rvdnav.errors import InputError
from rvdnav.pose import exp, make_T
from rvdnav.rig import Rig

MakeSequence = Callable[..., Path]


def same_frames(a: Sequence, b: Sequence) -> None:
    assert a.timestamps_ns == b.timestamps_ns
    for ours, theirs in zip(a, b, strict=True):
        assert ours == theirs


def same_rigs(a: Rig, b: Rig) -> None:
    assert a.cameras == b.cameras
    np.testing.assert_allclose(a.T_world_cam, b.T_world_cam, atol=1e-12)


def sensor_yaml(rig: Rig, camera: int, tagged: bool = False) -> str:
    """As EuRoC's files have it, the body turned and shifted against the cameras."""
    T_body_world = make_T(exp(np.array([0.3, -0.2, 1.1])), np.array([0.1, 0.2, -0.3]))
    T_body_cam = T_body_world @ rig.T_world_cam[camera]
    model = rig.cameras[camera]
    return f"""\
#Default camera yaml file
sensor_type: camera
comment: VI-Sensor cam{camera} (MT9M034)

# Sensor extrinsics wrt. the body-frame.
T_BS:{" !!opencv-matrix" if tagged else ""}
  cols: 4
  rows: 4
{"  dt: d" if tagged else ""}
  data: {T_body_cam.ravel().tolist()}

rate_hz: 8
resolution: [{model.width}, {model.height}]
camera_model: pinhole
intrinsics: [{model.fx}, {model.fy}, {model.cx}, {model.cy}] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: {model.distortion.tolist()}
"""


def euroc(folder: Path, out: Path, tagged: bool = False) -> Path:
    rig = open_sequence(folder).rig
    for camera in range(2):
        shutil.copytree(folder / f"cam{camera}", out / "mav0" / f"cam{camera}")
        (out / "mav0" / f"cam{camera}" / "sensor.yaml").write_text(sensor_yaml(rig, camera, tagged))
    shutil.copy(folder / "target.yaml", out)
    return out


@pytest.mark.parametrize("tagged", [False, True])
def test_a_euroc_folder(make_sequence: MakeSequence, tmp_path: Path, tagged: bool) -> None:
    folder = make_sequence(3)
    out = euroc(folder, tmp_path / "MH_01", tagged)
    sequence = open_sequence(out)
    same_frames(sequence, open_sequence(folder))
    same_rigs(sequence.rig, open_sequence(folder).rig)
    assert sequence.notices == []


def test_a_camchain_beside_a_euroc_folder_is_the_rig(make_sequence: MakeSequence, tmp_path: Path) -> None:
    folder = make_sequence(1)
    out = euroc(folder, tmp_path / "MH_01")
    shutil.copy(folder / "camchain.yaml", out)
    (out / "mav0" / "cam0" / "sensor.yaml").write_text("nonsense: 1")
    assert open_sequence(out).rig == open_sequence(folder).rig


def test_a_rig_yaml_beside_a_euroc_folder_places_its_rig(make_sequence: MakeSequence, tmp_path: Path) -> None:
    folder = make_sequence(1)
    out = euroc(folder, tmp_path / "MH_01")
    rig = open_sequence(folder).rig
    rows = [f"T_world_cam{camera}: {rig.T_world_cam[camera].tolist()}" for camera in range(2)]
    (out / "rig.yaml").write_text("\n".join([*rows, "line_delay_ns: 20000", ""]))
    assert open_sequence(out).rig.line_delay_ns == 20_000
    (out / "rig.yaml").write_text("\n".join([rows[1], rows[1].replace("cam1", "cam0"), ""]))
    with pytest.raises(InputError, match=r"rig\.yaml: disagrees with sensor\.yaml"):
        open_sequence(out)


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("radial-tangential", "equidistant", "distortion_model 'equidistant' is not supported"),
        ("distortion_coefficients: [-0.2,", "distortion_coefficients: [0.1, -0.2,", "is not a list of 4 numbers"),
        ("cols: 4", "cols: 4\n  rows: 3", "is given twice"),
        ("resolution: [70, 58]", "resolution: [70.5, 58]", "resolution is not two whole numbers"),
        ("intrinsics: [66.8,", "intrinsics: [0.0,", "fx is not positive"),
        ("T_BS:", "T_SB:", "T_BS is missing"),
    ],
)
def test_a_sensor_that_is_none(make_sequence: MakeSequence, tmp_path: Path, old: str, new: str, fault: str) -> None:
    out = euroc(make_sequence(1), tmp_path / "MH_01")
    path = out / "mav0" / "cam0" / "sensor.yaml"
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(InputError) as caught:
        open_sequence(out)
    assert str(caught.value).startswith(f"{path}: ")
    assert fault in str(caught.value)


def test_left_and_right_are_other_names(make_sequence: MakeSequence) -> None:
    folder = make_sequence(2)
    expected = list(open_sequence(folder))
    (folder / "cam0").rename(folder / "left")
    (folder / "cam1").rename(folder / "right")
    assert list(open_sequence(folder)) == expected
    (folder / "cam1").mkdir()
    with pytest.raises(InputError, match="cam1: there is right too"):
        open_sequence(folder)


def test_videos_called_left_and_right(make_sequence: MakeSequence) -> None:
    pytest.importorskip("av")
    folder = make_sequence(1)
    for camera, name in enumerate(("left", "right")):
        shutil.rmtree(folder / f"cam{camera}")
        writer = cv2.VideoWriter(str(folder / f"{name}.mp4"), cv2.VideoWriter.fourcc(*"mp4v"), 25, (70, 58))
        for frame in range(4):
            writer.write(cv2.cvtColor(grey(camera, frame), cv2.COLOR_GRAY2BGR))
        writer.release()
    sequence = open_sequence(folder)
    assert sequence.timestamps_ns == (0, 40_000_000, 80_000_000, 120_000_000)
    frame = sequence[2]
    assert frame.left is not None
    assert frame.right is not None
    assert abs(frame.left.pixels.mean() - grey(0, 2).mean()) < 3.0
    assert abs(frame.right.pixels.mean() - grey(1, 2).mean()) < 3.0
    with pytest.raises(InputError, match=r"left\.mp4: has times of its own"):
        open_sequence(folder, rate_hz=25.0)


def counted(folder: Path, names: Callable[[int, int], str], frames: int = 3) -> Path:
    """The sequence's images named anew, and without data.csv."""
    for camera in range(2):
        for frame in range(frames):
            path = folder / names(camera, frame)
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(png(grey(camera, frame)))
        shutil.rmtree(folder / f"cam{camera}" / "data", ignore_errors=True)
        (folder / f"cam{camera}" / "data.csv").unlink()
        if not any((folder / f"cam{camera}").iterdir()):
            (folder / f"cam{camera}").rmdir()
    return folder


@pytest.mark.parametrize(
    "names",
    [
        lambda camera, frame: f"cam{camera}/{frame:06}.png",
        lambda camera, frame: f"{('left', 'right')[camera]}/frame_{10 * frame + 7}.png",
        lambda camera, frame: f"{('left', 'Right')[camera]}{98 + frame}.PNG",
        lambda camera, frame: f"cam{camera}_{frame}.png",
    ],
    ids=["folders", "steps", "one folder", "by camera"],
)
def test_pictures_that_a_number_counts(make_sequence: MakeSequence, names: Callable[[int, int], str]) -> None:
    folder = make_sequence(3)
    expected = [(frame.left.pixels, frame.right.pixels) for frame in open_sequence(folder)]  # type: ignore[union-attr]
    sequence = open_sequence(counted(folder, names), rate_hz=30.0)
    assert sequence.timestamps_ns == (0, 33_333_333, 66_666_667)
    for frame, (left, right) in zip(sequence, expected, strict=True):
        assert frame.left is not None
        assert frame.right is not None
        np.testing.assert_array_equal(frame.left.pixels, left)
        np.testing.assert_array_equal(frame.right.pixels, right)
    assert sequence.notices == []


def test_a_picture_that_is_not_there_leaves_a_gap(make_sequence: MakeSequence) -> None:
    folder = counted(make_sequence(4), lambda camera, frame: f"cam{camera}/{frame:06}.png", frames=4)
    (folder / "cam0" / "000000.png").unlink()
    (folder / "cam1" / "000002.png").unlink()
    sequence = open_sequence(folder, rate_hz=10.0)
    found = [(frame.timestamp_ns, frame.left is not None, frame.right is not None) for frame in sequence]
    assert found == [(0, False, True), (10**8, True, True), (2 * 10**8, True, False), (3 * 10**8, True, True)]


def fault_of(folder: Path, rate_hz: float | None = 10.0) -> str:
    with pytest.raises(InputError) as caught:
        open_sequence(folder, rate_hz=rate_hz)
    return str(caught.value)


def test_pictures_without_a_rate_ask_for_it(make_sequence: MakeSequence) -> None:
    folder = counted(make_sequence(3), lambda camera, frame: f"cam{camera}/{frame:06}.png")
    assert "need a frame rate" in fault_of(folder, None)
    for camera in ("cam0", "cam1"):
        (folder / camera).rename(folder / "kept")
        (folder / camera).mkdir()
        (folder / "kept").rename(folder / camera / "data")
    assert fault_of(folder, None).endswith("names that count need a frame rate")
    assert len(open_sequence(folder, rate_hz=10.0)) == 3


def test_pictures_that_cannot_be_counted(make_sequence: MakeSequence) -> None:
    folder = make_sequence(2)
    assert fault_of(folder).startswith(f"{folder / 'cam0' / 'data.csv'}: has the pictures' times")
    for camera in ("cam0", "cam1"):
        (folder / camera / "data.csv").unlink()
    assert "is named by its time" in fault_of(folder)
    shutil.rmtree(folder / "cam0")
    shutil.rmtree(folder / "cam1")
    assert "holds no pictures of a camera" in fault_of(folder)
    (folder / "left").mkdir()
    (folder / "left" / "first.png").write_bytes(png(grey(0, 0)))
    assert "first.png: has no number" in fault_of(folder)
    (folder / "left" / "first.png").rename(folder / "left" / "1.png")
    (folder / "left" / "01.jpg").write_bytes(b"")
    assert "1.png: has the number of 01.jpg" in fault_of(folder)
    for rate in (0.0, -1.0, float("nan"), float("inf")):
        assert "is not from 0.001 to 100000" in fault_of(folder, rate)


def test_rig_and_target_may_lie_elsewhere(
    make_sequence: MakeSequence, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = make_sequence(2)
    expected = open_sequence(folder)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (folder / "camchain.yaml").rename(elsewhere / "camchain.yaml")
    (folder / "target.yaml").rename(elsewhere / "bracket.yaml")
    for rig in (elsewhere, elsewhere / "camchain.yaml"):
        sequence = open_sequence(folder, rig=rig, target=elsewhere / "bracket.yaml")
        assert sequence.rig == expected.rig
        assert sequence.target == expected.target
        same_frames(sequence, expected)
    with pytest.raises(InputError, match=r"bracket\.yaml: neither a folder nor a camchain\.yaml"):
        open_sequence(folder, rig=elsewhere / "bracket.yaml")
    options = ["--rig", str(elsewhere), "--target", str(elsewhere / "bracket.yaml")]
    assert execute(["info", str(folder), *options]) == 0
    assert "frames" in capsys.readouterr().out
    assert execute(["run", str(folder), *options, "--rate", "8", "--out", str(tmp_path / "out")]) == 2
    assert "has the pictures' times" in capsys.readouterr().err
    shutil.rmtree(folder / "cam1")
    shutil.rmtree(folder / "cam0")
    for frame in range(2):
        (folder / f"left{frame}.png").write_bytes(png(grey(0, frame)))
    assert execute(["run", str(folder), *options, "--rate", "8", "--out", str(tmp_path / "out")]) in (0, 1)
    lines = (tmp_path / "out" / "solutions.jsonl").read_text().splitlines()
    assert [json.loads(line)["timestamp_ns"] for line in lines] == [0, 125_000_000]
    page = (tmp_path / "out" / "report.html").read_text()
    assert "--rate 8 --rig elsewhere --target bracket.yaml" in page
    for name in ("camchain.yaml", "bracket.yaml"):
        assert hashlib.sha256((elsewhere / name).read_bytes()).hexdigest() in page
