"""``rvdnav replay``: a black box gone through again."""

from __future__ import annotations

from pathlib import Path

from rvdnav.blackbox import replay
from rvdnav.cli.terminal import console


def replay_folder(folder: Path) -> int:
    """Compare every solution with the recorded one; 0 if all have the same bits, else 1.  Raises InputError."""
    result = replay(folder)
    if result.difference is None:
        console.print(f"{result.frames} frames replayed, identical")
        return 0
    found = result.difference
    console.print(f"frame {found.index} at {found.timestamp_ns} ns differs in {found.field}:", soft_wrap=True)
    console.print(f"  recorded {found.recorded}", soft_wrap=True)
    console.print(f"  replayed {found.replayed}", soft_wrap=True)
    for note in result.notes:
        console.print(note, soft_wrap=True)
    return 1
