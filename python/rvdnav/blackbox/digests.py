"""`SHA256SUMS`: the digests of a black box's files, as ``sha256sum -c`` reads them."""

from __future__ import annotations

import hashlib
from pathlib import Path

from rvdnav.errors import InputError
from rvdnav.files import plain_name, read_lines, reading

DIGESTS = "SHA256SUMS"


def write_digests(folder: Path) -> None:
    """Write the digest of every other file below a folder."""
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path != folder / DIGESTS)
    lines = [f"{_digest(path)}  {path.relative_to(folder).as_posix()}" for path in files]
    (folder / DIGESTS).write_text("\n".join([*lines, ""]), encoding="utf-8")


def check_digests(folder: Path) -> None:
    """Raise InputError naming the first file that is missing or not as it was written."""
    for number, line in read_lines(folder / DIGESTS):
        digest, separator, name = line.partition("  ")
        if not separator:
            raise InputError(f"{folder / DIGESTS}: line {number}: not a digest and a file name")
        try:
            path = folder.joinpath(*map(plain_name, name.split("/")))
        except ValueError as error:
            raise InputError(f"{folder / DIGESTS}: line {number}: {error}") from error
        if _digest(path) != digest:
            raise InputError(f"{path}: is not as it was recorded (digest)")


def _digest(path: Path) -> str:
    digest = hashlib.sha256()
    with reading(path) as file:
        while block := file.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()
