"""The flat board that the cameras are calibrated with."""

from __future__ import annotations

import re
from functools import cached_property

import attrs
import cv2
import numpy as np

from rvdnav.errors import InputError
from rvdnav.pose.arrays import FloatArray, float_array

_MIN_CORNERS = 3
_UNITS = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}


def _square(_: object, __: object, value: float) -> None:
    if not 0.0 < value < np.inf:
        raise ValueError("the square has no size")


@attrs.frozen(slots=False)
class Board:
    """A chessboard, or a ChArUco board where `marker` is given.

    columns, rows: of inner corners.  square: side of a square, m.  marker: side of a marker, m.  dictionary: of its
    markers, as OpenCV names it without DICT_ ("5X5_100").  legacy: whether the squares' colours are those of OpenCV
    before 4.6, which differ for an even number of rows of squares.
    Corner i lies at `points` [i], m, in the board's frame: x along a row, y down the columns, z into the board.
    Raises ValueError for a board that there cannot be.
    """

    columns: int
    rows: int
    square: float = attrs.field(validator=_square)
    marker: float | None = None
    dictionary: str = "5X5_100"
    legacy: bool = False

    def __attrs_post_init__(self) -> None:
        if min(self.columns, self.rows) < _MIN_CORNERS:
            raise ValueError(f"a board has {_MIN_CORNERS} inner corners or more each way")
        if self.marker is not None:
            if not 0.0 < self.marker < self.square:
                raise ValueError("a marker is smaller than its square")
            if not hasattr(cv2.aruco, f"DICT_{self.dictionary}"):
                raise ValueError(f"there is no dictionary of markers called {self.dictionary!r}, such as 5X5_100")
            if self.markers > self._markers().bytesList.shape[0]:
                raise ValueError(f"the dictionary {self.dictionary} has fewer than the board's {self.markers} markers")

    @cached_property
    def points(self) -> FloatArray:
        """The corners (columns * rows, 3), m, row by row."""
        x, y = np.meshgrid(np.arange(self.columns), np.arange(self.rows))
        return float_array(np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3) * self.square, None, 3)

    @property
    def clearance(self) -> float:
        """How far from its edges a square is plain, in squares."""
        return np.inf if self.marker is None else 0.5 * (1.0 - self.marker / self.square)

    @property
    def markers(self) -> int:
        """How many markers a ChArUco board of this size has."""
        return (self.columns + 1) * (self.rows + 1) // 2

    @property
    def variants(self) -> tuple[Board, ...]:
        """The boards that this description may mean: ChArUco boards of an even number of rows of squares have two."""
        if self.marker is None or self.rows % 2 == 0:
            return (self,)
        return (self, attrs.evolve(self, legacy=True))

    def charuco(self) -> cv2.aruco.CharucoBoard:
        """The ChArUco board as OpenCV has it."""
        assert self.marker is not None
        size = (self.columns + 1, self.rows + 1)
        board = cv2.aruco.CharucoBoard(size, self.square, self.marker, self._markers())
        board.setLegacyPattern(self.legacy)
        return board

    def _markers(self) -> cv2.aruco.Dictionary:
        return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{self.dictionary}"))

    def __str__(self) -> str:
        kind = "chessboard" if self.marker is None else "ChArUco board"
        return f"{kind} of {self.columns}x{self.rows} inner corners"


def parse_corners(text: str) -> tuple[int, int]:
    """Inner corners a row and a column of "9x6".  Raises InputError."""
    match = re.fullmatch(r"([0-9]{1,3})[xX×]([0-9]{1,3})", text.strip())
    if match is None:
        raise InputError(f"--board: {text!r} is not a number of inner corners such as 9x6")
    return int(match[1]), int(match[2])


def parse_length(option: str, text: str) -> float:
    """Metres of "25mm", "2.5 cm" or "0.025 m"; without a unit it is refused.  Raises InputError naming the option."""
    match = re.fullmatch(r"([0-9]+(?:\.[0-9]*)?|\.[0-9]+)\s*(mm|cm|m)", text.strip())
    if match is None:
        raise InputError(f"{option}: {text!r} is not a length with its unit, such as 25mm")
    return float(match[1]) * _UNITS[match[2]]
