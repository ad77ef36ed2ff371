"""``rvdnav run``: a sequence in, poses, solutions and a report out."""

from __future__ import annotations

import shutil
from functools import partial
from pathlib import Path
from typing import Any

from rvdnav import Navigator, __version__, open_sequence
from rvdnav.blackbox import Recorder
from rvdnav.cli.blackboxes import BLACK_BOXES, black_boxes
from rvdnav.cli.options import Source
from rvdnav.cli.source import other_files, source_words
from rvdnav.cli.tables import print_responses, print_summary
from rvdnav.cli.terminal import console, print_note, print_notes, progress_bars
from rvdnav.core import Core
from rvdnav.errors import CoreError, InputError
from rvdnav.evaluation import Evaluation, evaluate
from rvdnav.faults import FaultySequence, parse_fault
from rvdnav.jsonio import write_json
from rvdnav.navigator import parse_pose
from rvdnav.navigator.options import NavigatorOptions
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.output import SMOOTHED, staged_directory, staged_report, write_smoothed, write_solutions
from rvdnav.report import Picture, draw_picture, edge_mask, notable_frames, provenance, write_report
from rvdnav.sequence import Sequence
from rvdnav.solution import Solution
from rvdnav.summary import calibration_knowledge, points_knowledge, run_record
from rvdnav.target import Target

REPORT = "report.html"


def run(
    path: Path,
    out: Path,
    faults: list[str],
    initial_pose: str | None = None,
    smoothed: bool = False,
    *,
    source: Source | None = None,
    options: NavigatorOptions | None = None,
    least_published: float | None = None,
    json_path: Path | None = None,
) -> int:
    """Process the sequence at ``path`` into ``out``, with the faults that `parse_fault` understands.

    source: what the recording doesn't say itself.
    initial_pose: T_world_target at the first frame as "tx ty tz qx qy qz qw".
    smoothed: write the filtered poses as well.  json_path: where to write the summary as well.

    Returns 0 if that many per cent of the frames were published, any at all by default, else 1.  Raises InputError.
    """
    settings: NavigatorOptions = {} if options is None else options
    source = Source() if source is None else source
    given: dict[str, Any] = dict(settings)
    if initial_pose is not None:
        given["initial_pose"] = parse_pose(initial_pose)
    injected = [parse_fault(fault) for fault in faults]
    sequence = FaultySequence(open_sequence(path, **source), injected)
    if not len(sequence):
        raise InputError(f"{path}: holds no frames")
    with staged_directory(out) as staging:
        solutions, target = _process(sequence, given, staging / BLACK_BOXES)
        boxes = black_boxes(staging, solutions)
        write_solutions(staging, solutions)
        if smoothed:
            write_smoothed(staging, solutions)
    # What an earlier run left in the same folder and this one did not write.
    if not boxes:
        shutil.rmtree(out / BLACK_BOXES, ignore_errors=True)
    if not smoothed:
        (out / SMOOTHED).unlink(missing_ok=True)
    evaluation = _evaluation(sequence, solutions)
    print_summary(solutions, evaluation, target)
    console.print(_taken_for_known(sequence), soft_wrap=True)
    if injected:
        print_responses([(fault, sequence.response(fault, solutions)) for fault in injected], evaluation)
    for timestamp_ns, folder in boxes.items():
        seconds = (timestamp_ns - solutions[0].timestamp_ns) * 1e-9
        console.print(f"target lost at {seconds:.3f} s: rvdnav replay {out / folder}", soft_wrap=True)
    with staged_report(out, REPORT) as page:
        write_report(
            page,
            f"Run over {path.resolve().name}",
            solutions,
            truth=sequence.truth,
            evaluation=evaluation,
            pictures=_pictures(sequence, target, solutions, evaluation),
            black_boxes=boxes,
            facts=[
                *provenance(
                    _command(path, faults, initial_pose, smoothed, settings, source), path, other_files(source)
                ),
                ("target", f"{target.name}: {points_knowledge(target)}"),
                ("rig", calibration_knowledge(sequence.rig)),
            ],
        )
    console.print(f"report: {out / REPORT}", soft_wrap=True)
    record = run_record(solutions)
    if json_path is not None:
        judged = None if evaluation is None else evaluation.to_json()
        about = {"rvdnav": __version__, "sequence": path.resolve().name, "settings": settings, "faults": faults}
        write_json(json_path, about | record | {"errors": judged})
    if least_published is None:
        return 0 if record["published"] else 1
    if 100 * record["published"] >= least_published * len(solutions):
        return 0
    print_note(f"fewer than {least_published:g} % of the frames were published")
    return 1


def _process(sequence: Sequence, options: dict[str, Any], directory: Path) -> tuple[list[Solution], Target]:
    """The solutions, and the target with the dimensions that were learnt where they were unknown."""
    try:
        navigator = Navigator(sequence.rig, sequence.target, **options)
    except (ValueError, CoreError) as error:  # settings that don't go together, or not with this processor
        raise InputError(f"the settings are of no use here: {error}") from error
    recorder = Recorder(navigator, sequence.rig, sequence.target, options, directory=directory)
    solutions: list[Solution] = []
    rate = NavigatorSettings().rate_notice(sequence.timestamps_ns)
    if rate is not None:
        print_note(rate)
    with progress_bars() as tell:
        for frame in sequence:
            solutions.append(recorder.process(frame))
            tell("frames", len(solutions), len(sequence))
    print_notes(sequence.notices)
    return solutions, navigator.learned_target or sequence.target


def _taken_for_known(sequence: Sequence) -> str:
    """To what the target and the calibration were taken to be known, and whether their files said so."""
    return f"taken for known: {points_knowledge(sequence.target)}, {calibration_knowledge(sequence.rig)}"


def _evaluation(sequence: Sequence, solutions: list[Solution]) -> Evaluation | None:
    truth = sequence.truth
    if truth is None:
        return None
    if all(truth.at(solution.timestamp_ns) is None for solution in solutions):
        off = truth.nearest_ns(solution.timestamp_ns for solution in solutions)
        nearest = "holds no poses" if off is None else f"the nearest is {off / 1e6:.4g} ms off"
        print_note(f"groundtruth.tum: no frame has a true pose within 1 us: {nearest}")
        return None
    return evaluate(solutions, truth)


def _command(
    path: Path,
    faults: list[str],
    initial_pose: str | None,
    smoothed: bool,
    settings: NavigatorOptions,
    source: Source,
) -> list[str]:
    """The words of a command that gives the same results, wherever they are put."""
    words = ["run", path.resolve().name, *source_words(source)]
    words += [word for fault in faults for word in ("--fault", fault)]
    words += [word for name, value in settings.items() for word in ("--set", f"{name}={value}")]
    words += [] if initial_pose is None else ["--initial-pose", initial_pose]
    return [*words, "--smoothed"] if smoothed else words


def _pictures(
    sequence: Sequence, target: Target, solutions: list[Solution], evaluation: Evaluation | None
) -> list[Picture]:
    edges = partial(edge_mask, Core(sequence.rig, target))
    drawn = [
        draw_picture(sequence[index], solutions[index], sequence.rig, target, edges, why)
        for index, why in notable_frames(solutions, evaluation).items()
    ]
    return [picture for picture in drawn if picture is not None]
