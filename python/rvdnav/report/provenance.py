"""What made a report: version, command, files, settings."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path

from rvdnav import __version__

_FILES = ("camchain.yaml", "rig.yaml", "target.yaml", "groundtruth.tum", "cam0/data.csv", "cam1/data.csv")


def provenance(command: Iterable[str], folder: Path) -> list[tuple[str, str]]:
    """Names and values: the version, the command's words, and the SHA-256 of a sequence's files other than images."""
    facts = [("rvdnav", __version__), ("command", " ".join(["rvdnav", *map(_word, command)]))]
    for name in _FILES:
        path = folder / name
        if path.is_file():
            facts.append((name, f"SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()}"))
    return facts


def _word(text: str) -> str:
    return f"'{text}'" if " " in text else text
