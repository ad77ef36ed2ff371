"""What a command's options said of a recording, for its report."""

from __future__ import annotations

from pathlib import Path

from rvdnav.cli.options import Source
from rvdnav.rig import CAMCHAIN, RIG


def source_words(source: Source) -> list[str]:
    """The options once more, files by their names alone."""
    words = []
    if source.get("rate_hz") is not None:
        words += ["--rate", f"{source['rate_hz']:g}"]
    if source.get("topics") is not None:
        words += ["--topics", ",".join(source["topics"] or [])]
    for name, path in (("--rig", source.get("rig")), ("--target", source.get("target"))):
        words += [] if path is None else [name, path.name]
    return words


def other_files(source: Source) -> list[Path]:
    """The files that they name, those of a rig's folder in its place."""
    rig, target = source.get("rig"), source.get("target")
    folder = rig if rig is None or rig.is_dir() else rig.parent
    files = [] if folder is None else [folder / CAMCHAIN, folder / RIG]
    return files if target is None else [*files, target]
