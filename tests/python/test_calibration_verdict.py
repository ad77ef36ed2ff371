"""What a calibration is worth: its covariance in poses, the next picture, the report."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
import pytest
from board_scene import BOARD, RIG, T_cam0_boards, exact_corners
from rvdnav.calibration import Calibration
from rvdnav.calibration.adjustment import StereoModel, adjust
from rvdnav.calibration.next_view import next_views
from rvdnav.calibration.page import verdict, verdict_sentence, write_calibration
from rvdnav.calibration.verdict import BRACKET, RANGES_M, pose_sensitivities
from rvdnav.calibration.views import Dropped, View
from rvdnav.pose import inverse_T, triangulate
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import make_T

T_CAM1_CAM0 = inverse_T(RIG.T_world_cam[1]) @ RIG.T_world_cam[0]


def calibration_of(T_cam0_board: FloatArray) -> Calibration:
    noise = np.random.default_rng(5).normal(0.0, 0.1, (len(T_cam0_board), 2, len(BOARD.points), 2))
    uv = exact_corners(T_cam0_board) + noise
    adjustment = adjust(StereoModel(RIG.cameras, T_CAM1_CAM0, T_cam0_board), BOARD.points, uv)
    blank = np.zeros((RIG.height, RIG.width), np.uint8)
    views = tuple(View(str(i), (blank, blank), ()) for i in range(len(uv)))
    rig = attrs.evolve(RIG, calibration_covariance=adjustment.covariance)
    return Calibration(BOARD, rig, adjustment, views, uv, (Dropped("x<y>", "was & is bad"),), 0.001, 0.0001)


@pytest.fixture(scope="module")
def central() -> Calibration:
    """Few views, all of them in the middle of the field."""
    boards = T_cam0_boards(40, seed=9)
    middle = boards[:, :3, :3] @ BOARD.points.mean(axis=0) + boards[:, :3, 3]
    aside = np.abs(middle[:, :2] / middle[:, 2:] - (0.1, 0.0)).max(axis=1)
    return calibration_of(boards[np.argsort(aside)[:8]])


def test_the_sensitivity_is_that_of_triangulated_corners() -> None:
    """A shift of one camera's calibration moves the bracket as it moves its corners, measured where they were."""
    sensitivity = next(s for s in pose_sensitivities(RIG) if s.range_m == 0.5)
    T = make_T(np.eye(3), np.array([0.5, 0.0, 0.5 * RIG.baseline - 0.07]))
    points = BRACKET.outer @ T[:3, :3].T + T[:3, 3]
    raw = [RIG.project(camera, points) for camera in range(2)]
    delta = np.zeros(22)
    delta[[2, 10]] = 0.5  # both principal points: the world turns with them
    moved = RIG.perturbed(delta)
    seen = [moved.raw_to_rect(camera, uv) for camera, uv in enumerate(raw)]
    shift = triangulate(moved.projection_matrix(0), moved.projection_matrix(1), *seen) - points
    assert np.allclose(sensitivity.derivative[:3] @ delta, shift.mean(axis=0), atol=0.1 * np.abs(shift).max())


def test_errors_grow_with_the_range_and_scale_with_the_covariance(central: Calibration) -> None:
    sensitivities = pose_sensitivities(central.rig)
    assert tuple(s.range_m for s in sensitivities) == RANGES_M[1:] or len(sensitivities) == len(RANGES_M)
    covariance = central.adjustment.covariance
    positions = [s.sigmas(covariance)[0] for s in sensitivities]
    assert positions == sorted(positions)
    assert sensitivities[0].sigmas(4.0 * covariance)[0] == pytest.approx(2.0 * positions[0])
    assert all(s.range_sigma(covariance) < s.sigmas(covariance)[0] for s in sensitivities)


def test_the_suggested_picture_helps_as_promised_and_more_than_others(central: Calibration) -> None:
    sensitivities = pose_sensitivities(central.rig)
    suggested = next_views(central.adjustment, BOARD, sensitivities, 2)
    before = sensitivities[-1].sigmas(central.adjustment.covariance)[0]
    after = [sensitivities[-1].sigmas(view.covariance)[0] for view in suggested]
    assert before > after[0] > after[1]
    boards = central.adjustment.model.T_cam0_board

    def with_view(T: FloatArray) -> float:
        return sensitivities[-1].sigmas(calibration_of(np.concatenate([boards, T[None]])).adjustment.covariance)[0]

    # Another draw of the corners' noise: the promise holds but for the scatter that is estimated from them.
    best = with_view(suggested[0].T_cam0_board)
    assert best == pytest.approx(after[0], rel=0.25)
    assert best < min(with_view(T) for T in boards[:4])


def test_the_report(central: Calibration, tmp_path: Path) -> None:
    judged = verdict(central)
    write_calibration(tmp_path / "calibration.html", "a <folder>", central, judged)
    page = (tmp_path / "calibration.html").read_text(encoding="utf-8")
    assert "a &lt;folder&gt;" in page
    assert "x&lt;y&gt;" in page
    assert "was &amp; is bad" in page
    for name in ("residuals", "views", "coverage", "tilt", "rig"):
        assert f'id="figure-{name}"' in page
    for view in judged.suggested:
        assert view.description in page
    position = judged.sensitivities[-1].sigmas(central.adjustment.covariance)[0]
    assert f"{position * 1e3:.2f} mm" in verdict_sentence(central, judged)
    assert verdict_sentence(central, judged)[:80] in page
