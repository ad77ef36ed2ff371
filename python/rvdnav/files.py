"""Reading and writing of text files, with limits that hold for any file and errors that name it."""

from __future__ import annotations

import errno
import os
import re
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from rvdnav.errors import InputError

MOST_LINES = 100_000
_LARGEST_TEXT = 4 << 20
_LONGEST_LINE = 1 << 20
_LONGEST_NAME = 255
"""Bytes; Linux's own limit."""
_MARK = b"\xef\xbb\xbf"
"""UTF-8's byte order mark, which Windows' editors write."""
UNPRINTABLE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufeff\ufffe\uffff]")
"""Control characters and others that no text holds: all but tabs and the ends of lines."""


def open_plain(path: Path) -> BinaryIO:
    """A regular file, open for reading: of a pipe or a device no end may ever come.  Raises OSError."""
    try:
        # SIM115: the caller closes it, in a with statement of its own.
        file = open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK))  # noqa: SIM115
    except ValueError as error:  # a name with a NUL byte
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT)) from error
    if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
        file.close()
        raise OSError(errno.EINVAL, "not a plain file")
    return file


@contextmanager
def reading(path: Path) -> Iterator[BinaryIO]:
    """A regular file, open for reading; raises InputError naming it when it is missing or cannot be read."""
    try:
        with open_plain(path) as file:
            yield file
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error


def read_text(path: Path, largest: int = _LARGEST_TEXT) -> str:
    """The UTF-8 text of a file of at most so many bytes, without a byte order mark, its lines ended by newlines.

    Raises InputError naming it when it is missing, unreadable, larger or something else.
    """
    with reading(path) as file:
        data = file.read(largest + 1)
    if len(data) > largest:
        raise InputError(f"{path}: larger than {largest >> 20} MB")
    text = _decoded(path, data.removeprefix(_MARK))
    fault = UNPRINTABLE.search(text)
    if fault is not None:
        line = text.count("\n", 0, fault.start()) + 1
        raise InputError(f"{path}: line {line}: not a text: holds the character {fault[0]!r}")
    return text


def read_lines(path: Path) -> Iterator[tuple[int, str]]:
    """The lines of a UTF-8 text file with their numbers, from 1, each read when its turn comes.

    Raises InputError as `read_text` does, and for more than `MOST_LINES` lines.
    """
    with reading(path) as file:
        number = 0
        while data := file.readline(_LONGEST_LINE + 1):
            number += 1
            if number > MOST_LINES:
                raise InputError(f"{path}: more than {MOST_LINES} lines")
            if len(data) > _LONGEST_LINE:
                raise InputError(f"{path}: line {number}: longer than {_LONGEST_LINE >> 20} MB")
            line = _decoded(path, data.removeprefix(_MARK) if number == 1 else data).removesuffix("\n")
            fault = UNPRINTABLE.search(line)
            if fault is not None:
                raise InputError(f"{path}: line {number}: not a text: holds the character {fault[0]!r}")
            yield number, line


def read_rows(path: Path) -> Iterator[tuple[int, str]]:
    """As `read_lines`, without blank lines and comments, which begin with #."""
    return ((number, line) for number, line in read_lines(path) if line.strip() and not line.lstrip().startswith("#"))


def _decoded(path: Path, data: bytes) -> str:
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file (UTF-8)") from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def plain_name(name: str) -> str:
    """A file name that a file gives, checked: it names a file within the folder that it belongs to.

    Raises ValueError for a name that has a folder in it, is empty or longer than names can be.
    """
    if "/" in name or name in ("", ".", ".."):
        raise ValueError(f"{name!r} is not the name of a file alone")
    if len(name.encode()) > _LONGEST_NAME:
        raise ValueError(f"the file name {name!r} has more than {_LONGEST_NAME} bytes")
    return name


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
