"""``rvdnav info``: what a sequence, a rig or a target file holds, as it was understood."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from rich.table import Table

from rvdnav.cli.options import Source
from rvdnav.cli.tables import size_text
from rvdnav.cli.terminal import console, print_notes
from rvdnav.errors import InputError
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.recording import is_recording
from rvdnav.rig import CAMCHAIN, RIG, Rig, load_rig
from rvdnav.sequence import Sequence, open_sequence
from rvdnav.summary import calibration_knowledge, points_knowledge
from rvdnav.target import Target, load_target
from rvdnav.yamlio import read_yaml


def info(path: Path, source: Source) -> int:
    """Tell what is at ``path``: a sequence, the folder of a rig, or one of their files.  Raises InputError."""
    notices: list[str] = []
    if is_recording(path) or any(value is not None for value in source.values()):
        notices += _print_sequence(open_sequence(path, **source))
    elif not os.path.isdir(path):
        if not os.path.exists(path):
            raise InputError(f"{path}: no such file or folder")
        if path.name in (CAMCHAIN, RIG):
            _print_rig(load_rig(path.parent, notices))
        elif "points" in read_yaml(path):
            _print_target(load_target(path))
        else:
            raise InputError(f"{path}: neither a {CAMCHAIN}, a {RIG} nor a target")
    else:
        _print_rig(load_rig(path, notices))
        if os.path.lexists(path / "target.yaml"):
            _print_target(load_target(path / "target.yaml"))
    print_notes(notices)
    return 0


def _table(title: str) -> Table:
    table = Table(show_header=False, title=title, title_justify="left")
    table.add_column(style="bold")
    table.add_column()
    return table


def _print_sequence(sequence: Sequence) -> list[str]:
    """Prints it, its rig and target; returns what a user should know."""
    stamps = np.array(sequence.timestamps_ns)
    table = _table("Sequence")
    table.add_row("frames", str(len(stamps)))
    if len(stamps) > 1:
        steps = np.diff(stamps) * 1e-9
        table.add_row("time", f"{1e-9 * (stamps[-1] - stamps[0]):.3f} s from {stamps[0]} ns")
        table.add_row("rate", f"{1.0 / np.median(steps):.4g} frames/s; longest gap {steps.max():.3g} s")
    truth = sequence.truth
    if truth is not None:
        known = sum(truth.at(int(stamp)) is not None for stamp in stamps)
        table.add_row("true poses", f"of {known} of {len(stamps)} frames")
    console.print(table)
    _print_rig(sequence.rig)
    _print_target(sequence.target)
    rate = NavigatorSettings().rate_notice(sequence.timestamps_ns)
    return sequence.notices + ([] if rate is None else [rate])


def _print_rig(rig: Rig) -> None:
    table = _table("Rig")
    for index, camera in enumerate(rig.cameras):
        width, height = (
            np.degrees(2.0 * np.arctan(0.5 * side / focal))
            for side, focal in ((camera.width, camera.fx), (camera.height, camera.fy))
        )
        table.add_row(f"cam{index}", f"{camera.width} x {camera.height} px, {width:.1f} x {height:.1f} deg")
        table.add_row("  focal lengths", f"{camera.fx:.2f}, {camera.fy:.2f} px")
        table.add_row("  principal point", f"{camera.cx:.2f}, {camera.cy:.2f} px")
        table.add_row("  k1, k2, p1, p2", ", ".join(f"{k:.4g}" for k in camera.distortion))
    if rig.is_stereo:
        R = rig.T_world_cam[0][:3, :3].T @ rig.T_world_cam[1][:3, :3]
        turn = np.degrees(np.arccos(np.clip((np.trace(R) - 1.0) / 2.0, -1.0, 1.0)))
        table.add_row("baseline", f"{1e3 * rig.baseline:.2f} mm; turned by {turn:.3f} deg against each other")
    table.add_row("known", calibration_knowledge(rig))
    if rig.line_delay_ns or rig.exposure_ns or rig.scan != "progressive":
        table.add_row("scan", f"{rig.scan}, {rig.exposure_ns} ns exposure, {rig.line_delay_ns} ns from row to row")
    console.print(table)


def _print_target(target: Target) -> None:
    table = _table("Target")
    table.add_row("name", target.name)
    table.add_row("kind", "four-bar bracket" if target.bracket is not None else "straight edges; needs --initial-pose")
    if target.dimensions_known:
        table.add_row("size", size_text(target))
    parts = (len(target.points), 2 * len(target.bars) + len(target.edges), len(target.faces))
    table.add_row("points, edges, faces", ", ".join(map(str, parts)))
    table.add_row("known", points_knowledge(target))
    console.print(table)
