"""`SHA256SUMS`: the digests of a black box's files, as ``sha256sum -c`` reads them."""

from __future__ import annotations

import hashlib
from pathlib import Path

from rvdnav.errors import InputError
from rvdnav.files import read_text

DIGESTS = "SHA256SUMS"


def write_digests(folder: Path) -> None:
    """Write the digest of every other file below a folder."""
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path != folder / DIGESTS)
    lines = [f"{_digest(path)}  {path.relative_to(folder).as_posix()}" for path in files]
    (folder / DIGESTS).write_text("\n".join([*lines, ""]), encoding="utf-8")


def check_digests(folder: Path) -> None:
    """Raise InputError naming the first file that is missing or not as it was written."""
    for number, line in enumerate(read_text(folder / DIGESTS).splitlines(), start=1):
        digest, separator, name = line.partition("  ")
        if not separator:
            raise InputError(f"{folder / DIGESTS}: line {number}: not a digest and a file name")
        path = folder / name
        if not path.is_file():
            raise InputError(f"{path}: no such file")
        if _digest(path) != digest:
            raise InputError(f"{path}: is not as it was recorded (digest)")


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
