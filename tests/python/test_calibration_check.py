"""The check of a flown rig, on the example with one camera turned a little."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest
from rvdnav.calibration.check import RigCheck, check_rig
from rvdnav.cli.app import execute
from rvdnav.errors import CoreError, InputError
from rvdnav.pose import exp, inverse_T, make_T
from rvdnav.rig import Rig, save_rig, world_from_camchain
from rvdnav.sequence import Sequence, open_sequence

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "approach"


@pytest.fixture(autouse=True)
def few_frames(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rvdnav.calibration.check.MAX_FRAMES", 5)


def turned(rig: Rig, camera: int, turn_deg: tuple[float, float, float]) -> Rig:
    """The rig that is believed in after one camera has turned about its own axes."""
    T = inverse_T(rig.T_world_cam[1]) @ rig.T_world_cam[0]
    turn = make_T(exp(np.radians(turn_deg)), np.zeros(3))
    return Rig(rig.cameras, world_from_camchain(T @ turn if camera == 0 else turn @ T))


def check(rig: Rig | None = None) -> RigCheck:
    sequence: Sequence = open_sequence(EXAMPLE)
    sequence.rig = rig or sequence.rig
    return check_rig(sequence)


def test_a_true_rig_passes() -> None:
    result = check()
    assert not result.due
    assert result.frames == result.looked_at
    assert abs(np.median(result.epipolar_px)) < 0.05
    assert abs(np.median(result.length_errors)) < 1e-3


@pytest.mark.parametrize(
    ("camera", "turn_deg"),
    [(0, (0.05, 0.0, 0.0)), (1, (0.0, 0.05, 0.0)), (0, (0.0, -0.1, 0.0)), (1, (0.0, 0.0, 0.1))],
)
def test_a_turned_camera_is_found(camera: int, turn_deg: tuple[float, float, float]) -> None:
    result = check(turned(open_sequence(EXAMPLE).rig, camera, turn_deg))
    assert result.due
    assert np.degrees(result.turn) == pytest.approx(-np.array(turn_deg), abs=0.03)


def test_an_uncertain_calibration_is_given_the_benefit_of_the_doubt() -> None:
    rig = turned(open_sequence(EXAMPLE).rig, 1, (0.05, 0.0, 0.0))
    assert not check(attrs.evolve(rig, calibration_covariance=np.eye(22) * np.radians(0.05) ** 2)).due


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rvdnav.calibration.check.MAX_FRAMES", 4)
    assert execute(["calibrate", "check", str(EXAMPLE)]) == 0
    text = capsys.readouterr().out
    assert "the rig is true" in text
    assert "4 of 4" in text
    assert "looked at, spread over all 24" in text
    copy = tmp_path / "flown"
    shutil.copytree(EXAMPLE, copy)
    save_rig(turned(open_sequence(EXAMPLE).rig, 1, (0.08, 0.0, 0.0)), copy)
    assert execute(["calibrate", "check", str(copy)]) == 1
    assert "re-calibration is due: the cameras have turned by 0.0" in capsys.readouterr().out


def test_frames_that_cannot_be_measured_are_told_with_the_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rvdnav.calibration.check.MAX_FRAMES", 6)
    copy = tmp_path / "flown"
    shutil.copytree(EXAMPLE, copy)
    images = sorted((copy / "cam1" / "data").glob("*.png"))
    for image in images[4:]:
        image.unlink()
    for image in sorted((copy / "cam0" / "data").glob("*.png"))[6:]:
        image.unlink()
    for listing in copy.glob("cam?/data.csv"):
        listing.unlink()
    black = np.zeros((576, 704), np.uint8)
    cv2.imwrite(str(images[1]), black)
    assert execute(["calibrate", "check", str(copy)]) == 0
    text = capsys.readouterr().out
    assert "3 of 6" in text
    assert "Why 3 of 6 frames were not measured" in text
    rows = dict(re.findall(r"(RIGHT_[A-Z]+) +│ +(\d+)", text))
    assert rows == {"RIGHT_MISSING": "2", "RIGHT_UNUSABLE": "1"}
    cv2.imwrite(str(images[2]), black)
    assert execute(["calibrate", "check", str(copy)]) == 2
    assert capsys.readouterr().err == (
        f"rvdnav: {copy}: both cameras show the bracket in 2 of 6 frames, where 3 are needed "
        "(RIGHT_MISSING 2, RIGHT_UNUSABLE 2)\n"
    )


@pytest.mark.parametrize("error", [CoreError(-5, "no use"), ValueError("no use"), np.linalg.LinAlgError("no use")])
def test_whatever_fails_is_one_line(
    error: Exception, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr("rvdnav.cli.check.check_rig", fail)
    assert execute(["calibrate", "check", str(EXAMPLE)]) == 2
    assert capsys.readouterr().err == f"rvdnav: {EXAMPLE}: its rig cannot be checked: no use\n"


def test_what_cannot_be_checked(make_sequence: Callable[..., Path], tmp_path: Path) -> None:
    with pytest.raises(InputError, match="both cameras show the bracket in 0 of 3 frames, where 3 are needed"):
        check_rig(open_sequence(make_sequence()))
    one = tmp_path / "one"
    shutil.copytree(EXAMPLE, one, ignore=shutil.ignore_patterns("cam1", "rig.yaml"))
    chain = (one / "camchain.yaml").read_text()
    (one / "camchain.yaml").write_text(chain[: chain.index("cam1:")])
    with pytest.raises(InputError, match="has one camera"):
        check_rig(open_sequence(one))
