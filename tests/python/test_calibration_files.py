"""Where calibration pictures come from, OpenCV's files, and the command."""

from __future__ import annotations

import importlib
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from board_scene import RIG, T_cam0_boards, draw_pair
from conftest import png
from rvdnav.calibration import ImagePair, read_pairs
from rvdnav.calibration.board import parse_corners, parse_length
from rvdnav.calibration.opencv_file import OPENCV_FILE, load_opencv, save_opencv
from rvdnav.cli.app import execute
from rvdnav.errors import CoreError, InputError
from rvdnav.rig import load_rig

SIZE = (40, 30)


def image(value: int) -> np.ndarray:
    return np.full(SIZE[::-1], value, np.uint8)


def write_images(folder: Path, names: list[str], *, ending: str = ".png") -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for number, name in enumerate(names):
        assert cv2.imwrite(str(folder / (name + ending)), image(10 * number))


def greys(pairs: list[ImagePair]) -> list[tuple[str, object, object]]:
    return [
        (pair.name, *(p if isinstance(p, str) else round(float(p.mean()), -1) for p in pair.images)) for pair in pairs
    ]


@pytest.mark.parametrize("below", ["", "data"])
def test_folders_of_each_camera(tmp_path: Path, below: str) -> None:
    write_images(tmp_path / "cam0" / below, ["a", "b", "c"])
    write_images(tmp_path / "cam1" / below, ["a", "c"], ending=".bmp")
    assert greys(list(read_pairs(tmp_path))) == [
        ("a", 0, 0),
        ("b", 10, "there is no image of the right camera"),
        ("c", 20, 10),
    ]


NS = 1403709383937837056


def test_images_named_by_their_time_are_paired_by_it(tmp_path: Path) -> None:
    write_images(tmp_path / "cam0" / "data", [str(NS), str(NS + 500_000_000), str(NS + 900_000_000)])
    write_images(tmp_path / "cam1" / "data", [str(NS + 4_211), str(NS + 899_999_000)], ending=".jpg")
    assert greys(list(read_pairs(tmp_path))) == [
        (str(NS), 0, 0),
        (str(NS + 500_000_000), 10, "there is no image of the right camera"),
        (str(NS + 900_000_000), 20, 10),
    ]


def test_listed_images_are_paired_by_the_time_in_the_list(tmp_path: Path) -> None:
    """The right camera's second frame was lost, so that equal names are not of one time."""
    for camera, times in enumerate(((0, 1, 2), (0, 2))):
        names = [f"{number:04d}" for number in range(len(times))]
        write_images(tmp_path / f"cam{camera}" / "data", names)
        rows = [f"{NS + 10**9 * time},{name}.png" for time, name in zip(times, names, strict=True)]
        (tmp_path / f"cam{camera}" / "data.csv").write_text("\n".join(rows) + "\n")
    assert greys(list(read_pairs(tmp_path))) == [
        ("0000", 0, 0),
        ("0001", 10, "there is no image of the right camera"),
        ("0002", 20, 10),
    ]


def test_images_of_other_times_are_no_pairs(tmp_path: Path) -> None:
    write_images(tmp_path / "cam0", [str(NS)])
    write_images(tmp_path / "cam1", [str(NS + 2_000_000)])
    with pytest.raises(InputError, match="no image of the left camera has one of the right camera within 1 ms"):
        read_pairs(tmp_path)


def test_left_and_right_names(tmp_path: Path) -> None:
    write_images(tmp_path, ["left01", "left02", "right01", "right02"], ending=".jpg")
    assert greys(list(read_pairs(tmp_path))) == [("01", 0, 20), ("02", 10, 30)]


def test_an_image_list(tmp_path: Path) -> None:
    write_images(tmp_path, ["p", "q", "r", "s"])
    names = "".join(f'"{name}.png" ' for name in "pqr") + '"none.png"'
    (tmp_path / "list.xml").write_text(
        f'<?xml version="1.0"?><opencv_storage><imagelist>{names}</imagelist></opencv_storage>'
    )
    first, second = greys(list(read_pairs(tmp_path / "list.xml")))
    assert first == ("p", 0, 10)
    assert "none.png cannot be read" in str(second[2])


def write_film(path: Path, rate: float, start: int) -> None:
    film = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), rate, SIZE)
    assert film.isOpened()
    for number in range(12):
        film.write(cv2.cvtColor(image(10 * number + start), cv2.COLOR_GRAY2BGR))
    film.release()


def test_a_film_of_each_camera(tmp_path: Path) -> None:
    write_film(tmp_path / "left.avi", 10.0, 0)
    write_film(tmp_path / "right.avi", 10.0, 100)
    assert greys(list(read_pairs(tmp_path))) == [("frame 0", 0, 100), ("frame 5", 50, 150), ("frame 10", 100, 200)]


def test_films_of_different_rates_are_refused(tmp_path: Path) -> None:
    write_film(tmp_path / "left.avi", 25.0, 0)
    write_film(tmp_path / "right.avi", 30.0, 0)
    with pytest.raises(InputError, match=r"right\.avi: has 30 frames/s but left\.avi has 25"):
        list(read_pairs(tmp_path))


def test_a_damaged_image_costs_its_view_alone(tmp_path: Path) -> None:
    write_images(tmp_path, ["left1", "left2", "right1", "right2"])
    whole = (tmp_path / "right2.png").read_bytes()
    (tmp_path / "right2.png").write_bytes(whole[: len(whole) // 2])
    assert greys(list(read_pairs(tmp_path)))[1] == ("2", 10, "right2.png is truncated")


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        ({}, "holds neither cam0 and cam1, nor images or films called left* and right*"),
        ({"cam0/a.png": b""}, "has a folder of one camera alone, but none called cam1 or right"),
        ({"cam0/a.png": b"", "cam1/b.png": b""}, "no image of the left camera has one of the right camera"),
        ({"left1.png": b"", "cam0_1.png": b""}, "which are meant?"),
    ],
)
def test_folders_that_hold_no_pairs(tmp_path: Path, content: dict[str, bytes], fault: str) -> None:
    for name, data in content.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError) as caught:
        list(read_pairs(tmp_path))
    assert fault in str(caught.value)


def test_the_words_of_the_command_line() -> None:
    assert parse_corners("9x6") == (9, 6)
    assert parse_length("--square", "25mm") == pytest.approx(0.025)
    assert parse_length("--square", "2.5 cm") == pytest.approx(0.025)
    for text in ("25", "mm", "-1mm", "25 km", "nan mm"):
        with pytest.raises(InputError, match="--square"):
            parse_length("--square", text)
    for text in ("9", "9x", "9x6x5", "axb"):
        with pytest.raises(InputError, match="--board"):
            parse_corners(text)


def test_opencv_reads_what_is_written(tmp_path: Path) -> None:
    path = tmp_path / OPENCV_FILE
    save_opencv(RIG, path)
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    assert np.array_equal(storage.getNode("M1").mat(), RIG.cameras[0].K)
    assert np.array_equal(storage.getNode("D2").mat().ravel(), [*RIG.cameras[1].distortion, 0.0])
    again = load_opencv(path)
    assert again.cameras == RIG.cameras
    assert np.allclose(again.T_world_cam[0], RIG.T_world_cam[0], atol=1e-12)


def opencv_file(path: Path, header: str | None = None, **changes: object) -> None:
    """As OpenCV itself writes it, with a header of our choice."""
    T = np.linalg.inv(RIG.T_world_cam[1]) @ RIG.T_world_cam[0]
    values: dict[str, object] = {"image_width": RIG.width, "image_height": RIG.height, "R": T[:3, :3], "T": T[:3, 3:]}
    for number, camera in enumerate(RIG.cameras, start=1):
        values |= {f"M{number}": camera.K, f"D{number}": camera.distortion[None]}
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for key, value in (values | changes).items():
        if value is not None:
            storage.write(key, value)
    storage.release()
    if header is not None:
        path.write_text(path.read_text().replace(path.read_text().splitlines()[0], header, 1))


@pytest.mark.parametrize("header", [None, "%YAML:1.0", "%YAML 1.2"])
@pytest.mark.parametrize("terms", [4, 5, 8, 14])
def test_what_opencv_writes_is_read(tmp_path: Path, header: str | None, terms: int) -> None:
    path = tmp_path / "stereo.yaml"
    opencv_file(path, header, D1=np.append(RIG.cameras[0].distortion, np.zeros(terms - 4))[None])
    assert load_opencv(path).cameras == RIG.cameras


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"D1": np.array([[-0.2, 0.06, 0.0, 0.0, 0.01]])}, "D1 has 5 terms; only k1, k2, p1, p2 are supported"),
        ({"D2": np.array([[-0.2, 0.06, 0.0, 0.0, 0.0, 0.1, 0.0, 0.0]])}, "D2 has 6 terms"),
        ({"D2": np.array([[-0.2, 0.06]])}, "D2 is not a matrix of 4 numbers"),
        ({"M1": None}, "M1 is missing"),
        ({"M2": np.eye(3) + np.eye(3)[[1, 0, 2]]}, "M2 is not an intrinsic matrix without skew"),
        ({"R": np.ones((3, 3))}, "the rotation is none"),
        ({"image_width": None}, "image_width is missing"),
        ({"T": np.zeros((3, 1))}, "the baseline is zero"),
    ],
)
def test_files_that_are_not_ours_are_refused(tmp_path: Path, changes: dict[str, object], fault: str) -> None:
    path = tmp_path / "stereo.yaml"
    opencv_file(path, **changes)
    with pytest.raises(InputError) as caught:
        load_opencv(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert fault in str(caught.value)


@pytest.mark.parametrize("text", ["", "words", "<xml", "%YAML:1.0\n---\nM1: 3\n"])
def test_files_that_are_no_storage(tmp_path: Path, text: str) -> None:
    path = tmp_path / "stereo.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=r"stereo\.yaml"):
        load_opencv(path)


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pictures")
    for number, T in enumerate(T_cam0_boards(6)):
        for side, pixels in zip(("left", "right"), draw_pair("", T).images, strict=True):
            assert not isinstance(pixels, str)
            (folder / f"{side}{number}.png").write_bytes(png(pixels))
    return folder


def command(pictures: Path, out: Path, *more: str, square: str = "30mm") -> int:
    return execute(["calibrate", str(pictures), "--board", "7x5", "--square", square, "--out", str(out), *more])


def test_the_command(pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    (pictures / "left9.png").write_bytes(b"")
    assert command(pictures, out, "--baseline", "12cm") == 0
    told = capsys.readouterr()
    assert "6 used, 1 dropped" in told.out
    assert "view 9 dropped: left: left9.png is not a PNG image; right: there is no image" in told.err
    rig = load_rig(out)
    assert rig.calibration_covariance is not None
    assert rig.baseline == pytest.approx(RIG.baseline, abs=1e-3)
    assert load_opencv(out / OPENCV_FILE).cameras == rig.cameras


def test_a_wrong_square_shows_in_a_known_baseline(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert command(pictures, out, "--baseline", "120mm", square="25mm") == 2
    told = capsys.readouterr().err
    assert "the baseline comes out as 100.0" in told
    assert "squares of 29.99" in told or "squares of 30.0" in told
    assert not out.exists()


@pytest.mark.parametrize(
    ("more", "fault"),
    [
        (["--marker", "40mm"], "a marker is smaller than its square"),
        (["--marker", "20mm", "--dictionary", "9X9_1"], "no dictionary of markers called '9X9_1'"),
        (["--dictionary", "4X4_50"], "--marker size is not given"),
        (["--baseline", "120"], "--baseline: '120' is not a length with its unit"),
    ],
)
def test_bad_options(
    pictures: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str], fault: str
) -> None:
    assert command(pictures, tmp_path / "out", *more) == 2
    assert fault in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def refused(status: Exception) -> Callable[..., None]:
    def refuse(*_: object) -> None:
        raise status

    return refuse


@pytest.mark.parametrize(
    ("place", "error"),
    [
        ("calibration.calibrate.Core", CoreError(-5, "a lens of no use")),
        ("cli.calibrate.verdict", ValueError("a lens of no use")),
    ],
)
def test_a_rig_of_no_use_is_refused_in_one_line(
    place: str,
    error: Exception,
    pictures: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    module, name = f"rvdnav.{place}".rsplit(".", 1)
    monkeypatch.setattr(importlib.import_module(module), name, refused(error))
    assert command(pictures, tmp_path / "out") == 2
    told = [line for line in capsys.readouterr().err.splitlines() if "note:" not in line]
    assert len(told) == 1
    assert told[0].startswith(f"rvdnav: {pictures}: ")
    assert told[0].endswith("a lens of no use")
    assert not (tmp_path / "out").exists()


def test_pictures_without_a_board(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_images(tmp_path / "in", ["left1", "right1"])
    assert command(tmp_path / "in", tmp_path / "out") == 2
    told = capsys.readouterr().err.splitlines()
    assert told[0] == "rvdnav: note: view 1 dropped: the board was not found"
    assert "0 usable views of the chessboard of 7x5 inner corners, where 3 are needed" in told[1]
    assert not (tmp_path / "out").exists()


REPORTS = Path(__file__).resolve().parents[3] / "shared" / "cases" / "reports"


@pytest.mark.skipif(not REPORTS.is_dir(), reason="the reported pictures are not there")
@pytest.mark.parametrize(
    ("name", "used", "dropped"),
    [
        ("pairs_one_frame_lost", 7, 6),
        ("names_by_nanoseconds", 6, 0),
        ("exif_orientation", 12, 0),
        ("exif_orientation_portrait", 12, 0),
    ],
)
def test_reported_pictures(
    name: str, used: int, dropped: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command(REPORTS / name, tmp_path / "out") == 0
    assert f"views: {used} used, {dropped} dropped" in capsys.readouterr().out
    rig = load_rig(tmp_path / "out")
    assert rig.baseline == pytest.approx(0.12, abs=1e-4)
    assert rig.cameras[0].fx == pytest.approx(334.2, abs=0.3)


SEARCHING = """
import os, signal
import rvdnav.calibration.views
from rvdnav.cli import main

find = rvdnav.calibration.views.find_board

def announced(image, board):
    os.write(1, b"searching")
    return find(image, board)

rvdnav.calibration.views.find_board = announced
if "IGNORED" not in os.environ:  # a shell may start its jobs with interrupts ignored
    signal.signal(signal.SIGINT, signal.default_int_handler)
main()
"""


@pytest.mark.parametrize(
    ("ignored", "sent", "code"),
    [
        (False, [signal.SIGINT], 130),
        (False, [signal.SIGTERM], 143),
        (True, [signal.SIGINT, signal.SIGTERM], 143),  # whose parent wants interrupts ignored ends by the other alone
    ],
)
def test_an_interrupt_ends_the_search_for_the_board(
    tmp_path: Path, ignored: bool, sent: list[signal.Signals], code: int
) -> None:
    """Within a picture: all of them would take minutes."""
    noise = np.random.default_rng(1).integers(0, 256, (960, 1280), dtype=np.uint8)
    pictures = tmp_path / "pictures"
    pictures.mkdir()
    (tmp_path / "noise.bmp").write_bytes(cv2.imencode(".bmp", noise)[1].tobytes())
    for number in range(200):
        for side in ("left", "right"):
            (pictures / f"{side}{number:03d}.bmp").symlink_to(tmp_path / "noise.bmp")
    before = sorted(tmp_path.rglob("*"))
    program = [sys.executable, "-c", SEARCHING, "calibrate", str(pictures), "--board", "9x6", "--square", "25mm"]
    command = [*program, "--out", str(tmp_path / "out")]
    if ignored:
        command = ["sh", "-c", "trap '' INT; exec \"$@\"", "sh", *command]
    environment = os.environ | ({"IGNORED": "1"} if ignored else {})
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=environment) as process:
        assert process.stdout is not None
        process.stdout.read(len("searching"))
        for number in sent:
            process.send_signal(number)
        try:
            _, errors = process.communicate(timeout=30.0)
        finally:
            process.kill()
    assert (process.returncode, errors) == (code, b"")
    assert sorted(tmp_path.rglob("*")) == before
