"""Calibration from pictures: drawn boards, the rendered set with its true rig, and real photographs."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
import pytest
from board_scene import BOARD, RIG, T_cam0_boards, draw_board, draw_pair, exact_corners
from rvdnav import Navigator, open_sequence
from rvdnav.calibration import Board, Calibration, CalibrationError, ImagePair, calibrate, read_pairs
from rvdnav.calibration.adjustment import adjust
from rvdnav.calibration.stretch import board_stretch
from rvdnav.pose import difference, inverse_T, log, triangulate
from rvdnav.pose.arrays import FloatArray
from rvdnav.rig import Rig, load_rig

BOARDS = T_cam0_boards(8)


@pytest.fixture(scope="module")
def pairs() -> list[ImagePair]:
    return [draw_pair(str(i), T) for i, T in enumerate(BOARDS)]


def T_cam1_cam0(rig: Rig) -> FloatArray:
    return inverse_T(rig.T_world_cam[1]) @ rig.T_world_cam[0]


def parameter_errors(rig: Rig, true: Rig) -> FloatArray:
    """Of the 22 parameters, in the order of the covariance."""
    own = [
        np.subtract((a.fx, a.fy, a.cx, a.cy, *a.distortion), (b.fx, b.fy, b.cx, b.cy, *b.distortion))
        for a, b in zip(rig.cameras, true.cameras, strict=True)
    ]
    T, T_true = T_cam1_cam0(rig), T_cam1_cam0(true)
    return np.concatenate([*own, log(T[:3, :3] @ T_true[:3, :3].T), T[:3, 3] - T_true[:3, 3]])


def reasons(calibration: Calibration | CalibrationError) -> dict[str, str]:
    return {view.name: view.reason for view in calibration.dropped}


def test_a_drawn_board(pairs: list[ImagePair]) -> None:
    calibration = calibrate(pairs, BOARD)
    assert reasons(calibration) == {}
    assert np.sqrt(np.nanmean((calibration.uv - exact_corners(BOARDS)) ** 2)) < 0.02
    assert calibration.rig.calibration_covariance is not None
    sigmas = np.sqrt(np.diag(calibration.rig.calibration_covariance))
    assert (np.abs(parameter_errors(calibration.rig, RIG)) < 3.5 * sigmas).all()
    assert abs(calibration.stretch) < 4.0 * calibration.sigma_stretch < 0.004


def test_a_board_off_by_a_thousandth_is_within_the_stated_sigmas(pairs: list[ImagePair]) -> None:
    for scale in (0.999, 1.001):
        rig = calibrate(pairs, attrs.evolve(BOARD, square=BOARD.square * scale)).rig
        assert rig.calibration_covariance is not None
        t = T_cam1_cam0(rig)[:3, 3]
        sigma = np.sqrt(t @ rig.calibration_covariance[-3:, -3:] @ t) / rig.baseline
        assert rig.baseline == pytest.approx(scale * RIG.baseline, rel=2e-4)
        assert abs(rig.baseline - RIG.baseline) < 3.0 * sigma < 4e-3 * RIG.baseline


def test_views_that_are_no_good_are_dropped_with_the_reason(pairs: list[ImagePair]) -> None:
    T = BOARDS[2]
    left, right = pairs[2].images
    assert not isinstance(left, str)
    assert not isinstance(right, str)
    dark = np.full_like(left, 60)
    shifted = T.copy()
    shifted[:3, 3] += (0.0, 0.001, 0.0)
    half = T.copy()
    half[0, 3] -= (exact_corners(T[None])[0, 0, :, 0].min() + 25.0) / RIG.cameras[0].fx * T[2, 3]
    moved = T.copy()
    moved[:3, 3] += (0.02, 0.015, 0.1)
    later = moved.copy()
    later[:3, 3] += (0.0, 0.01, 0.0)
    far = BOARDS[5].copy()
    far[:3, 3] += (0.01, 0.01, 0.02)
    right_far = T_cam1_cam0(RIG) @ far
    bad = [
        ImagePair("none", (dark, dark)),
        ImagePair("one", (left, dark)),
        ImagePair("lost", (left, "there is no image of the right camera")),
        ImagePair("half", (draw_board(0, half), right)),
        ImagePair("again", draw_pair("", shifted).images),
        ImagePair("soft", (draw_board(0, far, blur=1.6), draw_board(1, right_far))),
        ImagePair("late", (draw_board(0, moved), draw_board(1, T_cam1_cam0(RIG) @ later))),
    ]
    calibration = calibrate([*pairs, *bad], BOARD)
    told = reasons(calibration)
    assert len(calibration.views) == len(pairs)
    assert told.pop("none") == "the board was not found"
    assert told.pop("one") == "in the left image alone; right: the board was not found"
    assert told.pop("lost") == "there is no image of the right camera"
    assert "left: the board is cut off at the left border" in told.pop("half")
    assert told.pop("again") == "nearly the same as 2"
    assert "the left image is blurred" in told.pop("soft")
    assert "does not fit the other views" in told.pop("late")
    assert not told


def test_swapped_cameras_are_noticed(pairs: list[ImagePair]) -> None:
    swapped = [attrs.evolve(pair, images=pair.images[::-1]) for pair in pairs]
    with pytest.raises(CalibrationError, match="cam0 is not the left camera"):
        calibrate(swapped, BOARD)


def shifted(pairs: list[ImagePair], start: int) -> list[ImagePair]:
    """One camera lost a frame: from the start on, each left picture has the right one of the pair after it."""
    rights = [pair.images[1] for pair in pairs[start:]]
    late = [
        attrs.evolve(pair, images=(pair.images[0], right))
        for pair, right in zip(pairs[start:], rights[1:] + rights[:1], strict=True)
    ]
    return pairs[:start] + late


def test_pairs_after_a_lost_frame_are_dropped(pairs: list[ImagePair]) -> None:
    calibration = calibrate(shifted(pairs, 5), BOARD)
    assert [view.name for view in calibration.views] == ["0", "1", "2", "3", "4"]
    assert all("does not fit the other views" in reason for reason in reasons(calibration).values())
    assert calibration.rig.baseline == pytest.approx(RIG.baseline, rel=1e-3)


def test_pairs_of_which_half_do_not_belong_together_are_refused(pairs: list[ImagePair]) -> None:
    for start in (0, 4):
        with pytest.raises(CalibrationError, match=r"do not fit one rig .*; do they belong together\?") as caught:
            calibrate(shifted(pairs, start), BOARD)
        assert "\n" not in str(caught.value)


def test_too_few_views(pairs: list[ImagePair]) -> None:
    blank = np.zeros((288, 352), np.uint8)
    with pytest.raises(CalibrationError, match="2 usable views of the chessboard of 7x5 inner corners") as caught:
        calibrate([*pairs[:2], ImagePair("x", (blank, blank))], BOARD)
    assert reasons(caught.value) == {"x": "the board was not found"}


def test_images_of_another_size(pairs: list[ImagePair]) -> None:
    other = ImagePair("odd", (np.zeros((288, 352), np.uint8), np.zeros((100, 100), np.uint8)))
    with pytest.raises(CalibrationError, match="view odd: the images differ in size: 352x288 and 100x100"):
        calibrate([pairs[0], other], BOARD)


def test_squares_that_are_not_square_are_noticed(pairs: list[ImagePair]) -> None:
    """The board is believed to be 1 % narrower than it was drawn."""
    calibration = calibrate(pairs, BOARD)
    points = BOARD.points / (1.01, 1.0, 1.0)
    adjustment = adjust(calibration.adjustment.model, points, calibration.uv)
    stretch, sigma = board_stretch(adjustment, points, calibration.uv)
    assert stretch == pytest.approx(0.01, abs=4.0 * sigma)
    assert sigma < 0.002


@pytest.mark.parametrize("legacy", [False, True])
def test_a_charuco_board(legacy: bool) -> None:
    stated = Board(5, 3, 0.05, 0.0375, "4X4_50")
    board = attrs.evolve(stated, legacy=legacy)
    poses = T_cam0_boards(7, board)
    calibration = calibrate([draw_pair(str(i), T, board) for i, T in enumerate(poses)], stated)
    assert calibration.board == board
    kept = [int(view.name) for view in calibration.views]
    assert len(kept) >= 5
    assert np.sqrt(np.nanmean((calibration.uv - exact_corners(poses[kept], board)) ** 2)) < 0.03
    assert abs(calibration.rig.baseline - RIG.baseline) < 1e-3


@pytest.fixture(scope="module")
def rendered(shared_data: Path) -> Calibration:
    return calibrate(read_pairs(shared_data / "calibration"), Board(9, 6, 0.025))


def test_the_rendered_set(rendered: Calibration, shared_data: Path) -> None:
    true = load_rig(shared_data / "sequences" / "approach")
    calibration, rig = rendered, rendered.rig
    error = parameter_errors(rig, true)
    assert len(calibration.views) >= 14
    assert calibration.adjustment.rms_px <= 0.1
    assert (np.abs(error[[0, 1, 8, 9]]) <= 0.0012 * true.focal_rect).all()
    assert (np.abs(error[[2, 3, 10, 11]]) <= 1.2).all()
    assert abs(rig.baseline - true.baseline) <= 1e-4
    assert np.degrees(np.linalg.norm(error[16:19])) <= 0.12
    assert rig.calibration_covariance is not None
    assert (np.abs(error) <= 3.0 * np.sqrt(np.diag(rig.calibration_covariance))).all()


def test_navigating_with_the_rendered_calibration(rendered: Calibration, shared_data: Path) -> None:
    """The cost of it against the true rig, and what its covariance says of that cost."""
    sequence = open_sequence(shared_data / "sequences" / "approach")
    rig = calibrate(read_pairs(shared_data / "calibration"), Board(9, 6, 0.025)).rig
    target = attrs.evolve(sequence.target, tolerance=dict.fromkeys(sequence.target.points, 0.0))
    exact = np.zeros((22, 22))
    # The board is rendered with squares of exactly its size, which the written covariance does not take for granted.
    stated = rendered.adjustment.covariance
    navigators = [
        Navigator(attrs.evolve(r, calibration_covariance=covariance), target)
        for r, covariance in ((sequence.rig, exact), (rig, stated))
    ]
    costs, predicted = [], []
    for index in range(3, len(sequence), 8):
        true, calibrated = (navigator.process(sequence[index]) for navigator in navigators)
        assert true.T_world_target is not None
        assert calibrated.T_world_target is not None
        assert true.covariance is not None
        assert calibrated.covariance is not None
        cost = difference(calibrated.T_world_target, true.T_world_target)
        costs.append([np.linalg.norm(cost[:3]), np.linalg.norm(cost[3:])])
        variances = np.diag(calibrated.covariance - true.covariance)
        predicted.append([variances[:3].sum(), variances[3:].sum()])
    position, attitude = np.median(costs, axis=0)
    assert position <= 0.0015
    assert np.degrees(attitude) <= 0.15
    ratio = np.sqrt(np.mean(np.square(costs), axis=0) / np.mean(predicted, axis=0))
    assert ((ratio >= 0.5) & (ratio <= 2.0)).all()


def test_real_photographs() -> None:
    folder = Path(__file__).resolve().parents[2] / "data" / "real-calibration"
    if not folder.is_dir():
        pytest.skip("scripts/fetch-real-images has not fetched the photographs")
    board = Board(9, 6, 0.025)
    calibration = calibrate(read_pairs(folder), board)
    assert len(calibration.views) == 13
    assert calibration.adjustment.rms_px <= 0.25
    rig = calibration.rig
    left, right = (rig.raw_to_rect(camera, calibration.uv[:, camera]) for camera in range(2))
    assert np.nanmedian(np.abs(left[..., 1] - right[..., 1])) <= 0.12
    diagonal = float(np.linalg.norm(board.points[-1] - board.points[0]))
    flatness = []
    for xy_left, xy_right in zip(left, right, strict=True):
        seen = np.isfinite(xy_left).all(axis=1) & np.isfinite(xy_right).all(axis=1)
        points = np.full((len(seen), 3), np.nan)
        points[seen] = triangulate(rig.projection_matrix(0), rig.projection_matrix(1), xy_left[seen], xy_right[seen])
        centred = points[seen] - points[seen].mean(axis=0)
        flatness.append(np.linalg.svd(centred)[1][2] / np.sqrt(seen.sum()) / diagonal)
        grid = points.reshape(board.rows, board.columns, 3)
        pitches = [np.linalg.norm(np.diff(grid, axis=axis), axis=2) for axis in (0, 1)]
        pitch = np.nanmean(np.concatenate([lengths.ravel() for lengths in pitches]))
        assert abs(pitch / board.square - 1.0) <= 0.005
    assert np.median(flatness) <= 0.0015
