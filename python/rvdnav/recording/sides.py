"""Which folder or video of a recording is which camera's, by their names."""

from __future__ import annotations

import os
from pathlib import Path

from rvdnav.errors import InputError
from rvdnav.video import FORMATS

SIDES = (("cam0", "left"), ("cam1", "right"))
"""What the left and the right camera's folders, videos and pictures are called."""


def find_place(folder: Path, names: tuple[str, ...]) -> Path | None:
    """A camera's folder or video in a folder, called by one of its names; None where there is none.

    Raises InputError naming two of which either may be this camera's.
    """
    videos = [folder / f"{name}{suffix}" for name in names for suffix in FORMATS]
    found = [video for video in videos if video.exists()]
    found += [folder / name for name in names if os.path.isdir(folder / name)]
    if len(found) > 1:
        raise InputError(f"{found[0]}: there is {found[1].name} too, and either may be this camera's")
    return found[0] if found else None
