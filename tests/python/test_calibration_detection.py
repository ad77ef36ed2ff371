"""Finding the board in one picture: whatever its size, and what is said where it is not there."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest
from board_scene import BOARD, T_cam0_boards, draw_board, exact_corners
from rvdnav.calibration import Board
from rvdnav.calibration.detection import BoardNotFoundError, find_board
from rvdnav.images import PixelArray

POSE = T_cam0_boards(1)[0]


@pytest.fixture(scope="module")
def picture() -> PixelArray:
    return draw_board(0, POSE)


@pytest.mark.parametrize("factor", [2, 5])
def test_a_large_picture_is_measured_in_its_own_pixels(picture: PixelArray, factor: int) -> None:
    large = cv2.resize(picture, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC).astype(np.uint8)
    found = find_board(large, BOARD).uv
    exact = (exact_corners(POSE[None])[0, 0] + 0.5) * factor - 0.5
    assert np.abs(found - exact).max() < 0.1 * factor


def test_a_far_board_in_a_large_picture_is_found(picture: PixelArray) -> None:
    large = np.full((1728, 2112), 70, np.uint8)
    large[900 : 900 + 288, 1200 : 1200 + 352] = picture
    exact = exact_corners(POSE[None])[0, 0] + (1200, 900)
    assert np.abs(find_board(large, BOARD).uv - exact).max() < 0.1


@pytest.mark.parametrize(
    ("columns", "rows", "said"),
    [
        (6, 4, "7x5 corners are seen, not 6x4"),
        (4, 6, "5x7 corners are seen, not 4x6"),
        (9, 4, "7x5 corners are seen, not 9x4"),
        (8, 6, "7x5 of the 8x6 corners are seen"),
    ],
)
def test_a_board_of_another_size_is_named(picture: PixelArray, columns: int, rows: int, said: str) -> None:
    with pytest.raises(BoardNotFoundError, match=said):
        find_board(picture, Board(columns, rows, 0.03))


@pytest.mark.parametrize("octaves", [(0,), (1,), (2, 4), (1, 2, 4, 8, 16), (4, 8, 16), (8,)])
def test_noise_and_foliage_are_no_board(octaves: tuple[int, ...]) -> None:
    rng = np.random.default_rng(3)
    for _ in range(3):
        sum_ = np.zeros((240, 320))
        for sigma in octaves:
            noise = rng.normal(0.0, 1.0, sum_.shape)
            sum_ += sigma * cv2.GaussianBlur(noise, (0, 0), sigma) if sigma else noise
        image = np.interp(sum_, (sum_.min(), sum_.max()), (0, 255)).astype(np.uint8)
        with pytest.raises(BoardNotFoundError, match=r"^the board was not found$"):
            find_board(image, Board(9, 6, 0.025))


@pytest.mark.parametrize("shape", [(1, 1), (2, 2), (3, 400), (12, 12), (40, 30)])
@pytest.mark.parametrize("board", [Board(9, 6, 0.025), Board(5, 4, 0.05, 0.0375, "4X4_50")], ids=["chess", "charuco"])
def test_pictures_too_small_for_anything(shape: tuple[int, int], board: Board) -> None:
    image = np.random.default_rng(0).integers(0, 256, shape, dtype=np.uint8)
    with pytest.raises(BoardNotFoundError):
        find_board(image, board)


def test_the_slow_search_sees_no_large_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    """By quadrangles a dark picture of 5 megapixels takes minutes, in which nothing can stop it."""
    sizes: dict[str, list[int]] = {"findChessboardCorners": [], "findChessboardCornersSB": []}

    def spy(name: str) -> None:
        search = getattr(cv2, name)

        def spied(image: PixelArray, *args: Any, **options: Any) -> Any:
            sizes[name].append(image.size)
            return search(image, *args, **options)

        monkeypatch.setattr(cv2, name, spied)

    for name in sizes:
        spy(name)
    dark = np.clip(np.random.default_rng(0).normal(2.0, 1.5, (2048, 2448)), 0, 255).astype(np.uint8)
    with pytest.raises(BoardNotFoundError, match="the board was not found"):
        find_board(dark, Board(9, 6, 0.025))
    assert 0 < max(sizes["findChessboardCorners"]) <= 501_000
    assert max(sizes["findChessboardCornersSB"]) <= 6_010_000
