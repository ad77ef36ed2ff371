"""The black box: what it holds, what it writes when the target is lost, and that the replay gives the same bits."""

from __future__ import annotations

import csv
import hashlib
import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest
from drawn_scene import START_NS, STEP_NS, Look, bracket_target, draw_images, example_rig, frame_of, pose
from rvdnav import Frame, InputError, Navigator, Rig, open_sequence
from rvdnav.blackbox import Recorder, replay
from rvdnav.images import Image, read_image
from rvdnav.output import read_solutions
from rvdnav.solution import Reason, State

RIG, TARGET = example_rig(), bracket_target()
OPTIONS = {"coast_seconds": 0.3, "isa": "scalar"}
STEPS = 6
LOST_NS = START_NS + 8 * STEP_NS


@pytest.fixture(scope="module")
def images() -> list[tuple[np.ndarray, np.ndarray]]:
    """Of a target that comes nearer."""
    poses = [pose(0.8 - 0.01 * step, 0.01, 0.06, 2.0, -3.0, 2.0) for step in range(STEPS)]
    return [draw_images(RIG, TARGET, T, seed=i, look=Look(clutter=False)) for i, T in enumerate(poses)]


def deliveries(images: list[tuple[np.ndarray, np.ndarray]]) -> Iterator[Frame]:
    """Tracked, with a late frame, one with a single image whose stamp is its own; then nothing until it is lost."""
    buffers = [np.empty((RIG.height, RIG.width), np.uint8) for _ in range(2)]
    for step in (0, 1, 2, 4, 3, 5):
        for buffer, image in zip(buffers, images[step], strict=True):
            buffer[:] = image  # one buffer for all frames, as a frame grabber has
        yield frame_of(buffers, START_NS + step * STEP_NS)
    yield Frame(START_NS + 6 * STEP_NS, None, Image(np.zeros_like(buffers[1]), START_NS + 6 * STEP_NS + 300_000))
    yield Frame(START_NS + 7 * STEP_NS, None, None)
    yield frame_of([np.zeros_like(buffer) for buffer in buffers], LOST_NS)


def recorder(**options: object) -> Recorder:
    return Recorder(Navigator(RIG, TARGET, **OPTIONS), RIG, TARGET, OPTIONS, **options)


@pytest.fixture(scope="module")
def lost(images: list[tuple[np.ndarray, np.ndarray]], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The black box of the last seven of nine frames."""
    directory = tmp_path_factory.mktemp("boxes")
    held = recorder(directory=directory, frames=7)
    solutions = [held.process(frame) for frame in deliveries(images)]
    assert [s.state.name[0] for s in solutions] == list("TTTTCTCCL")
    assert len(held) == 0  # each frame is written once
    (box,) = directory.iterdir()
    assert box.name == str(LOST_NS)
    return box


@pytest.fixture
def box(lost: Path, tmp_path: Path) -> Path:
    """A copy to tamper with."""
    shutil.copytree(lost, tmp_path / "box")
    return tmp_path / "box"


def renew_digests(box: Path) -> None:
    names = [line.partition("  ")[2] for line in (box / "SHA256SUMS").read_text().splitlines()]
    lines = [f"{hashlib.sha256((box / name).read_bytes()).hexdigest()}  {name}" for name in names]
    (box / "SHA256SUMS").write_text("\n".join([*lines, ""]))


def test_the_replay_gives_the_same_bits(lost: Path) -> None:
    result = replay(lost)
    assert result.frames == 7
    assert result.difference is None


def test_every_start_replays_to_the_same_bits(images: list[tuple[np.ndarray, np.ndarray]], tmp_path: Path) -> None:
    """The memory before any of the frames is enough to go on from it."""
    for frames in (1, 3, 4, 64):
        held = recorder(frames=frames)
        for frame in deliveries(images):
            held.process(frame)
        held.write(tmp_path / str(frames))
        result = replay(tmp_path / str(frames))
        assert result.difference is None
        assert result.frames == min(frames, 9)


def test_what_is_recorded_is_what_was_delivered(lost: Path, images: list[tuple[np.ndarray, np.ndarray]]) -> None:
    with (lost / "frames.csv").open() as file:
        rows = list(csv.reader(file))[1:]
    steps = [2, 4, 3, 5, 6, 7, 8]
    assert [int(row[0]) for row in rows] == [START_NS + step * STEP_NS for step in steps]
    assert [bool(row[2]) for row in rows] == [True] * 4 + [False, False, True]
    assert [bool(row[4]) for row in rows] == [True] * 5 + [False, True]
    assert int(rows[4][3]) == START_NS + 6 * STEP_NS + 300_000
    for row, step in zip(rows[:4], steps[:4], strict=True):
        for camera in range(2):
            pixels = read_image(lost / f"cam{camera}" / "data" / row[2 + 2 * camera]).pixels
            np.testing.assert_array_equal(pixels, images[step][camera])
    solutions = read_solutions(lost)
    assert [s.reasons for s in solutions[1:4]] == [frozenset(), {Reason.TIME_ORDER}, frozenset()]
    assert len(solutions[0].line_residuals) > 8
    assert solutions[-1].state is State.LOST


def test_it_is_a_sequence_folder(lost: Path) -> None:
    sequence = open_sequence(lost)
    stamps = [frame.timestamp_ns - START_NS for frame in sequence]
    assert stamps == [*(step * STEP_NS for step in (2, 3, 4, 5)), 6 * STEP_NS + 300_000, 8 * STEP_NS]
    np.testing.assert_allclose(sequence.rig.T_world_cam, RIG.T_world_cam, atol=1e-12)
    assert sequence.rig.cameras == RIG.cameras
    for name, point in TARGET.points.items():
        np.testing.assert_allclose(sequence.target.points[name], point, atol=1e-12)
    assert sequence.target.bars == TARGET.bars


def test_an_image_of_the_same_stamp_once_more(images: list[tuple[np.ndarray, np.ndarray]], tmp_path: Path) -> None:
    held = recorder()
    for step in range(2):
        held.process(frame_of(images[step], START_NS))
    held.write(tmp_path / "box")
    assert len(open_sequence(tmp_path / "box")) == 1
    assert replay(tmp_path / "box").frames == 2
    assert replay(tmp_path / "box").difference is None


def test_one_camera(images: list[tuple[np.ndarray, np.ndarray]], tmp_path: Path) -> None:
    rig = Rig(RIG.cameras[:1], RIG.T_world_cam[:1])
    held = Recorder(Navigator(rig, TARGET), rig, TARGET)
    held.process(frame_of((images[0][0], None)))
    held.write(tmp_path / "box")
    assert not (tmp_path / "box" / "cam1").exists()
    assert replay(tmp_path / "box").difference is None


def test_the_digests_are_those_that_sha256sum_gives(lost: Path) -> None:
    lines = [line.split("  ") for line in (lost / "SHA256SUMS").read_text().splitlines()]
    files = {path.relative_to(lost).as_posix() for path in lost.rglob("*") if path.is_file()}
    assert {name for _, name in lines} == files - {"SHA256SUMS"}
    for digest, name in lines:
        assert hashlib.sha256((lost / name).read_bytes()).hexdigest() == digest


def change_a_pixel(box: Path) -> Path:
    """In the left image of the box's first frame, where a corner of the bracket is."""
    path = box / "cam0" / "data" / f"{START_NS + 2 * STEP_NS}.png"
    pixels = read_image(path).pixels
    T = pose(0.78, 0.01, 0.06, 2.0, -3.0, 2.0)
    middle = (TARGET.bracket.outer[0] + TARGET.bracket.outer[1]) / 2
    x, y = np.round(RIG.project(0, T[:3, :3] @ middle + T[:3, 3])).astype(int)
    pixels[y, x] += 20
    cv2.imwrite(str(path), pixels)
    return path


def test_a_changed_pixel_is_found_by_its_digest(box: Path) -> None:
    path = change_a_pixel(box)
    with pytest.raises(InputError, match=rf"{path.name}: is not as it was recorded"):
        replay(box)


def test_a_changed_pixel_changes_the_solution(box: Path) -> None:
    change_a_pixel(box)
    renew_digests(box)
    difference = replay(box).difference
    assert difference is not None
    assert (difference.index, difference.timestamp_ns) == (0, START_NS + 2 * STEP_NS)
    assert difference.field.startswith("T_world_target[0]")
    assert float(difference.recorded) != float(difference.replayed)


def test_the_last_bit_of_a_recorded_number_counts(box: Path) -> None:
    lines = (box / "solutions.jsonl").read_text().splitlines()
    data = json.loads(lines[1])
    before = data["line_residuals"][2]["rms_px"]
    data["line_residuals"][2]["rms_px"] = after = float(np.nextafter(before, 1.0))
    data["stage_times_s"] = {"total": 1e9}  # wall times are not compared
    (box / "solutions.jsonl").write_text("\n".join([lines[0], json.dumps(data), *lines[2:], ""]))
    renew_digests(box)
    difference = replay(box).difference
    assert attrs.astuple(difference) == (
        1,
        START_NS + 4 * STEP_NS,
        "line_residuals[2].rms_px",
        repr(after),
        repr(before),
    )


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("rvdnav", "9.8.7", r"rvdnav 9\.8\.7 \(core ABI"),
        ("core_abi", 99, r"core ABI 99"),
        ("format", 2, r"black box format 2"),
    ],
)
def test_another_version_is_refused(box: Path, key: str, value: object, words: str) -> None:
    path = box / "memory.json"
    data = json.loads(path.read_text())
    data["versions"][key] = value
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match=rf"memory\.json: was recorded by .*{words}.* cannot be replayed by"):
        replay(box)


def test_other_surroundings_are_told_with_a_difference(box: Path) -> None:
    change_a_pixel(box)
    path = box / "memory.json"
    data = json.loads(path.read_text())
    data["versions"]["numpy"] = "0.1"
    path.write_text(json.dumps(data))
    renew_digests(box)
    (note,) = replay(box).notes
    assert note == f"recorded with numpy 0.1, replayed with {np.__version__}"


@pytest.mark.parametrize(
    ("file", "text", "fault"),
    [
        ("memory.json", "{", r"memory\.json: not JSON"),
        ("memory.json", "[]", r"memory\.json: not an object"),
        ("memory.json", "{}", r"memory\.json: doesn't tell the versions"),
        ("frames.csv", "1,2\n", r"frames\.csv: line 1: not a row of timestamp"),
        ("frames.csv", "1,x,y.png,,\n", r"frames\.csv: line 1: 'x' is not a timestamp"),
        ("frames.csv", "#\n", r"frames\.csv: holds no frames"),
        ("frames.csv", "1,,,,\n", r"solutions\.jsonl: holds 7 solutions for 1 frames"),
        ("SHA256SUMS", "x\n", r"SHA256SUMS: line 1: not a digest"),
        ("SHA256SUMS", "0  cam0/data/x.png\n", r"x\.png: no such file"),
    ],
)
def test_what_is_no_black_box(box: Path, file: str, text: str, fault: str) -> None:
    (box / file).write_text(text)
    if file == "frames.csv":
        renew_digests(box)
    with pytest.raises(InputError, match=fault):
        replay(box)


@pytest.mark.parametrize(
    ("key", "fault"), [("memory", "has other fields now"), ("rig", "is no Rig"), ("options", "is no dict")]
)
def test_a_memory_of_another_kind_is_refused(box: Path, key: str, fault: str) -> None:
    path = box / "memory.json"
    data = json.loads(path.read_text())
    if key == "memory":
        del data[key]["fields"]["polarity"]
    else:
        data[key] = 1
    path.write_text(json.dumps(data))
    renew_digests(box)
    with pytest.raises(InputError, match=rf"memory\.json: {key}.*{fault}"):
        replay(box)


def test_a_folder_of_something_else_is_left_alone(images: list[tuple[np.ndarray, np.ndarray]], tmp_path: Path) -> None:
    held = recorder()
    with pytest.raises(ValueError, match="no frames"):
        held.write(tmp_path / "box")
    held.process(frame_of(images[0], START_NS))
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("")
    with pytest.raises(InputError, match=r"mine: is there already"):
        held.write(tmp_path / "mine")
    for _ in range(2):  # an older black box makes way
        held.write(tmp_path / "box")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["box", "mine"]
    assert replay(tmp_path / "box").frames == 1


def test_a_refused_call_is_as_if_it_had_not_been(images: list[tuple[np.ndarray, np.ndarray]], tmp_path: Path) -> None:
    held = recorder()
    held.process(frame_of(images[0], START_NS))
    with pytest.raises(ValueError, match=r"704x100 px, but the rig's are 704x576"):
        held.process(frame_of([image[:100] for image in images[1]], START_NS + STEP_NS))
    held.process(frame_of(images[1], START_NS + STEP_NS))
    held.write(tmp_path / "box")
    again = replay(tmp_path / "box")
    assert (again.frames, again.difference) == (2, None)
    with pytest.raises(ValueError, match="at least one frame"):
        recorder(frames=0)
