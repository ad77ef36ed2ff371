"""A fault: its name and the frames that it strikes, as a user writes them."""

from __future__ import annotations

import re

import attrs

from rvdnav.errors import InputError
from rvdnav.faults.catalog import CALIBRATION_FAULTS, FAULT_NAMES


@attrs.frozen
class Fault:
    """A named fault and the numbers of the recorded frames, from 0, that it strikes; None for all of them."""

    name: str
    frames: tuple[range, ...] | None = None

    def strikes(self, index: int) -> bool:
        """Whether the frame of that number is struck."""
        return self.frames is None or any(index in frames for frames in self.frames)


def parse_fault(text: str) -> Fault:
    """The fault of ``NAME:FRAMES``, FRAMES being ``all`` or numbers and ranges such as ``10-14,20``, ends included.

    Raises InputError for an unknown name, for anything else in place of the frames, and for a fault of the calibration
    that is not to hold in all frames.
    """
    name, colon, frames = text.partition(":")
    if name not in FAULT_NAMES:
        raise InputError(f"fault {text!r}: there is no fault {name!r}; there are {', '.join(FAULT_NAMES)}")
    if not colon:
        raise InputError(f"fault {text!r}: no frames; write {name}:all or {name}:10-14,20")
    if frames == "all":
        return Fault(name)
    if name in CALIBRATION_FAULTS:
        raise InputError(f"fault {text!r}: a calibration is wrong in all frames; write {name}:all")
    return Fault(name, tuple(_range(text, part) for part in frames.split(",")))


def _range(text: str, part: str) -> range:
    match = re.fullmatch(r"([0-9]{1,9})(?:-([0-9]{1,9}))?", part)
    if match is None:
        raise InputError(f"fault {text!r}: {part!r} is no frame number and no range such as 10-14")
    first = int(match[1])
    last = first if match[2] is None else int(match[2])
    if last < first:
        raise InputError(f"fault {text!r}: the range {part} ends before it begins")
    return range(first, last + 1)
