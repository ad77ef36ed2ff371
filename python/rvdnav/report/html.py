"""The pieces that reports are made of, as HTML: cards, figures, headline numbers, tables, notes, pictures."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping, Sequence
from html import escape

import attrs
import cv2
import numpy as np
import plotly.graph_objects as go
from numpy.typing import NDArray


@attrs.frozen
class Verdict:
    """What came out, as a sentence of plain text; level: good, fair or bad."""

    level: str
    text: str


class Html(str):
    """A table's cell that is HTML already; any other text is escaped."""


def section(title: str, body: str) -> str:
    """A card of the page: its heading, plain text, and its HTML."""
    return f"<section><h2>{escape(title)}</h2>\n{body}\n</section>"


def verdict_html(verdict: Verdict) -> str:
    """The sentence at the top of a page."""
    return f'<p class="verdict {verdict.level}">{escape(verdict.text)}</p>'


def figures_html(figures: Iterable[tuple[str, go.Figure]], name: str, colours: Mapping[str, str]) -> str:
    """Figures with titles beside each other where there is room, below a legend that they share.

    name: unique on the page.  colours: of the legend, by what they stand for.
    """
    legend = " ".join(
        f'<span class="swatch" style="--colour: {colour}">{escape(text)}</span>' for text, colour in colours.items()
    )
    cells = [
        f"<div><h3>{escape(title)}</h3>{figure_html(figure, f'{name}-{i}')}</div>"
        for i, (title, figure) in enumerate(figures)
    ]
    return f'<p class="legend">{legend}</p><div class="figures">{"".join(cells)}</div>'


def figure_html(figure: go.Figure, name: str) -> str:
    """A figure as HTML; its name is unique on the page."""
    buttons = [["toImage", "zoom2d", "pan2d", "resetScale2d"]]
    config = {"displaylogo": False, "responsive": True, "modeBarButtons": buttons}
    text: str = figure.to_html(full_html=False, include_plotlyjs=False, div_id=f"figure-{name}", config=config)
    return text


def tiles_html(tiles: Iterable[tuple[str, str, str]]) -> str:
    """Headline numbers: each its label, value and note."""
    return "".join(
        f'<div class="tile"><div class="label">{escape(label)}</div><div class="value">{escape(value)}</div>'
        f'<div class="note">{escape(note)}</div></div>'
        for label, value, note in tiles
    )


def table_html(
    headings: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    groups: Sequence[tuple[str, int]] = (),
    total: bool = False,
) -> str:
    """A table that scrolls where it is too wide.

    groups: headings above the headings, each with the number of columns that it spans.  total: the last row is one.
    """
    above = "".join(f'<th colspan="{columns}">{escape(text)}</th>' for text, columns in groups)
    head = (f"<tr>{above}</tr>" if groups else "") + f"<tr>{_cells('th', headings)}</tr>"
    body = [f"<tr>{_cells('td', row)}</tr>" for row in rows]
    if total:
        body[-1] = body[-1].replace("<tr>", '<tr class="total">', 1)
    return f'<div class="scroll"><table><thead>{head}</thead><tbody>{"".join(body)}</tbody></table></div>'


def _cells(tag: str, texts: Iterable[str]) -> str:
    return "".join(f"<{tag}>{text if isinstance(text, Html) else escape(text)}</{tag}>" for text in texts)


def facts_html(facts: Iterable[tuple[str, str]]) -> str:
    """A table of names and what belongs to them, which may be long."""
    rows = (f'<tr><td>{escape(name)}</td><td class="text">{escape(text)}</td></tr>' for name, text in facts)
    return f'<div class="scroll"><table><tbody>{"".join(rows)}</tbody></table></div>'


def note_html(text: str) -> str:
    """A small note, plain text, beside a figure or table."""
    return f'<p class="legend">{escape(text)}</p>'


def strip_html(pictures: Iterable[tuple[str, str]]) -> str:
    """Pictures beside each other, each its URI and caption (plain text); one is enlarged by a click."""
    figures = [
        "<figure onclick=\"this.classList.toggle('wide')\">"
        f'<img src="{uri}" alt="{escape(caption)}" loading="lazy"><figcaption>{escape(caption)}</figcaption></figure>'
        for uri, caption in pictures
    ]
    return f'<div class="strip">{"".join(figures)}</div>'


def png_uri(image: NDArray[np.uint8]) -> str:
    """An image, grey (h, w) or BGR (h, w, 3), for an img element's src, without loss."""
    return _uri("png", image, [])


def jpeg_uri(image: NDArray[np.uint8], quality: int) -> str:
    """An image for an img element's src, its colours at full resolution: fine lines and dots keep theirs."""
    full = [cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444]
    return _uri("jpeg", image, [cv2.IMWRITE_JPEG_QUALITY, quality, *full])


def _uri(kind: str, image: NDArray[np.uint8], options: list[int]) -> str:
    _, encoded = cv2.imencode(f".{kind}", image, options)
    return f"data:image/{kind};base64,{base64.b64encode(encoded.tobytes()).decode('ascii')}"
