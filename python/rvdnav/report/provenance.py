"""What made a report: version, command, files, settings."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from pathlib import Path

from rvdnav import __version__

_CAMERA_FILES = tuple(
    f"{base}cam{n}/{name}" for base in ("", "mav0/") for n in (0, 1) for name in ("data.csv", "sensor.yaml")
)
_FILES = ("camchain.yaml", "rig.yaml", "target.yaml", "metadata.yaml", "groundtruth.tum", *_CAMERA_FILES)


def provenance(command: Iterable[str], folder: Path, others: Iterable[Path] = ()) -> list[tuple[str, str]]:
    """Names and values: the version, the command's words, and the SHA-256 of a sequence's files other than images.

    others: files that the command names besides those in the sequence's folder.
    """
    facts = [("rvdnav", __version__), ("command", " ".join(["rvdnav", *map(_word, command)]))]
    files = [(name, folder / name) for name in _FILES] + [(path.name, path) for path in others]
    for name, path in files:
        if path.is_file():
            facts.append((name, f"SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()}"))
    return facts


def _word(text: str) -> str:
    return f"'{text}'" if " " in text else text
