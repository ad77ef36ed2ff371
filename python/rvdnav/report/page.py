"""The page that all reports share: one HTML file that needs no network."""

from __future__ import annotations

import string
from collections.abc import Iterable, Sequence
from html import escape
from importlib import resources
from pathlib import Path

from plotly.offline import get_plotlyjs

from rvdnav.report.html import tiles_html


def write_page(
    path: Path, title: str, subtitle: str, tiles: Iterable[tuple[str, str, str]], sections: Sequence[str]
) -> None:
    """Write a report: title and subtitle plain text, headline numbers as `tiles_html` takes them, sections HTML."""
    template = string.Template(resources.files("rvdnav.report").joinpath("page.html").read_text(encoding="utf-8"))
    page = template.substitute(
        title=escape(title),
        subtitle=escape(subtitle),
        tiles=tiles_html(tiles),
        plotly=get_plotlyjs(),
        sections="\n".join(sections),
    )
    # Names of files need not be text: what isn't is shown as the replacement character.
    path.write_text(page.encode("utf-8", "surrogateescape").decode("utf-8", "replace"), encoding="utf-8")
