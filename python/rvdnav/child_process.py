"""A program of the package in a process of its own: what crashes or hangs there costs an answer, not the run."""

from __future__ import annotations

import os
import resource
import select
import subprocess
import sys
import time
import weakref

_ANSWER_SECONDS = 30.0
_BLOCK = 1 << 20
_LONGEST_LINE = 64 << 20
_MOST_MEMORY = 2 << 30


class ChildError(Exception):
    """The program is no more; the message says why: "has crashed" or "takes too long"."""


class ChildProcess:
    """`python -m MODULE ARGUMENTS`, spoken to over its standard input and output; it ends with this object."""

    def __init__(self, module: str, *arguments: str) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", module, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            bufsize=0,
        )
        weakref.finalize(self, _end, self._process)
        self._unread = bytearray()

    def write(self, data: bytes) -> None:
        """Give it these bytes.  Raises ChildError."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(data)
        except BrokenPipeError as error:
            raise ChildError("has crashed") from error

    def read(self, size: int) -> bytes:
        """Its next bytes.  Raises ChildError when it ends before or takes too long, after which it is no more."""
        until = time.monotonic() + _ANSWER_SECONDS
        while len(self._unread) < size:
            self._receive(until)
        return self._taken(size)

    def read_line(self) -> bytes:
        """Its next bytes to the end of the line.  Raises ChildError as `read` does."""
        until = time.monotonic() + _ANSWER_SECONDS
        searched = 0
        while (end := self._unread.find(b"\n", searched)) < 0:
            searched = len(self._unread)
            if searched > _LONGEST_LINE:
                raise ChildError("has crashed")
            self._receive(until)
        return self._taken(end + 1)

    def _taken(self, size: int) -> bytes:
        data = bytes(self._unread[:size])
        del self._unread[:size]
        return data

    def _receive(self, until: float) -> None:
        assert self._process.stdout is not None
        pipe = self._process.stdout.fileno()
        ready, _, _ = select.select([pipe], [], [], max(until - time.monotonic(), 0.0))
        block = os.read(pipe, _BLOCK) if ready else b""
        if not block:
            self._process.kill()
            raise ChildError("has crashed" if ready else "takes too long")
        self._unread += block


def limit_resources() -> None:
    """To be called in the child: bounds its memory, and has it write no files."""
    resource.setrlimit(resource.RLIMIT_AS, (_MOST_MEMORY, _MOST_MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.communicate()
