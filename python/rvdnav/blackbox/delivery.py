"""`frames.csv`: which images arrived as which frame, in the order of arrival.

A sequence folder alone doesn't tell: it is read in time order and pairs its images by their stamps.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import attrs

from rvdnav.conventions import parse_timestamp_ns
from rvdnav.errors import InputError
from rvdnav.files import plain_name, read_rows
from rvdnav.images import Image, ImageError, read_image
from rvdnav.sequence import CAMERAS, Frame

FRAMES = "frames.csv"
_HEADING = "#timestamp [ns],left timestamp [ns],left filename,right timestamp [ns],right filename"


@attrs.frozen
class ImageRow:
    """An image's own stamp and its file."""

    timestamp_ns: int
    path: Path

    def read(self) -> Image:
        """Raises InputError naming the file when it holds no image."""
        try:
            pixels = read_image(self.path).grey8
        except ImageError as error:
            raise InputError(f"{self.path}: {error}") from error
        return Image(pixels, self.timestamp_ns)


@attrs.frozen
class FrameRow:
    """A frame's stamp and its images, None where there was none."""

    timestamp_ns: int
    left: ImageRow | None
    right: ImageRow | None

    def read(self) -> Frame:
        """The frame as it was delivered.  Raises InputError naming an image that cannot be read."""
        left, right = (None if image is None else image.read() for image in (self.left, self.right))
        return Frame(self.timestamp_ns, left, right)


def frames_text(frames: Iterable[Frame], names: Iterable[tuple[str | None, ...]]) -> str:
    """The text of the file for frames and the file names of their left and right images."""
    lines = [_HEADING]
    for frame, files in zip(frames, names, strict=True):
        cells = [str(frame.timestamp_ns)]
        for image, name in zip((frame.left, frame.right), files, strict=True):
            cells += ["", ""] if image is None or name is None else [str(image.timestamp_ns), name]
        lines.append(",".join(cells))
    return "\n".join([*lines, ""])


def read_frames(folder: Path) -> list[FrameRow]:
    """The frames of a black box in the order of arrival.  Raises InputError naming the file and line at fault."""
    path = folder / FRAMES
    rows = []
    for number, line in read_rows(path):
        try:
            rows.append(_parse(folder, line.split(",")))
        except ValueError as error:
            raise InputError(f"{path}: line {number}: {error}") from error
    if not rows:
        raise InputError(f"{path}: holds no frames")
    return rows


def _parse(folder: Path, cells: list[str]) -> FrameRow:
    if len(cells) != 5:
        raise ValueError(f"not a row of {_HEADING[1:]}")
    left, right = (
        ImageRow(parse_timestamp_ns(stamp), folder / camera / "data" / plain_name(name)) if name else None
        for camera, stamp, name in zip(CAMERAS, cells[1::2], cells[2::2], strict=True)
    )
    return FrameRow(parse_timestamp_ns(cells[0]), left, right)
