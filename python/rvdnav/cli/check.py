"""``rvdnav calibrate check``: is the rig of a flown sequence still true?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from rich.table import Table

from rvdnav.calibration.check import RigCheck, check_rig
from rvdnav.cli.tables import print_reasons
from rvdnav.cli.terminal import console
from rvdnav.errors import CoreError, InputError
from rvdnav.sequence import open_sequence


def check(path: Path) -> int:
    """Check the rig of the sequence at ``path``; 0 if it is true, 1 if it should be calibrated again.

    Raises InputError.
    """
    sequence = open_sequence(path)
    try:
        result = check_rig(sequence)
    except (ValueError, CoreError) as error:
        raise InputError(f"{path}: its rig cannot be checked: {error}") from error
    _print(result)
    return 1 if result.due else 0


def _print(result: RigCheck) -> None:
    table = Table(show_header=False, title="Rig", title_justify="left")
    table.add_column(style="bold")
    table.add_column(justify="right")
    table.add_row("frames measured", f"{result.frames} of {result.looked_at}")
    if result.looked_at < result.sequence_frames:
        table.add_row("", f"looked at, spread over all {result.sequence_frames}")
    rows = result.epipolar_px
    table.add_row("epipolar residual, median / RMS", f"{np.median(rows):+.3f} / {np.sqrt(np.mean(rows**2)):.3f} px")
    errors = 100.0 * result.length_errors
    table.add_row(
        "bracket's lengths, median / RMS error", f"{np.median(errors):+.3f} / {np.sqrt(np.mean(errors**2)):.3f} %"
    )
    sigmas = np.degrees(np.sqrt(np.diag(result.covariance)))
    for axis, turn, sigma in zip(("right", "down", "forward"), np.degrees(result.turn), sigmas, strict=True):
        table.add_row(f"turn about the right camera's {axis} axis", f"{turn:+.4f} ± {sigma:.4f} deg")
    console.print(table)
    print_reasons(
        f"Why {result.looked_at - result.frames} of {result.looked_at} frames were not measured", result.refused
    )
    chi2 = f"chi-squared {result.chi2:.1f} of 3 degrees of freedom, limit {result.limit:.1f}"
    if result.due:
        angle = float(np.degrees(np.linalg.norm(result.turn)))
        verdict = f"re-calibration is due: the cameras have turned by {angle:.3f} deg against each other"
    else:
        verdict = "the rig is true within what the sequence can tell"
    console.print(f"{verdict} ({chi2})", soft_wrap=True)
