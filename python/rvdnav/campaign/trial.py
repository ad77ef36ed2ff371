"""One trial: a navigator over one source with its faults, frame by frame into rows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import attrs
import numpy as np

from rvdnav.campaign.plan import Source, Trial
from rvdnav.campaign.store import is_stored, store_rows
from rvdnav.evaluation import is_wrong, pose_error
from rvdnav.faults import FaultySequence
from rvdnav.navigator import Navigator
from rvdnav.sequence import Sequence, open_sequence
from rvdnav.solution import TOTAL, Solution


def sequence_folder(source: Source, out: Path) -> Path:
    """Where the source's images are, or will be once rendered, in the campaign's folder."""
    return source.path if source.seed is None else out / "sequences" / source.name


def prepare(source: Source, out: Path) -> None:
    """Render the source's scenario unless that is done.  Raises InputError."""
    if source.seed is None:
        return
    from rvdnav.simulation import load_scenario, simulate  # needs an extra that recorded sequences do without

    folder = sequence_folder(source, out)
    folder.parent.mkdir(parents=True, exist_ok=True)
    simulate(attrs.evolve(load_scenario(source.path), seed=source.seed), folder)


def run_trial(trial: Trial, out: Path) -> str:
    """Run a trial and store its rows in the campaign's folder, unless they are there; returns its key.

    Run twice, or at once on two machines that share the folder, it leaves the same file.  Raises InputError.
    """
    if not is_stored(out, trial.key):
        sequence = open_sequence(sequence_folder(trial.source, out))
        faults = trial.parsed_faults()
        if faults:
            sequence = FaultySequence(sequence, faults, seed=trial.seed)
        store_rows(out, trial.key, _rows(trial, sequence))
    return trial.key


def _rows(trial: Trial, sequence: Sequence) -> list[dict[str, Any]]:
    navigator = Navigator(sequence.rig, sequence.target)
    rows = []
    for frame in sequence:
        solution = navigator.process(frame)
        head = {
            "trial": trial.key,
            "source": trial.source.name,
            "fault": trial.faults,
            "seed": trial.seed,
            "timestamp_ns": solution.timestamp_ns,
        }
        truth = None if sequence.truth is None else sequence.truth.at(solution.timestamp_ns)
        rows.append(head | _judged(solution, truth))
    return rows


def _judged(solution: Solution, truth: Any) -> dict[str, Any]:
    """What came of a frame; what needs a true pose or a published one is None without it."""
    row: dict[str, Any] = {
        "state": solution.state.name,
        "mode": None if solution.mode is None else solution.mode.name,
        "reasons": " ".join(sorted(reason.name for reason in solution.reasons)),
        "published": solution.published,
        "range_m": None if truth is None else float(np.linalg.norm(truth[:3, 3])),
        "position_error_m": None,
        "attitude_error_rad": None,
        "nees": None,
        "wrong": None,
        "seconds": solution.stage_times.get(TOTAL),
    }
    if truth is None or solution.T_world_target is None or solution.covariance is None:
        return row
    error = pose_error(solution.T_world_target, truth)
    position, attitude = float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))
    row["position_error_m"], row["attitude_error_rad"] = position, attitude
    row["nees"] = float(error @ np.linalg.solve(solution.covariance, error))
    row["wrong"] = bool(is_wrong(*np.array([[position], [attitude], [row["range_m"]]])).item())
    return row
