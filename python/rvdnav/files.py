"""Reading and writing of text files, with errors that name the file."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from rvdnav.errors import InputError


def read_text(path: Path) -> str:
    """The UTF-8 text of a file.  Raises InputError naming it when it is missing, unreadable or something else."""
    try:
        return path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file (UTF-8)") from None


def write_text_atomically(path: Path, text: str) -> None:
    """Write a UTF-8 text file, whole or not at all: a reader sees the old file or the new one.

    Raises InputError naming the file when it cannot be written.
    """
    try:
        descriptor, temporary = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
        os.chmod(temporary, 0o666 & ~_umask())  # mkstemp makes it private
        os.replace(temporary, path)
    except BaseException as error:
        os.unlink(temporary)
        if isinstance(error, OSError):
            raise InputError(f"{path}: cannot be written: {error.strerror}") from error
        raise


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
