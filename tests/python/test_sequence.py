from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from conftest import CAMCHAIN, START_NS, STEP_NS, grey, png, write_camera
from rvdnav.errors import InputError
from rvdnav.images import Image
from rvdnav.sequence import open_sequence

MakeSequence = Callable[..., Path]


def image_path(folder: Path, camera: int, frame: int) -> Path:
    return folder / f"cam{camera}" / "data" / f"{START_NS + STEP_NS * frame}.png"


def rename_stamp(folder: Path, camera: int, frame: int, timestamp_ns: int) -> None:
    """Give an image another timestamp, in its name and in data.csv."""
    old = image_path(folder, camera, frame)
    old.rename(old.with_name(f"{timestamp_ns}.png"))
    index = folder / f"cam{camera}" / "data.csv"
    index.write_text(index.read_text().replace(old.stem, str(timestamp_ns)))


def test_frames_in_time_order(make_sequence: MakeSequence) -> None:
    folder = make_sequence(3)
    index = folder / "cam1" / "data.csv"
    head, *rows = index.read_text().splitlines()
    index.write_text("\r\n".join([head, *reversed(rows), ""]))
    sequence = open_sequence(folder)
    assert len(sequence) == 3
    assert sequence.path == folder
    assert sequence.rig.is_stereo
    assert sequence.target.name == "test-bracket"
    assert sequence.truth is None
    frames = list(sequence)
    assert [frame.timestamp_ns for frame in frames] == [START_NS + STEP_NS * i for i in range(3)]
    for i, frame in enumerate(frames):
        for camera, image in enumerate((frame.left, frame.right)):
            assert image is not None
            assert image.timestamp_ns == frame.timestamp_ns
            assert image.pixels.dtype == np.uint8
            assert image.pixels.flags.c_contiguous
            np.testing.assert_array_equal(image.pixels, grey(camera, i))
    assert sequence.notices == []


def test_shared_sequence(shared_data: Path) -> None:
    sequence = open_sequence(shared_data / "sequences" / "sunlit")
    assert len(sequence) == 24
    assert sequence.truth is not None
    assert all(sequence.truth.at(moment.timestamp_ns) is not None for moment in [sequence[0], sequence[23]])
    path = next((sequence.path / "cam1" / "data").glob("*.png"))
    frame = next(frame for frame in sequence if str(frame.timestamp_ns) == path.stem)
    assert frame.right is not None
    np.testing.assert_array_equal(frame.right.pixels, cv2.imread(str(path), cv2.IMREAD_GRAYSCALE))
    assert sequence.notices == []


def test_file_names_serve_without_an_index(make_sequence: MakeSequence) -> None:
    folder = make_sequence(3)
    for camera in ("cam0", "cam1"):
        (folder / camera / "data.csv").unlink()
    (folder / "cam0" / "data" / "preview.png").write_bytes(png(grey(0, 0)))
    assert [frame.timestamp_ns for frame in open_sequence(folder)] == [START_NS + STEP_NS * i for i in range(3)]


def test_near_stamps_pair_and_each_image_keeps_its_own(make_sequence: MakeSequence) -> None:
    folder = make_sequence(2)
    rename_stamp(folder, 1, 1, START_NS + STEP_NS - 900_000)
    sequence = open_sequence(folder)
    frame = list(sequence)[1]
    assert frame.timestamp_ns == START_NS + STEP_NS
    assert frame.right is not None
    assert frame.right.timestamp_ns == START_NS + STEP_NS - 900_000
    assert sequence.notices == []
    apart = open_sequence(folder, pairing_tolerance_ns=800_000)
    assert [(frame.left is None, frame.right is None) for frame in apart] == [
        (False, False),
        (True, False),
        (False, True),
    ]
    assert len(apart.notices) == 2
    assert all("has no partner within 0.8 ms" in notice for notice in apart.notices)


def test_the_nearer_image_gets_the_partner(make_sequence: MakeSequence) -> None:
    folder = make_sequence(2)
    rename_stamp(folder, 0, 0, START_NS + STEP_NS - 700_000)
    rename_stamp(folder, 1, 0, START_NS)
    frames = list(open_sequence(folder))
    assert [frame.timestamp_ns - START_NS for frame in frames] == [0, STEP_NS - 700_000, STEP_NS]
    assert frames[0].left is None
    assert frames[1].right is None
    assert frames[2].left is not None
    assert frames[2].right is not None


def test_unpaired_image_is_a_one_camera_frame_and_said(make_sequence: MakeSequence) -> None:
    folder = make_sequence(3)
    image_path(folder, 0, 1).unlink()
    index = folder / "cam0" / "data.csv"
    index.write_text("".join(line for line in index.open() if str(START_NS + STEP_NS) not in line))
    sequence = open_sequence(folder)
    frame = list(sequence)[1]
    assert frame.timestamp_ns == START_NS + STEP_NS
    assert frame.left is None
    assert frame.right is not None
    (notice,) = sequence.notices
    assert notice.startswith(f"cam1/data/{START_NS + STEP_NS}.png has no partner")


@pytest.mark.parametrize(
    ("damage", "word"),
    [
        (lambda data: data[: len(data) // 2], "is truncated"),
        (lambda data: data[:-12], "is truncated"),  # all pixels there, the end mark gone
        (lambda data: data[:20], "is not a PNG image"),
        (lambda data: b"", "is not a PNG image"),
        (lambda data: data[:60] + bytes([data[60] ^ 1]) + data[61:], "is corrupt"),
        (None, "cannot be read (No such file or directory)"),
    ],
)
def test_damaged_image_is_said_once_and_the_frame_goes_on(
    make_sequence: MakeSequence, damage: Callable[[bytes], bytes] | None, word: str
) -> None:
    folder = make_sequence(3)
    path = image_path(folder, 1, 1)
    if damage is None:
        path.unlink()
    else:
        path.write_bytes(damage(path.read_bytes()))
    sequence = open_sequence(folder)
    for _ in range(2):
        frames = list(sequence)
    assert [frame.right is None for frame in frames] == [False, True, False]
    assert all(frame.left is not None for frame in frames)
    assert sequence.notices == [f"cam1/data/{path.name} {word}: the frame goes on without it"]


def test_colour_is_converted_and_said_once(make_sequence: MakeSequence) -> None:
    folder = make_sequence(2)
    colour = np.zeros((58, 70, 3), np.uint8)
    colour[...] = (20, 120, 220)
    alpha = np.dstack([colour, np.full((58, 70), 255, np.uint8)])
    image_path(folder, 0, 0).write_bytes(png(colour))
    image_path(folder, 0, 1).write_bytes(png(alpha))
    sequence = open_sequence(folder)
    luma = 0.114 * 20 + 0.587 * 120 + 0.299 * 220  # ITU-R BT.601, blue first
    for frame in sequence:
        assert frame.left is not None
        assert frame.left.pixels.shape == (58, 70)
        np.testing.assert_allclose(frame.left.pixels, luma, atol=1)
    assert sequence.notices == [
        f"colour images are converted to 8-bit grey, cam0/data/{START_NS}.png the first of them"
    ]


def test_sixteen_bits_are_scaled(make_sequence: MakeSequence) -> None:
    folder = make_sequence(1)
    deep = np.linspace(0, 65535, 58 * 70).astype(np.uint16).reshape(58, 70)
    image_path(folder, 0, 0).write_bytes(png(deep))
    image_path(folder, 1, 0).write_bytes(png(np.dstack([deep] * 3)))
    sequence = open_sequence(folder)
    frame = sequence[0]
    assert frame.left is not None
    assert frame.right is not None
    np.testing.assert_array_equal(frame.left.pixels, np.rint(deep / 65535 * 255))
    np.testing.assert_allclose(frame.right.pixels, deep / 65535 * 255, atol=1)
    assert [notice.split(" images")[0] for notice in sequence.notices] == ["16-bit", "colour 16-bit"]


def test_one_camera_sequences(make_sequence: MakeSequence, tmp_path: Path) -> None:
    folder = make_sequence(2)
    (folder / "cam1").rename(tmp_path / "elsewhere")
    sequence = open_sequence(folder)
    assert all(frame.left is not None and frame.right is None for frame in sequence)
    assert sequence.notices == ["there is no cam1: every frame has one image"]
    (folder / "camchain.yaml").write_text(CAMCHAIN[: CAMCHAIN.index("cam1:")])
    alone = open_sequence(folder)
    assert not alone.rig.is_stereo
    assert alone.notices == []


def fault_of(folder: Path) -> str:
    with pytest.raises(InputError) as caught:
        open_sequence(folder)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_wrong_image_size_is_found_before_the_first_frame(make_sequence: MakeSequence) -> None:
    folder = make_sequence(3)
    path = image_path(folder, 1, 2)
    path.write_bytes(png(np.zeros((60, 70), np.uint8)))
    assert fault_of(folder) == f"{path}: is 70x60 but the calibration is for 70x58"


def test_missing_and_empty_folders(make_sequence: MakeSequence, tmp_path: Path) -> None:
    assert fault_of(tmp_path / "nowhere") == f"{tmp_path / 'nowhere'}: no such folder"
    (tmp_path / "empty").mkdir()
    assert "not a sequence" in fault_of(tmp_path / "empty")
    (tmp_path / "file").touch()
    assert fault_of(tmp_path / "file").endswith("not a folder")
    folder = make_sequence(1)
    for name in ("target.yaml", "camchain.yaml"):
        kept = (folder / name).rename(tmp_path / name)
        assert fault_of(folder) == f"{folder / name}: no such file"
        kept.rename(folder / name)


def test_no_images(make_sequence: MakeSequence) -> None:
    folder = make_sequence(1)
    image_path(folder, 0, 0).unlink()
    image_path(folder, 1, 0).write_bytes(b"text")
    assert "none of the images can be read" in fault_of(folder)
    for camera in ("cam0", "cam1"):
        (folder / camera / "data.csv").write_text("#timestamp [ns],filename\n")
    assert fault_of(folder).startswith(f"{folder / 'cam0'}: holds no images")


@pytest.mark.parametrize(
    ("row", "fault"),
    [
        ("1700000000.125,a.png", "is not a timestamp in whole nanoseconds"),
        ("-5,a.png", "is not a timestamp in whole nanoseconds"),
        ("9223372036854775808,a.png", "outside the range of int64"),
        ("1700000000125000000", "not a row of timestamp [ns],filename"),
        ("1700000000125000000,", "not a row of timestamp [ns],filename"),
        (f"{START_NS},a.png", "is given twice"),
    ],
)
def test_malformed_index(make_sequence: MakeSequence, row: str, fault: str) -> None:
    folder = make_sequence(1)
    index = folder / "cam0" / "data.csv"
    index.write_text(index.read_text() + row + "\n")
    message = fault_of(folder)
    assert message.startswith(f"{index}: line 3: ")
    assert fault in message


def test_stamp_in_a_file_name_beyond_int64(make_sequence: MakeSequence) -> None:
    folder = make_sequence(0)
    (folder / "cam0" / "data" / f"{10**19}.png").write_bytes(png(grey(0, 0)))
    (folder / "cam0" / "data.csv").unlink()
    assert "outside the range of int64" in fault_of(folder)


def test_images_of_a_camera_without_calibration(make_sequence: MakeSequence) -> None:
    folder = make_sequence(1)
    (folder / "camchain.yaml").write_text(CAMCHAIN[: CAMCHAIN.index("cam1:")])
    assert fault_of(folder) == f"{folder / 'camchain.yaml'}: cam1 is missing, but there are images of it"


def test_malformed_truth(make_sequence: MakeSequence) -> None:
    folder = make_sequence(1)
    (folder / "groundtruth.tum").write_text("1 2 3\n")
    assert fault_of(folder).startswith(f"{folder / 'groundtruth.tum'}: line 1: ")


def test_stamps_are_exact_beyond_what_a_double_holds(tmp_path: Path, make_sequence: MakeSequence) -> None:
    folder = make_sequence(1)
    for camera in range(2):
        (folder / f"cam{camera}").rename(tmp_path / f"old{camera}")
        write_camera(folder / f"cam{camera}", {START_NS + 1: png(grey(camera, 0))})
    assert int(float(START_NS + 1)) != START_NS + 1
    assert open_sequence(folder)[0].timestamp_ns == START_NS + 1


@pytest.mark.parametrize("pixels", [np.zeros((4, 4), np.float32), np.zeros((4, 4, 3), np.uint8)])
def test_image_takes_grey_bytes_alone(pixels: np.ndarray) -> None:
    with pytest.raises(ValueError, match="uint8"):
        Image(pixels, 0)


def test_image_is_made_contiguous() -> None:
    image = Image(np.arange(24, dtype=np.uint8).reshape(4, 6)[:, ::2], 5)
    assert image.pixels.flags.c_contiguous
    np.testing.assert_array_equal(image.pixels[1], [6, 8, 10])


@pytest.mark.parametrize("index", [0, 24, 47])
def test_calibration_target_and_truth_meet_in_the_images(shared_data: Path, index: int) -> None:
    sequence = open_sequence(shared_data / "sequences" / "approach")
    frame = sequence[index]
    assert sequence.truth is not None
    assert sequence.target.bracket is not None
    T = sequence.truth.at(frame.timestamp_ns)
    assert T is not None
    ends_W = sequence.target.bracket.edge_points @ T[:3, :3].T + T[:3, 3]
    along = np.linspace(0.1, 0.9, 40)[:, None]
    points_W = (ends_W[:, :1] + along * (ends_W[:, 1:] - ends_W[:, :1])).reshape(-1, 3)
    for camera, image in enumerate((frame.left, frame.right)):
        assert image is not None
        u, v = sequence.rig.project(camera, points_W).T.astype(np.float32)
        slopes = [cv2.Sobel(image.pixels, cv2.CV_32F, *order) for order in ((1, 0), (0, 1))]
        steepness = np.hypot(*slopes)
        on = cv2.remap(steepness, u, v, cv2.INTER_LINEAR).mean()
        for du, dv in ((2, 0), (-2, 0), (0, 2), (0, -2)):
            assert on > 1.2 * cv2.remap(steepness, u + du, v + dv, cv2.INTER_LINEAR).mean()


def restamped(folder: Path, stamps: list[str]) -> Path:
    """The sequence with its images named so, in time order, and without data.csv."""
    for camera in ("cam0", "cam1"):
        (folder / camera / "data.csv").unlink()
        for old, stamp in zip(sorted((folder / camera / "data").iterdir()), stamps, strict=True):
            old.rename(old.with_name(f"{stamp}.png"))
    return folder


@pytest.mark.parametrize(("name", "ns"), [("microseconds", 10**3), ("milliseconds", 10**6), ("seconds", 10**9)])
def test_unix_time_in_other_units_is_recognised_and_said(make_sequence: MakeSequence, name: str, ns: int) -> None:
    step = max(1, 250_000_000 // ns)
    first = START_NS // ns
    sequence = open_sequence(restamped(make_sequence(3), [str(first + step * i) for i in range(3)]))
    assert sequence.timestamps_ns == tuple(START_NS + step * ns * i for i in range(3))
    assert [frame.left is None or frame.right is None for frame in sequence] == [False] * 3
    assert sequence.notices == [f"cam{camera}: the timestamps are taken for {name} of Unix time" for camera in (0, 1)]


@pytest.mark.parametrize("step", [10**7, 125 * 10**6])
@pytest.mark.parametrize("first", [0, 10**12, 10**15])
def test_nanoseconds_may_begin_anywhere(make_sequence: MakeSequence, first: int, step: int) -> None:
    sequence = open_sequence(restamped(make_sequence(3), [str(first + step * i) for i in range(3)]))
    assert sequence.timestamps_ns == (first, first + step, first + 2 * step)
    assert sequence.notices == []


@pytest.mark.parametrize(
    ("stamps", "gap"), [(["000000", "000001", "000002"], "1 ns"), (["5000", "5250", "5500"], "250 ns")]
)
def test_stamps_that_count_are_refused(make_sequence: MakeSequence, stamps: list[str], gap: str) -> None:
    folder = restamped(make_sequence(3), stamps)
    assert fault_of(folder).startswith(f"{folder / 'cam0'}: by their stamps the images lie {gap} apart; ")


def test_two_names_of_one_stamp_are_refused(make_sequence: MakeSequence) -> None:
    folder = restamped(make_sequence(2), ["7", "007"])
    assert "have the same timestamp" in fault_of(folder)
