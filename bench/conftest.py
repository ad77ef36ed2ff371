"""The stereo frames that everything is timed on."""

from __future__ import annotations

from pathlib import Path

import pytest
from rvdnav import Frame, Sequence, open_sequence


@pytest.fixture(scope="session")
def sequence() -> Sequence:
    """The example: 704x576 stereo frames of an approach, with its truth."""
    return open_sequence(Path(__file__).resolve().parents[1] / "examples" / "approach")


@pytest.fixture(scope="session")
def frames(sequence: Sequence) -> list[Frame]:
    """All of its frames, decoded."""
    return list(sequence)
