"""The program that decodes a video for `rvdnav.video`, in a process of its own.

    python -m rvdnav.video_decoder VIDEO FORMAT

writes a line of JSON, {"width", "height", "stamps_ns"} or {"fault"}.  Then it answers each stamp, ns, that it reads, 8
bytes, little end first, with a byte, 1 or 0, and after a 1 with that frame's grey levels, 8 bits each.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

import av
from av.container import InputContainer
from av.video.stream import VideoStream

from rvdnav.child_process import limit_resources

_MOST_PIXELS = 50_000_000
_MOST_FRAMES = 1_000_000


def _main(file: BinaryIO, name: str, requests: BinaryIO, answers: BinaryIO) -> None:
    limit_resources()
    try:
        header = _header(file, name)
    except (av.FFmpegError, OSError, ValueError, MemoryError) as error:
        header = {"fault": getattr(error, "strerror", None) or str(error) or "it is too large"}
    answers.write(json.dumps(header).encode() + b"\n")
    answers.flush()
    stamp, levels = sys.maxsize, b""
    frames = iter([(stamp, levels)])
    last = stamp
    while len(request := requests.read(8)) == 8:
        wanted = int.from_bytes(request, "little")
        if wanted <= last:
            frames = _frames(file, name, header["width"], header["height"])
            stamp = -1
        last = wanted
        while stamp < wanted:
            stamp, levels = next(frames, (sys.maxsize, b""))
        answers.write(b"\1" + levels if stamp == wanted else b"\0")
        answers.flush()


def _header(file: BinaryIO, name: str) -> dict[str, Any]:
    """Size and stamps, from the container alone."""
    with av.open(file, format=name) as container:
        stream = _stream(container)
        if not 0 < stream.width * stream.height <= _MOST_PIXELS:
            raise ValueError(f"its frames are {stream.width}x{stream.height}")
        stamps = set()
        for packet in container.demux(stream):
            if packet.pts is not None:
                stamps.add(_stamp(packet.pts, stream))
            if len(stamps) > _MOST_FRAMES:
                raise ValueError(f"it has more than {_MOST_FRAMES} frames")
    if not stamps or min(stamps) < 0:
        raise ValueError("it doesn't say when its frames were taken")
    return {"width": stream.width, "height": stream.height, "stamps_ns": sorted(stamps)}


def _frames(file: BinaryIO, name: str, width: int, height: int) -> Iterator[tuple[int, bytes]]:
    file.seek(0)
    with av.open(file, format=name) as container:
        stream = _stream(container)
        for packet in container.demux(stream):
            try:
                frames = packet.decode()
            except av.FFmpegError:  # damaged; later ones may be whole
                continue
            for frame in frames:
                if frame.pts is not None and (frame.width, frame.height) == (width, height):
                    yield _stamp(frame.pts, stream), frame.to_ndarray(format="gray").tobytes()


def _stream(container: InputContainer) -> VideoStream:
    if not container.streams.video:
        raise ValueError("it holds no pictures")
    return container.streams.video[0]


def _stamp(ticks: int, stream: VideoStream) -> int:
    """Of a moment since the stream's start, ns, rounded."""
    if stream.time_base is None:
        raise ValueError("it has no unit of time")
    stamp_ns: int = round((ticks - (stream.start_time or 0)) * stream.time_base * 1_000_000_000)
    return stamp_ns


if __name__ == "__main__":
    with Path(sys.argv[1]).open("rb") as video:
        _main(video, sys.argv[2], sys.stdin.buffer, sys.stdout.buffer)
