"""The options that say what a recording doesn't say itself, the same for all commands that have them."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, TypedDict

import typer

Rate = Annotated[
    float | None,
    typer.Option("--rate", metavar="HZ", help="Frame rate of pictures whose names count them, in place of times."),
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
    rig: Path | None
    target: Path | None
