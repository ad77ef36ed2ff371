"""A camera's images from a video file.

The decoder runs in a process of its own (`rvdnav.video_decoder`), its memory and the time of its answers bounded: a
file that crashes it costs frames, not the run.
"""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
import time
import weakref
from pathlib import Path

import attrs
import numpy as np

from rvdnav.errors import InputError
from rvdnav.extras import needs_extra
from rvdnav.files import reading
from rvdnav.images import ImageError, PixelArray, Raster

FORMATS = {".mp4": "mov", ".mov": "mov", ".mkv": "matroska", ".webm": "matroska", ".avi": "avi"}
"""By the end of a file's name, the container that it is read as: kinds that cannot name other files to be read."""
_ANSWER_SECONDS = 30.0
_BLOCK = 1 << 20


@attrs.frozen(eq=False)
class Video:
    """A video file: size of its frames, px, and their stamps, ns since its beginning, in order.

    Its frames are best asked for in their order; to go back is to decode it anew.
    """

    path: Path
    width: int
    height: int
    stamps_ns: tuple[int, ...]
    _decoder: _Decoder = attrs.field(repr=False)

    def size(self, timestamp_ns: int) -> tuple[int, int]:
        """Width and height of that frame, px: those of all."""
        return self.width, self.height

    def read(self, timestamp_ns: int) -> Raster:
        """The frame with this stamp; raises ImageError when it cannot be decoded."""
        return Raster(self.frame(timestamp_ns))

    def frame(self, stamp_ns: int) -> PixelArray:
        """Its grey levels (height, width)."""
        self._decoder.ask(stamp_ns)
        if self._decoder.read(1) != b"\1":
            raise ImageError("cannot be decoded")
        levels = np.frombuffer(self._decoder.read(self.width * self.height), np.uint8)
        return levels.reshape(self.height, self.width)


def open_video(path: Path) -> Video:
    """Raises InputError naming the file when it cannot be read or is no video."""
    with needs_extra("video", str(path)):
        import av  # noqa: F401 - only whether it is there; the decoder's process uses it
    with reading(path):  # a plain file
        pass
    decoder = _Decoder(path)
    header = b""
    try:
        while not header.endswith(b"\n"):
            header += decoder.read(1)
    except ImageError as error:
        raise InputError(f"{path}: {error}") from error
    facts = json.loads(header)
    if "fault" in facts:
        raise InputError(f"{path}: cannot be read as a video: {facts['fault']}")
    return Video(path, facts["width"], facts["height"], tuple(facts["stamps_ns"]), decoder)


class _Decoder:
    """A decoder at work; it ends with this object."""

    def __init__(self, path: Path) -> None:
        command = [sys.executable, "-m", "rvdnav.video_decoder", str(path), FORMATS[path.suffix.lower()]]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, bufsize=0
        )
        weakref.finalize(self, _end, self._process)
        self._unread = bytearray()

    def ask(self, stamp_ns: int) -> None:
        """Raises ImageError when the decoder is no more."""
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(stamp_ns.to_bytes(8, "little"))
        except BrokenPipeError as error:
            raise ImageError("cannot be decoded: the decoder has crashed") from error

    def read(self, size: int) -> bytes:
        """Its next bytes.  Raises ImageError when it ends before or takes too long, after which it is no more."""
        assert self._process.stdout is not None
        pipe = self._process.stdout.fileno()
        until = time.monotonic() + _ANSWER_SECONDS
        while len(self._unread) < size:
            ready, _, _ = select.select([pipe], [], [], max(until - time.monotonic(), 0.0))
            block = os.read(pipe, _BLOCK) if ready else b""
            if not block:
                self._process.kill()
                raise ImageError(f"cannot be decoded: the decoder {'has crashed' if ready else 'takes too long'}")
            self._unread += block
        data = bytes(self._unread[:size])
        del self._unread[:size]
        return data


def _end(process: subprocess.Popen[bytes]) -> None:
    process.kill()
    process.communicate()
