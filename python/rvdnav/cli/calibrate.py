"""``rvdnav calibrate``: pictures of a board in, the rig's files and a report out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from rvdnav.calibration import Board, Calibration, CalibrationError, Dropped, calibrate, read_pairs
from rvdnav.calibration.board import parse_corners, parse_length
from rvdnav.calibration.calibrate import SQUARE_SIGMA
from rvdnav.calibration.opencv_file import OPENCV_FILE, save_opencv
from rvdnav.calibration.page import verdict, verdict_sentence, write_calibration
from rvdnav.cli.terminal import console, errors, print_note
from rvdnav.errors import InputError, one_line
from rvdnav.output import staged_directory, staged_report
from rvdnav.rig import save_rig

REPORT = "calibration.html"
_DICTIONARY = "5X5_100"
_BASELINE_TOLERANCE = 0.02
_STRETCH_WORTH_TELLING = 1e-3
_CORRELATION_WORTH_TELLING = 3.0


def calibrate_folder(
    path: Path,
    corners: str,
    square: str,
    out: Path,
    *,
    marker: str | None = None,
    dictionary: str | None = None,
    baseline: str | None = None,
) -> int:
    """Calibrate from the pictures at ``path`` into ``out``; the board as on the command line.  Returns 0.

    Raises InputError, having told which views were dropped, when the pictures give no calibration.
    """
    board = _board(corners, square, marker, dictionary)
    expected = None if baseline is None else parse_length("--baseline", baseline)
    notices: list[str] = []
    pairs = read_pairs(path, notices)
    try:
        with _progress() as progress:
            calibration = calibrate(pairs, board, progress)
    except CalibrationError as error:
        _tell_dropped(error.dropped)
        raise InputError(f"{path}: {error}") from error
    _tell_dropped(calibration.dropped)
    if expected is not None:
        _check_baseline(path, calibration, expected)
    for notice in notices + _notices(calibration):
        print_note(notice)
    try:
        judged = verdict(calibration)
    except ValueError as error:  # a lens about to fold, for example
        raise InputError(f"{path}: nothing can be said of what the rig is worth: {error}") from error
    with staged_directory(out) as staging:
        save_rig(calibration.rig, staging)
        save_opencv(calibration.rig, staging / OPENCV_FILE)
    _print_result(calibration)
    console.print(verdict_sentence(calibration, judged), soft_wrap=True)
    for view in judged.suggested[:1]:
        console.print(f"the next picture would help most {view.description}", soft_wrap=True)
    with staged_report(out, REPORT) as page:
        write_calibration(page, one_line(path.resolve().name), calibration, judged)
    console.print(f"report: {out / REPORT}", soft_wrap=True)
    return 0


def _board(corners: str, square: str, marker: str | None, dictionary: str | None) -> Board:
    columns, rows = parse_corners(corners)
    if dictionary is not None and marker is None:
        raise InputError("--dictionary: is for a ChArUco board, whose --marker size is not given")
    name = (dictionary or _DICTIONARY).upper().removeprefix("DICT_")
    side = None if marker is None else parse_length("--marker", marker)
    try:
        return Board(columns, rows, parse_length("--square", square), side, name)
    except ValueError as error:
        raise InputError(f"--board {corners}: {error}") from error


@contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """Tells on a terminal which view was searched last."""
    if not errors.is_terminal:
        yield lambda name: None
        return
    columns = (SpinnerColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=errors, transient=True) as bar:
        task = bar.add_task("reading the first view")
        yield lambda name: bar.update(task, description=f"view {name} searched")


def _tell_dropped(dropped: tuple[Dropped, ...]) -> None:
    for view in dropped:
        print_note(f"view {view.name} dropped: {view.reason}")


def _check_baseline(path: Path, calibration: Calibration, expected: float) -> None:
    ratio = calibration.rig.baseline / expected
    if abs(ratio - 1.0) > _BASELINE_TOLERANCE:
        square = calibration.board.square * 1e3
        raise InputError(
            f"{path}: the baseline comes out as {calibration.rig.baseline * 1e3:.2f} mm, not {expected * 1e3:.2f} mm; "
            f"squares of {square / ratio:.3f} mm instead of {square:.3f} mm would explain it"
        )


def _notices(calibration: Calibration) -> list[str]:
    notices = []
    if abs(calibration.stretch) > max(3.0 * calibration.sigma_stretch, _STRETCH_WORTH_TELLING):
        wider = "wider than high" if calibration.stretch > 0.0 else "higher than wide"
        share, sigma = 100.0 * abs(calibration.stretch), 100.0 * calibration.sigma_stretch
        notices.append(f"the board's squares look {share:.2f} % ± {sigma:.2f} {wider}: is it printed true to scale?")
    if calibration.adjustment.correlation > _CORRELATION_WORTH_TELLING:
        factor = np.sqrt(calibration.adjustment.correlation)
        notices.append(
            f"the errors of a view's corners go together, which makes every sigma {factor:.1f} times as large: "
            "is the board flat?"
        )
    return notices


def _print_result(calibration: Calibration) -> None:
    adjustment, rig = calibration.adjustment, calibration.rig
    table = Table(title="Calibration", title_justify="left")
    table.add_column()
    for heading in ("left", "right"):
        table.add_column(heading, justify="right")
    covariance = rig.calibration_covariance
    assert covariance is not None
    sigmas = np.sqrt(np.diag(covariance))
    own = sigmas[:16].reshape(2, 8)
    values = np.array([[c.fx, c.fy, c.cx, c.cy, *c.distortion] for c in rig.cameras])
    for index, name in enumerate(("fx, px", "fy, px", "cx, px", "cy, px", "k1", "k2", "p1", "p2")):
        digits = 2 if index < 4 else 5
        cells = [f"{values[i, index]:.{digits}f} ± {own[i, index]:.{digits}f}" for i in range(2)]
        table.add_row(name, *cells)
    console.print(table)
    t = adjustment.model.T_cam1_cam0[:3, 3]
    sigma_baseline = float(np.sqrt(t @ covariance[-3:, -3:] @ t)) / rig.baseline
    console.print(
        f"baseline: {rig.baseline * 1e3:.3f} ± {sigma_baseline * 1e3:.3f} mm, "
        f"of it {100.0 * SQUARE_SIGMA:g} % for the size of the squares"
    )
    used = len(calibration.views)
    console.print(f"views: {used} used, {len(calibration.dropped)} dropped; RMS {adjustment.rms_px:.3f} px")
