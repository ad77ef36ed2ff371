"""The options that say what a recording doesn't say itself, the same for all commands that have them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypedDict

import typer

Rate = Annotated[
    float | None,
    typer.Option("--rate", metavar="HZ", help="Frame rate of pictures whose names count them, in place of times."),
]
Topics = Annotated[
    str | None,
    typer.Option("--topics", metavar="LEFT,RIGHT", help="Image topics of a bag, where it is not clear which."),
]
RigPath = Annotated[
    Path | None,
    typer.Option("--rig", metavar="PATH", help="Folder of camchain.yaml, where it lies elsewhere."),
]
TargetPath = Annotated[
    Path | None, typer.Option("--target", metavar="FILE", help="Target file, where it lies elsewhere.")
]


class Source(TypedDict, total=False):
    """Keyword arguments of `rvdnav.open_sequence`."""

    rate_hz: float | None
    topics: list[str] | None
    rig: Path | None
    target: Path | None


def source(rate: float | None, topics: str | None, rig: Path | None, target: Path | None) -> Source:
    """Of the options' values."""
    return Source(rate_hz=rate, topics=None if topics is None else topics.split(","), rig=rig, target=target)
