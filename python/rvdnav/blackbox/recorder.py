"""Keeps what led to the present solution, and writes it down when the target is lost."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from rvdnav.blackbox.folder import Moment, Origin, write_black_box
from rvdnav.images import Image
from rvdnav.navigator import Navigator
from rvdnav.rig import Rig
from rvdnav.sequence import Frame
from rvdnav.solution import Solution, State
from rvdnav.target import Target

DEFAULT_FRAMES = 64
"""Coasting for its 2 s takes 16 frames at 8 frames/s and 40 at 20: this leaves 24 from before the trouble.  52 MB at
704 x 576."""


class Recorder:
    """A navigator with a black box: use `process` in place of the navigator's.

    navigator: made of rig, target and options, and given its frames by the recorder alone.  It holds copies of the
    images of the last ``frames`` frames, both stamps, the navigator's memory and the solutions.  directory: where a
    folder named by the frame's timestamp, ns, is written whenever the target is lost; None for never.  A frame is
    written so at most once: a later loss is told from the frame after the one before.

    Raises ValueError unless ``frames`` is positive.
    """

    def __init__(
        self,
        navigator: Navigator,
        rig: Rig,
        target: Target,
        options: Mapping[str, Any] | None = None,
        *,
        directory: Path | None = None,
        frames: int = DEFAULT_FRAMES,
    ) -> None:
        if frames < 1:
            raise ValueError(f"a black box holds at least one frame, not {frames}")
        self._navigator = navigator
        self._origin = Origin(rig, target, dict(options or {}))
        self._directory = directory
        self._moments: deque[Moment] = deque(maxlen=frames)

    def __len__(self) -> int:
        """Frames held."""
        return len(self._moments)

    def process(self, frame: Frame) -> Solution:
        """The navigator's solution of the next frame.

        Raises what the navigator raises; like the navigator it then is as if the frame had not been.  Raises InputError
        when the target is lost and the folder cannot be written.
        """
        memory = self._navigator.memory
        kept = attrs.evolve(frame, left=_copied(frame.left), right=_copied(frame.right))
        solution = self._navigator.process(frame)
        self._moments.append(Moment(memory, kept, solution))
        if solution.state is State.LOST and self._directory is not None:
            self.write(self._directory / str(solution.timestamp_ns))
            self._moments.clear()
        return solution

    def write(self, folder: str | Path) -> None:
        """Write all frames held into a folder, whole or not at all, in place of an older black box there.

        Raises ValueError when no frame is held, InputError when the folder cannot be written or holds something else.
        """
        if not self._moments:
            raise ValueError("the black box holds no frames")
        write_black_box(Path(folder), self._origin, tuple(self._moments))


def _copied(image: Image | None) -> Image | None:
    """The image in memory of its own: the caller may use its buffer again."""
    return None if image is None else attrs.evolve(image, pixels=image.pixels.copy())
