"""A fault: its name, its strength and the frames that it strikes, as a user writes them."""

from __future__ import annotations

import re

import attrs

from rvdnav.errors import InputError
from rvdnav.faults.catalog import FAULT_NAMES, KNOWLEDGE_FAULTS, STRENGTHS
from rvdnav.faults.strength import parse_strengths


@attrs.frozen
class Fault:
    """A named fault and the numbers of the recorded frames, from 0, that it strikes; None for all of them.

    strength: the numbers that its name's entry in the table of docs/faults.md asks for.
    """

    name: str
    frames: tuple[range, ...] | None = None
    strength: tuple[float, ...] = ()

    def strikes(self, index: int) -> bool:
        """Whether the frame of that number is struck."""
        return self.frames is None or any(index in frames for frames in self.frames)

    @property
    def label(self) -> str:
        """Name and strength, as a user writes them."""
        return f"{self.name}={','.join(f'{value:g}' for value in self.strength)}" if self.strength else self.name


def parse_fault(text: str) -> Fault:
    """The fault of ``NAME:FRAMES`` or ``NAME=STRENGTH:FRAMES``.

    STRENGTH: numbers joined by commas.  FRAMES: ``all``, or numbers and ranges such as ``10-14,20``, ends included.
    Raises InputError for an unknown name, a strength that is missing or beyond its limits, anything else in place of
    the frames, and for a fault of what the navigator is told that is not to hold in all frames.
    """
    label, colon, frames = text.partition(":")
    name, equals, given = label.partition("=")
    if name not in FAULT_NAMES:
        raise InputError(f"fault {text!r}: there is no fault {name!r}; there are {', '.join(FAULT_NAMES)}")
    try:
        strength = parse_strengths(given if equals else None, STRENGTHS.get(name, ()))
    except InputError as error:
        raise InputError(f"fault {text!r}: {error}") from error
    if not colon:
        raise InputError(f"fault {text!r}: no frames; write {label}:all or {label}:10-14,20")
    if frames == "all":
        return Fault(name, strength=strength)
    if name in KNOWLEDGE_FAULTS:
        raise InputError(f"fault {text!r}: what a navigator is told is wrong in all frames; write {label}:all")
    return Fault(name, tuple(_range(text, part) for part in frames.split(",")), strength)


def _range(text: str, part: str) -> range:
    match = re.fullmatch(r"([0-9]{1,9})(?:-([0-9]{1,9}))?", part)
    if match is None:
        raise InputError(f"fault {text!r}: {part!r} is no frame number and no range such as 10-14")
    first = int(match[1])
    last = first if match[2] is None else int(match[2])
    if last < first:
        raise InputError(f"fault {text!r}: the range {part} ends before it begins")
    return range(first, last + 1)
