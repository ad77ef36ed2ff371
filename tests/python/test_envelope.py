"""The measurement of the envelope: where its table goes."""

from __future__ import annotations

from pathlib import Path

import envelope
import pytest
from rvdnav.errors import InputError

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "approach"
ARGUMENTS = [str(EXAMPLE), "--every", "12", "--only", "^exact$", "--jobs", "1"]
ROW = "| exact | approach | 100 % of 2 | 0 |"


def test_the_table_begins_a_page_or_takes_the_old_ones_place(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    envelope.main([*ARGUMENTS, "--out", str(page)])
    fresh = page.read_text()
    mark, _, _, row = fresh.splitlines()
    assert mark == envelope.MARK.strip()
    assert row.startswith(ROW)
    page.write_text(f"# Before\n\n{envelope.MARK}| old |\n|---|\n\nAfter.\n")
    envelope.main([*ARGUMENTS, "--out", str(page)])
    assert page.read_text() == f"# Before\n\n{fresh.rstrip()}\n\nAfter.\n"


def test_a_page_that_has_no_place_for_the_table_is_left_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.md"
    page.write_text("mine\n")
    with pytest.raises(InputError, match=f"{page}: has no line {envelope.MARK.strip()}"):
        envelope.main([*ARGUMENTS, "--out", str(page)])
    assert page.read_text() == "mine\n"
    assert capsys.readouterr().out == ""  # nothing was measured in vain
