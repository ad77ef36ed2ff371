from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import settings

# The same examples in every run, and no judgement by the clock.
settings.register_profile("rvdnav", derandomize=True, deadline=None)
settings.load_profile("rvdnav")

START_NS = 1_700_000_000_000_000_000
STEP_NS = 125_000_000

CAMCHAIN = """\
cam0:
  camera_model: pinhole
  intrinsics: [66.8, 66.9, 35.7, 28.3]
  distortion_model: radtan
  distortion_coeffs: [-0.2, 0.06, 0.0005, -0.0004]
  resolution: [70, 58]
cam1:
  camera_model: pinhole
  intrinsics: [67.2, 67.3, 34.7, 29.2]
  distortion_model: radtan
  distortion_coeffs: [-0.19, 0.05, -0.0004, 0.0005]
  resolution: [70, 58]
  T_cn_cnm1:
  - [1.0, 0.0, 0.0, -0.12]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
"""

TARGET = """\
name: test-bracket
units: mm
long_base: 180.0
short_base: 90.0
height: 140.0
bar_width: 14.0
bar_thickness: 6.0
points:
  P1: [0.0, -90.0, 0.0]
  P2: [0.0, 90.0, 0.0]
  P3: [0.0, 45.0, 140.0]
  P4: [0.0, -45.0, 140.0]
  Q1: [0.0, -70.794559, 14.0]
  Q2: [0.0, 70.794559, 14.0]
  Q3: [0.0, 34.794559, 126.0]
  Q4: [0.0, -34.794559, 126.0]
lines:
  l1: [P1, P2]
  l2: [P3, P4]
  l3: [P2, P3]
  l4: [P4, P1]
bars:
- {name: long_base, outer: [P1, P2], inner: [Q1, Q2]}
- {name: leg_lower, outer: [P2, P3], inner: [Q2, Q3]}
- {name: short_base, outer: [P3, P4], inner: [Q3, Q4]}
- {name: leg_upper, outer: [P4, P1], inner: [Q4, Q1]}
"""


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The rendered sequences and calibration images kept beside the repository; the test is skipped without them."""
    path = Path(__file__).resolve().parents[3] / "shared" / "data"
    if not path.is_dir():
        pytest.skip("the shared data are not there")
    return path


def png(image: np.ndarray) -> bytes:
    """An image as the bytes of a PNG file."""
    done, encoded = cv2.imencode(".png", image)
    assert done
    return encoded.tobytes()


def grey(camera: int, frame: int) -> np.ndarray:
    """A small image that tells its camera and frame: its mean is 100 + 50 camera + 10 frame, its left half darker."""
    image = np.full((58, 70), 120 + 50 * camera + 10 * frame, np.uint8)
    image[:, :35] -= 40
    return image


def write_camera(folder: Path, images: dict[int, bytes], *, listed: bool = True) -> None:
    """One camera's folder: images by timestamp, ns, and their data.csv."""
    (folder / "data").mkdir(parents=True)
    for timestamp_ns, data in images.items():
        (folder / "data" / f"{timestamp_ns}.png").write_bytes(data)
    if listed:
        rows = [f"{timestamp_ns},{timestamp_ns}.png" for timestamp_ns in images]
        (folder / "data.csv").write_text("\n".join(["#timestamp [ns],filename", *rows, ""]))


@pytest.fixture
def make_sequence(tmp_path: Path) -> Callable[..., Path]:
    """Maker of a tiny stereo sequence (70 x 58 px, no truth): make_sequence(frames=3) gives its folder."""

    def make(frames: int = 3) -> Path:
        folder = tmp_path / "sequence"
        folder.mkdir()
        (folder / "camchain.yaml").write_text(CAMCHAIN)
        (folder / "target.yaml").write_text(TARGET)
        for camera in range(2):
            images = {START_NS + STEP_NS * frame: png(grey(camera, frame)) for frame in range(frames)}
            write_camera(folder / f"cam{camera}", images)
        return folder

    return make
