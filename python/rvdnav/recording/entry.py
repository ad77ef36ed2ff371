"""An image that a recording lists, and whether it is there and of the camera's size."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import attrs

from rvdnav.errors import InputError
from rvdnav.images import ImageError, Raster, image_size, read_image
from rvdnav.rig import Rig


class Container(Protocol):
    """A file of many images of one camera, each known by its stamp, ns."""

    def size(self, timestamp_ns: int) -> tuple[int, int]:
        """Width and height, px.  Raises ImageError when the image has none."""

    def read(self, timestamp_ns: int) -> Raster:
        """The image.  Raises ImageError when there is none."""


@attrs.frozen
class Entry:
    """An image that the record lists, its name for the user, its file or the container that it is in, and whether it
    begins like an image."""

    timestamp_ns: int
    name: str
    path: Path
    readable: bool = True
    container: Container | None = None

    def size(self) -> tuple[int, int]:
        """Width and height, px, as the file says.  Raises ImageError when it doesn't."""
        return image_size(self.path) if self.container is None else self.container.size(self.timestamp_ns)

    def read(self) -> Raster:
        """The image.  Raises ImageError when there is none."""
        return read_image(self.path) if self.container is None else self.container.read(self.timestamp_ns)


def check_images(entries: list[Entry], rig: Rig, notices: list[str]) -> list[Entry]:
    """The entries, marked where the file is no image; raises InputError naming an image of the wrong size."""
    checked = []
    for entry in entries:
        try:
            size = entry.size()
        except ImageError as error:
            notices.append(missing(entry, error))
            checked.append(attrs.evolve(entry, readable=False))
            continue
        where = entry.path if entry.container is None else f"{entry.path}: {entry.name}"
        if size != (rig.width, rig.height):
            raise InputError(f"{where}: is {size[0]}x{size[1]} but the calibration is for {rig.width}x{rig.height}")
        checked.append(entry)
    return checked


def missing(entry: Entry, error: ImageError) -> str:
    """The notice of an image that there is not."""
    return f"{entry.name} {error}: the frame goes on without it"
