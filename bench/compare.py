"""Two records of `rvdnav bench --json` side by side; exit code 1 where a ratio to Canny has grown too much.

    python bench/compare.py BEFORE.json AFTER.json [--allow PERCENT]

Wall times of two runs say little of the code; their ratios to Canny, timed by turns in each run, do.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rvdnav.errors import InputError
from rvdnav.jsonio import parse_object

# Of the machine's record: what must agree, for another processor has other ratios.
SAME = ("processor", "image", "isa")


def read(path: Path) -> dict[str, Any]:
    """The record in a file.  Raises InputError for one that holds none."""
    try:
        record = parse_object(path.read_text())
        ratios = {name: float(times["ratio"]) for name, times in record["times"].items()}
        return {"machine": {key: record["machine"][key] for key in SAME}, "ratios": ratios}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: no record of rvdnav bench: {error}") from error


def regressions(before: dict[str, float], after: dict[str, float], allowed: float) -> list[str]:
    """What has come to take more than (1 + allowed) times as much of Canny's time, or is timed no longer."""
    return [name for name, ratio in before.items() if after.get(name, float("inf")) > (1.0 + allowed) * ratio]


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before", type=Path)
    parser.add_argument("after", type=Path)
    parser.add_argument("--allow", type=float, default=10.0, metavar="PERCENT")
    arguments = parser.parse_args()
    try:
        before, after = read(arguments.before), read(arguments.after)
    except InputError as error:
        parser.error(str(error))
    if before["machine"] != after["machine"]:
        parser.error(f"the records are of {json.dumps(before['machine'])} and {json.dumps(after['machine'])}")
    slower = regressions(before["ratios"], after["ratios"], arguments.allow / 100.0)
    table = Table("", "before", "after", "change")
    for name, ratio in before["ratios"].items():
        now = after["ratios"].get(name)
        change = "gone" if now is None else f"{100.0 * (now / ratio - 1.0):+.0f} %"
        table.add_row(
            name, f"{ratio:.3f}", "-" if now is None else f"{now:.3f}", change, style="red" * (name in slower)
        )
    Console(highlight=False).print(table)
    raise SystemExit(1 if slower else 0)


if __name__ == "__main__":
    main()
