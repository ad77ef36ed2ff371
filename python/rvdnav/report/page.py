"""The page that all reports share: an HTML file that needs no network, with the library of its figures beside it."""

from __future__ import annotations

import string
from collections.abc import Iterable, Sequence
from html import escape
from importlib import resources
from pathlib import Path

from plotly.offline import get_plotlyjs

from rvdnav.report.html import Verdict, tiles_html, verdict_html

LIBRARY = "plotly.min.js"
"""Beside every page, so that a folder's pages share it."""


def write_page(
    path: Path,
    title: str,
    subtitle: str,
    tiles: Iterable[tuple[str, str, str]],
    sections: Sequence[str],
    *,
    verdict: Verdict | None = None,
) -> None:
    """Write a report and, beside it, the library that draws its figures.

    title, subtitle: plain text.  verdict: what came out, in a sentence.  tiles: headline numbers as `tiles_html` takes
    them.  sections: HTML.
    """
    template = string.Template(resources.files("rvdnav.report").joinpath("page.html").read_text(encoding="utf-8"))
    page = template.substitute(
        title=escape(title),
        subtitle=escape(subtitle),
        verdict="" if verdict is None else verdict_html(verdict),
        tiles=tiles_html(tiles),
        library=LIBRARY,
        sections="\n".join(sections),
    )
    (path.parent / LIBRARY).write_text(get_plotlyjs(), encoding="utf-8")
    # Names of files need not be text: what isn't is shown as the replacement character.
    path.write_text(page.encode("utf-8", "surrogateescape").decode("utf-8", "replace"), encoding="utf-8")
