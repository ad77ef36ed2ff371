"""Videos as the images of a camera, whole, damaged and hostile."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from conftest import CAMCHAIN, TARGET
from rvdnav import open_sequence
from rvdnav.errors import InputError
from rvdnav.images import ImageError
from rvdnav.video import open_video

pytest.importorskip("av")

WIDTH, HEIGHT, FRAMES, RATE = 70, 58, 12, 25


def write_video(path: Path, codec: str, seed: int = 0) -> None:
    """Smooth noise that moves: neighbouring frames differ, so that none can be taken for another."""
    rng = np.random.default_rng(seed)
    noise = rng.uniform(0, 255, (HEIGHT + FRAMES, WIDTH + FRAMES)).astype(np.uint8)
    field = cv2.cvtColor(cv2.GaussianBlur(noise, (0, 0), 2.0), cv2.COLOR_GRAY2BGR)
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*codec), RATE, (WIDTH, HEIGHT))
    assert writer.isOpened()
    for number in range(FRAMES):
        writer.write(field[number : number + HEIGHT, number : number + WIDTH])
    writer.release()


def decoded_by_opencv(path: Path) -> list[np.ndarray]:
    capture = cv2.VideoCapture(str(path))
    frames = []
    while (answer := capture.read())[0]:
        frames.append(cv2.cvtColor(answer[1], cv2.COLOR_BGR2GRAY))
    return frames


@pytest.mark.parametrize(("name", "codec"), [("cam0.mp4", "mp4v"), ("cam0.avi", "MJPG"), ("cam0.mkv", "mp4v")])
def test_frames_are_those_that_opencv_decodes_at_the_rate_of_the_file(tmp_path: Path, name: str, codec: str) -> None:
    write_video(tmp_path / name, codec)
    video = open_video(tmp_path / name)
    assert (video.width, video.height) == (WIDTH, HEIGHT)
    np.testing.assert_allclose(np.diff(video.stamps_ns), 1e9 / RATE, atol=0.6e6)  # of mkv in whole ms
    expected = decoded_by_opencv(tmp_path / name)
    assert len(video.stamps_ns) == len(expected) == FRAMES
    for number in (*range(FRAMES), 3, 3, 9, 0):
        difference = video.frame(video.stamps_ns[number]).astype(int) - expected[number]
        # OpenCV goes through colours, which shifts levels by one or two; neighbouring frames differ by more.
        assert np.abs(difference).mean() < 2.0, number


def test_a_sequence_of_two_videos_is_paired_and_read_in_any_order(tmp_path: Path) -> None:
    (tmp_path / "camchain.yaml").write_text(CAMCHAIN)
    (tmp_path / "target.yaml").write_text(TARGET)
    for seed, name in enumerate(("cam0.mp4", "cam1.mp4")):
        write_video(tmp_path / name, "mp4v", seed)
    sequence = open_sequence(tmp_path)
    expected = [decoded_by_opencv(tmp_path / name) for name in ("cam0.mp4", "cam1.mp4")]
    assert len(sequence) == FRAMES
    for number in (0, 5, 2, FRAMES - 1):
        frame = sequence[number]
        assert frame.timestamp_ns == round(number * 1e9 / RATE)
        for image, frames in zip((frame.left, frame.right), expected, strict=True):
            assert image is not None
            assert np.abs(image.pixels.astype(int) - frames[number]).mean() < 2.0
    assert sequence.notices == []
    (tmp_path / "cam0").mkdir()
    with pytest.raises(InputError, match=r"cam0\.mp4: there is cam0 too"):
        open_sequence(tmp_path)


def test_a_decoder_that_dies_costs_its_frames(tmp_path: Path) -> None:
    (tmp_path / "camchain.yaml").write_text(CAMCHAIN)
    (tmp_path / "target.yaml").write_text(TARGET)
    write_video(tmp_path / "cam0.mp4", "mp4v")
    sequence = open_sequence(tmp_path)
    assert sequence[0].left is not None
    moment = sequence._moments[0].left
    assert moment is not None
    assert moment.container is not None
    moment.container._decoder._process.kill()
    assert sequence[1].left is None
    assert sequence[2].left is None
    assert any("cam0.mp4 at 0.040 s cannot be decoded" in notice for notice in sequence.notices)


def test_damaged_videos_give_frames_or_one_line(tmp_path: Path) -> None:
    whole = tmp_path / "whole.mp4"
    write_video(whole, "mp4v")
    data = whole.read_bytes()
    rng = np.random.default_rng(1)
    cases = [b"", b"\0" * 100, data[: len(data) // 2], data[len(data) // 2 :], b"#EXTM3U\nfile:///etc/passwd\n"]
    for _ in range(6):
        spoiled = np.frombuffer(data, np.uint8).copy()
        spoiled[rng.integers(0, len(data), 30)] = rng.integers(0, 256, 30)
        cases.append(spoiled.tobytes())
    damaged = tmp_path / "damaged.mp4"
    refused, missing = [], []
    for case in cases:
        damaged.write_bytes(case)
        try:
            video = open_video(damaged)
        except InputError as error:
            refused.append(str(error))
            continue
        for stamp in video.stamps_ns:
            try:
                assert video.frame(stamp).shape == (video.height, video.width)
            except ImageError as error:
                missing.append(str(error))
    assert len(refused) >= 5
    assert all(message.startswith(f"{damaged}: ") and "\n" not in message for message in refused)
    assert all(message.startswith("cannot be decoded") for message in missing)


def test_a_folder_named_like_a_video_and_a_missing_one(tmp_path: Path) -> None:
    (tmp_path / "cam0.mp4").mkdir()
    with pytest.raises(InputError, match=r"cam0\.mp4: cannot be read"):
        open_video(tmp_path / "cam0.mp4")
    with pytest.raises(InputError, match="no such file"):
        open_video(tmp_path / "cam1.mp4")
