"""The envelope in one picture (SVG): a line a fault, a cell a strength."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import attrs

_COLOURS = {"all": "#23a172", "most": "#8fcfb4", "few": "#c9cdd6", "dishonest": "#d94f4f"}
_LEGEND = {
    "all": "95 % published or more",
    "most": "60 % or more",
    "few": "fewer",
    "dishonest": "a pose wrong, or the covariance too small",
}
_LABEL_PX, _CELL_PX, _ROW_PX, _TOP_PX = 220, 112, 30, 44


@attrs.frozen
class Cell:
    """One strength of a fault: as text, the share published, and whether the published poses can be relied upon."""

    strength: str
    published: float
    honest: bool

    @property
    def kind(self) -> str:
        """Key of its colour."""
        if not self.honest:
            return "dishonest"
        return "all" if self.published >= 0.95 else "most" if self.published >= 0.60 else "few"


def picture(rows: dict[str, Sequence[Cell]]) -> str:
    """The text of the SVG for the cells of each fault."""
    width = _LABEL_PX + _CELL_PX * max(len(cells) for cells in rows.values()) + 10
    width = max(width, 720)
    height = _TOP_PX + _ROW_PX * len(rows) + 10
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" '
        'font-family="system-ui, sans-serif" font-size="13">',
        f'<rect width="{width}" height="{height}" fill="#ffffff"/>',
    ]
    left = 10
    for kind, text in _LEGEND.items():
        parts.append(f'<rect x="{left}" y="14" width="14" height="14" rx="3" fill="{_COLOURS[kind]}"/>')
        parts.append(_text(left + 20, 26, text))
        left += 44 + round(6.6 * len(text))
    for number, (fault, cells) in enumerate(rows.items()):
        y = _TOP_PX + _ROW_PX * number
        parts.append(_text(10, y + 19, fault))
        for column, cell in enumerate(cells):
            x = _LABEL_PX + _CELL_PX * column
            parts.append(
                f'<rect x="{x}" y="{y}" width="{_CELL_PX - 4}" height="{_ROW_PX - 4}" rx="4" '
                f'fill="{_COLOURS[cell.kind]}"/>'
            )
            told = (
                f"{cell.strength}: {100.0 * cell.published:.0f} %"
                if cell.strength
                else f"{100.0 * cell.published:.0f} %"
            )
            parts.append(_text(x + _CELL_PX // 2 - 2, y + 18, told, size=10, middle=True))
    return "\n".join([*parts, "</svg>", ""])


def _text(x: int, y: int, text: str, *, size: int = 13, middle: bool = False) -> str:
    anchor = ' text-anchor="middle"' if middle else ""
    return f'<text x="{x}" y="{y}" font-size="{size}" fill="#1d2433"{anchor}>{escape(text)}</text>'
