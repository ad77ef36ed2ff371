"""``rvdnav simulate``: a scenario in, a sequence folder out."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from rvdnav.cli.terminal import console, errors, progress_bars
from rvdnav.simulation import load_scenario, simulate


def render(path: Path, out: Path) -> int:
    """Render the scenario at ``path`` into the folder ``out``.  Raises InputError."""
    scenario = load_scenario(path)
    try:
        with progress_bars() as tell:
            made = simulate(scenario, out, progress=partial(tell, "images"))
    except KeyboardInterrupt:
        errors.print("rvdnav: interrupted; the same command goes on from here", soft_wrap=True)
        raise
    note = f"{scenario.frames} frames" if made else "complete already"
    console.print(f"sequence: {out} ({note})", soft_wrap=True)
    return 0
