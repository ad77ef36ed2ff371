"""ROS 2 bags, written by the library `rosbags`, give the frames, rig and poses of the same images in a folder."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from conftest import START_NS, STEP_NS, grey, png
from drawn_scene import EXAMPLE
from rvdnav import Navigator, Sequence, open_sequence
from rvdnav.cli.app import execute
from rvdnav.errors import InputError
from rvdnav.ros.topics import COMPRESSED_IMAGE, IMAGE, choose_topics

pytest.importorskip("rosbags")
from bag_files import CompressionMode, camera_info, compressed, image, mounted, write_bag

MakeSequence = Callable[..., Path]
SIDES = ("left", "right")
FRAMES = 4


def recorded(sequence: Sequence, frames: int, infos: bool = False, **changes: Any) -> list[tuple[str, int, Any]]:
    """The messages of a stereo driver; each is logged a little after its stamp."""
    messages = []
    for number in range(frames):
        frame = sequence[number]
        for camera, (side, shot) in enumerate(zip(SIDES, (frame.left, frame.right), strict=True)):
            assert shot is not None
            logged = shot.timestamp_ns + 3_000_000 + camera
            messages.append((f"/stereo/{side}/image_raw", logged, image(shot.timestamp_ns, shot.pixels, frame=side)))
            if infos:
                info = camera_info(sequence.rig, camera, shot.timestamp_ns, side, **changes)
                messages.append((f"/stereo/{side}/camera_info", logged, info))
    return messages


def beside(folder: Path, *names: str, of: Path) -> None:
    for name in names:
        shutil.copy(of / name, folder)


@pytest.fixture(scope="module")
def example() -> Sequence:
    return open_sequence(EXAMPLE)


@pytest.fixture(scope="module")
def poses(example: Sequence) -> list[np.ndarray]:
    navigator = Navigator(example.rig, example.target)
    solved = [navigator.process(example[number]).T_world_target for number in range(FRAMES)]
    assert all(pose is not None for pose in solved)
    return solved  # type: ignore[return-value]


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_poses_are_those_of_the_folder_bit_by_bit(
    tmp_path: Path, example: Sequence, poses: list[np.ndarray], storage: str
) -> None:
    bag = write_bag(tmp_path / "bag", recorded(example, FRAMES), storage)
    beside(bag, "camchain.yaml", "rig.yaml", "target.yaml", of=EXAMPLE)
    sequence = open_sequence(bag)
    assert sequence.rig == example.rig
    assert sequence.timestamps_ns == example.timestamps_ns[:FRAMES]
    for number in (2, 0, 3, 1, 1):
        assert sequence[number] == example[number]
    navigator = Navigator(sequence.rig, sequence.target)
    for frame, pose in zip(sequence, poses, strict=True):
        solution = navigator.process(frame)
        assert solution.T_world_target is not None
        assert solution.T_world_target.tobytes() == pose.tobytes()
    assert sequence.notices == []


def test_the_file_of_a_bag_by_itself(tmp_path: Path, example: Sequence) -> None:
    for storage, ending in (("sqlite3", "db3"), ("mcap", "mcap")):
        bag = write_bag(tmp_path / storage, recorded(example, 2), storage)
        beside(tmp_path, "camchain.yaml", "target.yaml", of=EXAMPLE)
        shutil.copy(bag / f"{storage}.{ending}", tmp_path)
        sequence = open_sequence(tmp_path / f"{storage}.{ending}")
        assert [sequence[0], sequence[1]] == [example[0], example[1]]


def test_compressed_bags(tmp_path: Path, example: Sequence) -> None:
    for mode, storage in ((CompressionMode.MESSAGE, "sqlite3"), (CompressionMode.STORAGE, "mcap")):
        bag = write_bag(tmp_path / mode.name, recorded(example, 2), storage, mode)
        assert list(opened(bag, example, "camchain.yaml")) == [example[0], example[1]]
    bag = write_bag(tmp_path / "file", recorded(example, 1), "sqlite3", CompressionMode.FILE)
    assert "its files are compressed as a whole" in fault_of(bag, example)
    (bag / "file.db3.zstd").rename(bag / "file.db3")
    metadata = (bag / "metadata.yaml").read_text()
    (bag / "metadata.yaml").write_text(metadata.replace("file.db3.zstd", "file.db3"))
    assert "cannot be read as a ROS 2 bag: " in fault_of(bag, example)  # it may write nothing, or could fill the disk


def small(make_sequence: MakeSequence, frames: int = 2) -> Sequence:
    return open_sequence(make_sequence(frames))


def opened(bag: Path, of: Sequence, *names: str, **options: Any) -> Sequence:
    beside(bag, "target.yaml", *names, of=of.path)
    return open_sequence(bag, **options)


def test_the_rig_is_that_of_the_camera_infos(tmp_path: Path, example: Sequence) -> None:
    bag = write_bag(tmp_path / "bag", recorded(example, 2, infos=True))
    rig = opened(bag, example).rig
    assert rig.cameras == example.rig.cameras
    np.testing.assert_allclose(rig.T_world_cam, example.rig.T_world_cam, atol=1e-12)


def test_the_rig_is_that_of_tf_static(tmp_path: Path, example: Sequence) -> None:
    no_baseline = np.array([650.0, 0, 340, 0, 0, 650, 280, 0, 0, 0, 1, 0])
    messages = recorded(example, 2, infos=True, p=no_baseline)
    bag = write_bag(tmp_path / "bag", [("/tf_static", messages[0][1], mounted(example.rig)), *messages])
    rig = opened(bag, example).rig
    assert rig.cameras == example.rig.cameras
    np.testing.assert_allclose(rig.T_world_cam, example.rig.T_world_cam, atol=1e-9)
    alone = write_bag(tmp_path / "alone", messages)
    assert "neither P of the camera_info nor /tf_static says" in fault_of(alone, example)


def test_rectified_images_are_those_of_p(tmp_path: Path, example: Sequence) -> None:
    messages = [
        (topic.replace("image_raw", "image_rect"), logged, message)
        for topic, logged, message in recorded(example, 2, infos=True)
    ]
    rig = opened(write_bag(tmp_path / "bag", messages), example).rig
    for model in rig.cameras:
        assert (model.fx, model.fy, model.cx, model.cy) == (650.0, 650.0, 340.0, 280.0)
        assert not model.distortion.any()
    np.testing.assert_allclose(rig.T_world_cam[0][:3, 3], [0.0, 0.0, example.rig.baseline], atol=1e-12)
    np.testing.assert_allclose(rig.T_world_cam[0][:3, :3], rig.T_world_cam[1][:3, :3], atol=1e-12)


def test_a_rig_yaml_beside_a_bag_places_its_rig(tmp_path: Path, example: Sequence) -> None:
    bag = write_bag(tmp_path / "bag", recorded(example, 1, infos=True))
    rig = opened(bag, example, "rig.yaml").rig
    assert rig.calibration_covariance is not None
    assert not rig.calibration_covariance.any()


def fault_of(bag: Path, of: Sequence, *names: str, **options: Any) -> str:
    with pytest.raises(InputError) as caught:
        opened(bag, of, *names, **options)
    message = str(caught.value)
    assert message.startswith(str(bag))
    assert message.isprintable()
    return message


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"distortion_model": "equidistant"}, "has the distortion 'equidistant'"),
        ({"d": np.array([0.1, 0.0, 0.0, 0.0, 0.01])}, "only plumb_bob of k1 k2 p1 p2 is read"),
        ({"k": np.zeros(9)}, "the camera is not calibrated"),
        ({"k": np.array([66.0, 1, 35, 0, 66, 28, 0, 0, 1])}, "more than fx, fy, cx, cy"),
        ({"k": np.array([6.0, 0, 35, 0, 66, 28, 0, 0, 1])}, "fx = 6 is not 7 to 7000 px"),
        ({"k": np.array([np.nan, 0, 35, 0, 66, 28, 0, 0, 1])}, "not finite"),
        ({"r": np.full(9, 0.5)}, "R of a camera_info is none"),
        ({"binning_x": 2}, "pixels binned"),
        ({"width": 8}, "the size is 8 x 58"),
        ({"width": 72}, "is 70x58 but the calibration is for 72x58"),
    ],
)
def test_camera_infos_that_are_of_no_use(
    make_sequence: MakeSequence, tmp_path: Path, changes: dict[str, Any], fault: str
) -> None:
    sequence = small(make_sequence)
    bag = write_bag(tmp_path / "bag", recorded(sequence, 2, infos=True, **changes))
    assert fault in fault_of(bag, sequence)


def test_a_calibration_that_changes_is_refused(make_sequence: MakeSequence, tmp_path: Path) -> None:
    sequence = small(make_sequence)
    messages = recorded(sequence, 1, infos=True)
    later = camera_info(sequence.rig, 1, START_NS + STEP_NS, "right", d=np.zeros(5))
    bag = write_bag(tmp_path / "bag", [*messages, ("/stereo/right/camera_info", START_NS + STEP_NS, later)])
    assert "the camera_info beside /stereo/right/image_raw changes" in fault_of(bag, sequence)


def test_a_bag_without_calibration_asks_for_it(make_sequence: MakeSequence, tmp_path: Path) -> None:
    sequence = small(make_sequence)
    bag = write_bag(tmp_path / "bag", recorded(sequence, 1))
    assert "has no camera_info beside /stereo/left/image_raw, and there is no camchain.yaml" in fault_of(bag, sequence)
    assert open_sequence(bag, rig=sequence.path).rig == sequence.rig


def stored(make_sequence: MakeSequence, path: Path, messages: list[Any], **options: Any) -> Sequence:
    """A bag of the left camera's messages, a second apart from START_NS on."""
    timed = [("/left/image_raw", START_NS + 10**9 * number, message) for number, message in enumerate(messages)]
    sequence = small(make_sequence, 1)
    return opened(write_bag(path, timed), sequence, "camchain.yaml", **options)


def pixels_of(sequence: Sequence) -> list[np.ndarray | None]:
    return [None if frame.left is None else frame.left.pixels for frame in sequence]


def test_encodings(make_sequence: MakeSequence, tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    plain = rng.integers(0, 256, (58, 70)).astype(np.uint8)
    deep = np.linspace(0, 65535, 58 * 70).astype(np.uint16).reshape(58, 70)
    colour = rng.integers(0, 256, (58, 70, 3)).astype(np.uint8)
    four = np.dstack([colour, plain])
    luma = cv2.cvtColor(colour, cv2.COLOR_BGR2GRAY)
    scaled = np.rint(deep / 65535 * 255).astype(np.uint8)
    stamps = [START_NS + 10**9 * number for number in range(9)]
    messages = [
        image(stamps[0], plain, "mono8", padding=3),
        image(stamps[1], plain, "8UC1"),
        image(stamps[2], deep, "mono16", padding=2),
        image(stamps[3], deep.byteswap(), "16UC1", big=True),
        image(stamps[4], colour, "bgr8", padding=2),
        image(stamps[5], colour[..., ::-1], "rgb8"),
        image(stamps[6], four, "bgra8"),
        image(stamps[7], four[..., [2, 1, 0, 3]], "rgba8"),
    ]
    sequence = stored(make_sequence, tmp_path / "bag", messages)
    expected = [plain, plain, scaled, scaled, luma, luma, luma, luma]
    for found, wanted in zip(pixels_of(sequence), expected, strict=True):
        np.testing.assert_array_equal(found, wanted)
    told = [notice.split(" images")[0] for notice in sequence.notices[1:]]
    assert told == ["16-bit", "colour"]


def test_an_encoding_that_is_not_read(make_sequence: MakeSequence, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"/left/image_raw has images in 'bayer_rggb8'; what is read is mono8, "):
        stored(make_sequence, tmp_path / "bag", [image(START_NS, grey(0, 0), "bayer_rggb8")])


def test_images_whose_data_are_too_few_are_missing(make_sequence: MakeSequence, tmp_path: Path) -> None:
    short = image(START_NS, grey(0, 0))
    short.data = short.data[:-1]
    narrow = image(START_NS + 10**9, grey(0, 0))
    narrow.step = 69
    sequence = stored(make_sequence, tmp_path / "bag", [short, narrow, image(START_NS + 2 * 10**9, grey(0, 2))])
    found = pixels_of(sequence)
    assert [pixels is None for pixels in found] == [True, True, False]
    assert f"/left/image_raw at {START_NS // 10**9}.000000000 s is truncated: the frame goes on without it" in (
        sequence.notices
    )
    assert any("has rows of 69 bytes where 70 are needed" in notice for notice in sequence.notices)


def test_compressed_images(make_sequence: MakeSequence, tmp_path: Path) -> None:
    jpeg = cv2.imencode(".jpg", grey(0, 1))[1].tobytes()
    messages = [
        ("/left/image_raw/compressed", START_NS, compressed(START_NS, png(grey(0, 0)), "mono8; png compressed mono8")),
        ("/left/image_raw/compressed", START_NS + 1, compressed(START_NS + STEP_NS, jpeg, "jpeg")),
        ("/left/image_raw/compressed", START_NS + 2, compressed(START_NS + 2 * STEP_NS, jpeg[:200], "jpeg")),
        ("/left/image_raw/compressed", START_NS + 3, compressed(START_NS + 3 * STEP_NS, b"text", "jpeg")),
    ]
    sequence = opened(write_bag(tmp_path / "bag", messages), small(make_sequence, 1), "camchain.yaml")
    found = pixels_of(sequence)
    np.testing.assert_array_equal(found[0], grey(0, 0))
    np.testing.assert_array_equal(found[1], cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_GRAYSCALE))
    assert found[2:] == [None, None]
    assert sum("the frame goes on without it" in notice for notice in sequence.notices) == 2


def test_stamps_that_are_not_there_or_there_twice(make_sequence: MakeSequence, tmp_path: Path) -> None:
    unstamped = stored(make_sequence, tmp_path / "unstamped", [image(0, grey(0, number)) for number in range(3)])
    assert unstamped.timestamps_ns == tuple(START_NS + 10**9 * number for number in range(3))
    assert "/left/image_raw: the messages have no stamps, the times when they were logged are taken" in (
        unstamped.notices
    )
    shutil.rmtree(unstamped.path.parent / "sequence")
    twice = stored(make_sequence, tmp_path / "twice", [image(START_NS + n // 2, grey(0, n)) for n in range(3)])
    for found, number in zip(pixels_of(twice), (0, 2), strict=True):
        np.testing.assert_array_equal(found, grey(0, number))
    assert any("two messages have the stamp" in notice for notice in twice.notices)


@pytest.mark.parametrize(
    ("names", "chosen"),
    [
        (["/left/image_raw", "/right/image_raw"], ("/left/image_raw", "/right/image_raw")),
        (["/cam1/image", "/cam0/image"], ("/cam0/image", "/cam1/image")),
        (["/c/infra2/image_rect_raw", "/c/infra1/image_rect_raw", "/c/color/image_raw", "/c/depth/image_rect_raw"],
         ("/c/infra1/image_rect_raw", "/c/infra2/image_rect_raw")),
        (["/l_left/image_rect", "/l_right/image_rect", "/l_left/image_raw", "/l_right/image_raw"],
         ("/l_left/image_raw", "/l_right/image_raw")),
        (["/left/image_raw", "/right/image_raw", "/left/image_raw/compressed", "/right/image_raw/compressed",
          "/left/image_raw/compressedDepth", "/right/image_raw/compressedDepth"],
         ("/left/image_raw", "/right/image_raw")),
        (["/camera/image_raw", "/camera/image_rect"], ("/camera/image_raw", None)),
        (["/right/image_raw"], (None, "/right/image_raw")),
        (["/left/image_raw", "/right/image_raw", "/rear/left/image_raw", "/rear/right/image_raw"], "name the left"),
        (["/front/image_raw", "/rear/image_raw"], "image topics are /front/image_raw, /rear/image_raw; name the left"),
        ([], "the bag has no image topics"),
    ],
)  # fmt: skip
def test_topics_are_found(names: list[str], chosen: tuple[str | None, str | None] | str) -> None:
    topics = {name: COMPRESSED_IMAGE if "compressed" in name else IMAGE for name in names}
    topics["/imu"] = "sensor_msgs/msg/Imu"
    if isinstance(chosen, str):
        with pytest.raises(ValueError, match=chosen):
            choose_topics(topics, None)
    else:
        assert choose_topics(topics, None) == chosen


def test_topics_by_name(make_sequence: MakeSequence, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sequence = small(make_sequence)
    messages = [
        (topic.replace("left", "port").replace("right", "star"), logged, message)
        for topic, logged, message in recorded(sequence, 2)
    ]
    bag = write_bag(tmp_path / "bag", messages)
    names = ("/stereo/port/image_raw", "/stereo/star/image_raw")
    assert f"image topics are {', '.join(names)}; name the left" in fault_of(bag, sequence)
    assert list(opened(bag, sequence, "camchain.yaml", topics=names)) == list(sequence)
    assert [frame.right for frame in opened(bag, sequence, topics=names[:1])] == [None, None]
    assert "/imu is no image topic" in fault_of(bag, sequence, topics=["/imu", names[0]])
    assert "of one camera or of two" in fault_of(bag, sequence, topics=[names[0]] * 2)
    out = str(tmp_path / "out")
    assert execute(["run", str(bag), "--topics", ",".join(names), "--out", out]) == 1
    assert execute(["run", str(bag), "--out", out]) == 2
    assert execute(["info", str(bag), "--topics", ",".join(names)]) == 0
    capsys.readouterr()
    assert execute(["run", str(sequence.path), "--topics", ",".join(names), "--out", out]) == 2
    assert "there are no topics in it" in capsys.readouterr().err
    assert execute(["run", str(bag), "--rate", "8", "--out", out]) == 2
    assert "has times of its own" in capsys.readouterr().err


@pytest.mark.parametrize("storage", ["sqlite3", "mcap"])
def test_malformed_bags_are_refused_in_one_line(make_sequence: MakeSequence, tmp_path: Path, storage: str) -> None:
    sequence = small(make_sequence)
    bag = write_bag(tmp_path / "bag", recorded(sequence, 2), storage)
    beside(bag, "camchain.yaml", of=sequence.path)
    file = next(bag.glob("bag.*"))
    good, told = file.read_bytes(), (bag / "metadata.yaml").read_text()
    for data in (b"", b"\0" * 300, good[:100], good[: len(good) // 2], good[len(good) // 2 :]):
        file.write_bytes(data)
        assert "cannot be read as a ROS 2 bag: " in fault_of(bag, sequence)
    file.unlink()
    assert "missing" in fault_of(bag, sequence)
    file.mkdir()
    assert "cannot be read: Is a directory" in fault_of(bag, sequence)
    file.rmdir()
    file.write_bytes(good)
    for text in ("", "rosbag2_bagfile_information: 1", told.replace("version: 9", "version: 99"), "a: [", "\0"):
        (bag / "metadata.yaml").write_text(text)
        assert "cannot be read as a ROS 2 bag: " in fault_of(bag, sequence)
    (bag / "metadata.yaml").write_text(told)
    assert len(open_sequence(bag)) == 2


def test_damage_at_random_is_told_or_does_no_harm(make_sequence: MakeSequence, tmp_path: Path) -> None:
    sequence = small(make_sequence)
    rng = np.random.default_rng(11)
    refused = []
    for storage in ("sqlite3", "mcap"):
        bag = write_bag(tmp_path / storage, recorded(sequence, 2, infos=True), storage)
        beside(bag, "target.yaml", of=sequence.path)
        file = next(bag.glob(f"{storage}.*"))
        good = np.frombuffer(file.read_bytes(), np.uint8)
        for _ in range(8):
            spoiled = good.copy()
            spoiled[rng.integers(0, len(good), 40)] = rng.integers(0, 256, 40)
            file.write_bytes(spoiled.tobytes())
            try:
                list(open_sequence(bag))
            except InputError as error:
                refused.append(str(error))
    assert refused
    assert all(message.isprintable() for message in refused)


def test_a_reader_that_dies_costs_its_frames(make_sequence: MakeSequence, tmp_path: Path) -> None:
    sequence = small(make_sequence, 3)
    bag = opened(write_bag(tmp_path / "bag", recorded(sequence, 3)), sequence, "camchain.yaml")
    assert bag[0].left is not None
    entry = bag._moments[0].left
    assert entry is not None
    entry.container._bag._reader._process.kill()  # type: ignore[union-attr]
    assert bag[1].left is None
    assert bag[2].right is None
    assert any("cannot be read: the reader has crashed" in notice for notice in bag.notices)


def test_a_bag_of_ros_1_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.bag").write_bytes(b"#ROSBAG V2.0\n")
    with pytest.raises(InputError, match=r"a\.bag: a bag of ROS 1 is not read"):
        open_sequence(tmp_path / "a.bag")
    with pytest.raises(InputError, match=r"a\.mcap: no such file"):
        open_sequence(tmp_path / "a.mcap")
