"""A camera's images from a video file.

The decoder runs in a process of its own (`rvdnav.video_decoder`), its memory and the time of its answers bounded: a
file that crashes it costs frames, not the run.
"""

from __future__ import annotations

import json
from pathlib import Path

import attrs
import numpy as np

from rvdnav.child_process import ChildError, ChildProcess
from rvdnav.errors import InputError
from rvdnav.extras import needs_extra
from rvdnav.files import reading
from rvdnav.images import ImageError, PixelArray, Raster

FORMATS = {".mp4": "mov", ".mov": "mov", ".mkv": "matroska", ".webm": "matroska", ".avi": "avi"}
"""By the end of a file's name, the container that it is read as: kinds that cannot name other files to be read."""


@attrs.frozen(eq=False)
class Video:
    """A video file: size of its frames, px, and their stamps, ns since its beginning, in order.

    Its frames are best asked for in their order; to go back is to decode it anew.
    """

    path: Path
    width: int
    height: int
    stamps_ns: tuple[int, ...]
    _decoder: ChildProcess = attrs.field(repr=False)

    def size(self, timestamp_ns: int) -> tuple[int, int]:
        """Width and height of that frame, px: those of all."""
        return self.width, self.height

    def read(self, timestamp_ns: int) -> Raster:
        """The frame with this stamp; raises ImageError when it cannot be decoded."""
        return Raster(self.frame(timestamp_ns))

    def frame(self, stamp_ns: int) -> PixelArray:
        """Its grey levels (height, width); raises ImageError when it cannot be decoded."""
        try:
            self._decoder.write(stamp_ns.to_bytes(8, "little"))
            if self._decoder.read(1) != b"\1":
                raise ImageError("cannot be decoded")
            levels = np.frombuffer(self._decoder.read(self.width * self.height), np.uint8)
        except ChildError as error:
            raise ImageError(f"cannot be decoded: the decoder {error}") from error
        return levels.reshape(self.height, self.width)


def open_video(path: Path) -> Video:
    """Raises InputError naming the file when it cannot be read or is no video."""
    with needs_extra("video", str(path)):
        import av  # noqa: F401 - only whether it is there; the decoder's process uses it
    with reading(path):  # a plain file
        pass
    decoder = ChildProcess("rvdnav.video_decoder", str(path), FORMATS[path.suffix.lower()])
    try:
        facts = json.loads(decoder.read_line())
    except ChildError as error:
        raise InputError(f"{path}: cannot be decoded: the decoder {error}") from error
    if "fault" in facts:
        raise InputError(f"{path}: cannot be read as a video: {facts['fault']}")
    return Video(path, facts["width"], facts["height"], tuple(facts["stamps_ns"]), decoder)
