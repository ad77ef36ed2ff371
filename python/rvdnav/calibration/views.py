"""The views of the board: which of them are fit for calibrating, and why the others are not."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import attrs
import numpy as np

from rvdnav.calibration.board import Board
from rvdnav.calibration.detection import BoardNotFoundError, Corners, aligned, find_board
from rvdnav.calibration.sources import ImagePair
from rvdnav.images import PixelArray
from rvdnav.pose.arrays import FloatArray

SIDES = ("left", "right")
MIN_COMMON = 8
"""Corners that both cameras must see."""
_MIN_SPREAD = 0.3
"""Standard deviation of their places across, in squares; that of two rows is 0.5."""
_BLUR_RATIO = 2.0
_BLUR_FLOOR_PX = 1.2
"""Edges up to this sigma are never called blurred, however sharp the others are."""
_SAME_SHARE = 0.01
"""Views whose corners lie closer than this share of the image's diagonal (RMS) are nearly the same."""


@attrs.frozen(eq=False)
class View:
    """A view of the board in both cameras: its images and the corners in each."""

    name: str
    images: tuple[PixelArray, PixelArray]
    corners: tuple[Corners, Corners]

    @property
    def uv(self) -> FloatArray:
        """The corners (2, n, 2), px, by camera; NaN where not seen."""
        return np.stack([corners.uv for corners in self.corners])


@attrs.frozen
class Dropped:
    """A view that was not used, and why."""

    name: str
    reason: str


Progress = Callable[[str], None]
"""Is told the name of each view when it has been searched."""


@attrs.frozen(eq=False)
class Search:
    """What a search for one board gave."""

    board: Board
    views: list[View] = attrs.field(factory=list)
    dropped: list[Dropped] = attrs.field(factory=list)


def find_views(pairs: Iterable[ImagePair], board: Board, progress: Progress) -> Search:
    """The pairs with the board in both images, for that of the board's variants which more of them show.

    Raises ValueError when the images differ in size, the message naming the view.
    """
    searches = [Search(variant) for variant in board.variants]
    shape: tuple[int, ...] | None = None
    for pair in pairs:
        for image in pair.images:
            if not isinstance(image, str):
                shape = shape or image.shape
                if image.shape != shape:
                    sizes = " and ".join(f"{width}x{height}" for height, width in (shape, image.shape))
                    raise ValueError(f"view {pair.name}: the images differ in size: {sizes}")
        for search in searches:
            found = _find(pair, search.board)
            if isinstance(found, View):
                search.views.append(found)
            else:
                search.dropped.append(found)
        progress(pair.name)
    return max(searches, key=lambda search: len(search.views))


def _find(pair: ImagePair, board: Board) -> View | Dropped:
    images, corners, faults = [], [], {}
    for side, image in zip(SIDES, pair.images, strict=True):
        if isinstance(image, str):
            faults[side] = image
            continue
        try:
            corners.append(find_board(image, board))
            images.append(image)
        except BoardNotFoundError as reason:
            faults[side] = str(reason)
    if len(faults) == 2:
        left, right = (faults[side] for side in SIDES)
        return Dropped(pair.name, left if left == right else f"left: {left}; right: {right}")
    if faults:
        ((side, fault),) = faults.items()
        other = SIDES[1 - SIDES.index(side)]
        return Dropped(
            pair.name, fault if "there is no image" in fault else f"in the {other} image alone; {side}: {fault}"
        )
    view = View(pair.name, (images[0], images[1]), (corners[0], aligned(corners[1], corners[0], board)))
    common = board.points[np.isfinite(view.uv).all(axis=(0, 2))]
    if len(common) < MIN_COMMON:
        return Dropped(pair.name, f"the cameras see only {len(common)} corners in common")
    if min(np.std(common[:, :2], axis=0)) < _MIN_SPREAD * board.square:
        return Dropped(pair.name, "the corners that both cameras see lie in one line")
    return view


def select(views: list[View], dropped: list[Dropped]) -> list[View]:
    """The views that are neither blurred beside the others nor nearly the same as an earlier one.

    The others are added to `dropped`.
    """
    if not views:
        return []
    blur = np.array([[corners.blur for corners in view.corners] for view in views])
    usual = np.median(blur, axis=0)
    kept: list[View] = []
    height, width = views[0].images[0].shape
    least = _SAME_SHARE * float(np.hypot(width, height))
    for view, widths in zip(views, blur, strict=True):
        worst = int(np.argmax(widths / usual))
        same = next((other for other in kept if _distance(view, other) < least), None)
        if widths[worst] > max(_BLUR_RATIO * usual[worst], _BLUR_FLOOR_PX):
            reason = f"the {SIDES[worst]} image is blurred (sigma {widths[worst]:.1f} px, usually {usual[worst]:.1f})"
            dropped.append(Dropped(view.name, reason))
        elif same is not None:
            dropped.append(Dropped(view.name, f"nearly the same as {same.name}"))
        else:
            kept.append(view)
    return kept


def _distance(a: View, b: View) -> float:
    """RMS distance, px, of corners that both views show; infinite where there are too few."""
    squares = np.sum((a.uv - b.uv) ** 2, axis=-1)
    if np.isfinite(squares).sum() < MIN_COMMON:
        return float("inf")
    return float(np.sqrt(np.nanmean(squares)))
