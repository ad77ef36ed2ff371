"""Commands and exit codes: 0 done, 1 ran but no pose, 2 bad input with one clear line on stderr.

What a command works with is loaded when it runs, so that the program itself starts at once.
"""

from __future__ import annotations

import io
import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from types import FrameType
from typing import Annotated, Any, NoReturn, cast

import typer
from typer.core import TyperGroup

from rvdnav import __version__
from rvdnav.cli.options import Rate, RigPath, TargetPath, Topics, source
from rvdnav.errors import InputError, one_line

EXIT_BAD_INPUT = 2
EXIT_INTERRUPTED = 128 + signal.SIGINT
EXIT_TERMINATED = 128 + signal.SIGTERM

# Typer exports no base class of its usage errors, and the module that it lives in differs between Typer's versions.
_UsageError = cast("type[typer.BadParameter]", typer.BadParameter.__mro__[1])

_ORDER = (
    "run",
    "evaluate",
    "replay",
    "reconstruct",
    "calibrate",
    "simulate",
    "campaign",
    "experiment",
    "budget",
    "bench",
    "info",
    "settings",
)


class _Commands(TyperGroup):
    """The commands in the order of their use; Typer by itself puts groups last."""

    def list_commands(self, ctx: Any) -> list[str]:
        return sorted(super().list_commands(ctx), key=_ORDER.index)


app = typer.Typer(
    cls=_Commands,
    help="Stereo-vision navigation for spacecraft rendezvous and docking.",
    rich_markup_mode=None,
    context_settings={"max_content_width": 100},
)


class _Calibrate(TyperGroup):
    """A group whose first word may also be the folder: `calibrate FOLDER` stands for `calibrate images FOLDER`."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        if not args or (args[0] not in self.commands and args[0] != "--help"):
            args = ["images", *args]
        return list(super().parse_args(ctx, args))


calibrate_app = typer.Typer(
    cls=_Calibrate,
    help="Calibrate a stereo rig from pictures of a board: calibrate FOLDER --board 9x6 --square 25mm --out DIR; "
    "all options: calibrate images --help. Or tell whether a flown rig is still true: calibrate check SEQUENCE.",
    short_help="Calibrate a stereo rig from pictures of a board, or check a flown one.",
    rich_markup_mode=None,
    add_completion=False,
)
app.add_typer(calibrate_app, name="calibrate")


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"rvdnav {__version__}")
        raise typer.Exit()


@app.callback()
def _common(
    show_version: Annotated[
        bool, typer.Option("--version", help="Print the version and stop.", callback=_print_version, is_eager=True)
    ] = False,
) -> None:
    """Stereo-vision navigation for spacecraft rendezvous and docking."""


@app.command("run", short_help="Measure the target's pose in every frame of a sequence.")
def _run(
    sequence: Annotated[Path, typer.Argument(metavar="SEQUENCE", help="The recording; see docs/sequences.md.")],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the results.")],
    rate: Rate = None,
    topics: Topics = None,
    rig: RigPath = None,
    target: TargetPath = None,
    fault: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME[=STRENGTH]:FRAMES",
            help="Inject a fault, e.g. black_left:10-14,20 or blur=2.5:all; may be repeated.",
        ),
    ] = None,
    initial_pose: Annotated[
        str | None,
        typer.Option(metavar="POSE", help='T_world_target at the first frame: "tx ty tz qx qy qz qw", m.'),
    ] = None,
    smoothed: Annotated[bool, typer.Option("--smoothed", help="Write the filtered poses too: smoothed.tum.")] = False,
    setting: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="A setting; `rvdnav settings` prints them; may be repeated."),
    ] = None,
    settings: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Settings as a YAML mapping; --set overrides it.")
    ] = None,
    least_published: Annotated[
        float | None,
        typer.Option(
            "--least-published",
            min=0.0,
            max=100.0,
            metavar="%",
            help="Exit with 1 if fewer of the frames are published.",
        ),
    ] = None,
    json_path: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Also write the summary there.")
    ] = None,
) -> int:
    """Measure the target's pose in every frame: poses.tum, solutions.jsonl and report.html in DIR.

    Whenever the target is lost, the frames that led to it are kept in DIR/blackbox for the replay command."""
    from rvdnav.cli.run import run
    from rvdnav.cli.settings import chosen_settings

    options = chosen_settings(settings, setting or [])
    return run(
        sequence,
        out,
        fault or [],
        initial_pose,
        smoothed,
        source=source(rate, topics, rig, target),
        options=options,
        least_published=least_published,
        json_path=json_path,
    )


@app.command("info", short_help="Tell what a sequence, rig or target holds, with warnings.")
def _info(
    path: Annotated[
        Path, typer.Argument(metavar="PATH", help="Folder of a sequence, or a rig, camchain or target file.")
    ],
    rate: Rate = None,
    topics: Topics = None,
    rig: RigPath = None,
    target: TargetPath = None,
) -> int:
    """Tell what a sequence, rig or target file holds, in the units that it was understood in, with warnings."""
    from rvdnav.cli.info import info

    return info(path, source(rate, topics, rig, target))


@app.command("settings", short_help="Print every setting with its meaning, unit and range.")
def _settings(
    setting: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME=VALUE", help="As for run; may be repeated.")
    ] = None,
    settings: Annotated[Path | None, typer.Option(metavar="FILE", help="As for run.")] = None,
) -> int:
    """Print every setting with its meaning, unit and range, as a file that --settings takes."""
    from rvdnav.cli.settings import chosen_settings, print_settings

    print_settings(chosen_settings(settings, setting or []))
    return 0


@app.command("evaluate", short_help="Compare a run with the true poses.")
def _evaluate(
    sequence: Annotated[Path, typer.Argument(metavar="SEQUENCE", help="Folder of the sequence, with its truth.")],
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Folder with the results of a run over it.")],
    json_path: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Also write the figures there.")
    ] = None,
) -> int:
    """Compare a run with the true poses: a table, and evaluation.html in DIR."""
    from rvdnav.cli.evaluate import evaluate

    return evaluate(sequence, directory, json_path)


@app.command("simulate", short_help="Render a scenario into a sequence with its true poses.")
def _simulate(
    scenario: Annotated[Path, typer.Argument(metavar="SCENARIO", help="Scenario file (YAML).")],
    out: Annotated[Path, typer.Option("--out", metavar="SEQUENCE", help="Folder of the sequence to be made.")],
) -> int:
    """Render a scenario into a stereo sequence with its true poses; goes on where an interrupted run stopped."""
    from rvdnav.cli.simulate import render

    return render(scenario, out)


@app.command("reconstruct", short_help="Reconstruct the visible surface of one frame.")
def _reconstruct(
    sequence: Annotated[Path, typer.Argument(metavar="SEQUENCE", help="Folder of the stereo sequence.")],
    frame: Annotated[int, typer.Option("--frame", metavar="N", help="Number of the frame, 0 the first.")],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="Point cloud to write, a .ply file.")],
) -> int:
    """Reconstruct the visible surface of one frame: a point cloud FILE.ply with a sigma a point, and FILE.html."""
    from rvdnav.cli.reconstruct import reconstruct_frame

    return reconstruct_frame(sequence, frame, out)


@app.command("replay", short_help="Go through what led to a lost target again, to the same bits.")
def _replay(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Black box that a run wrote, DIR/blackbox/...")],
) -> int:
    """Go through a black box again and compare every solution to the last bit; exit code 1 if one differs."""
    from rvdnav.cli.replay import replay_folder

    return replay_folder(folder)


@app.command("budget", short_help="Tell how far the pose may err, from which causes, and what must improve.")
def _budget(
    path: Annotated[
        Path,
        typer.Argument(metavar="PATH", help="Sequence folder, or the camchain.yaml or rig.yaml beside target.yaml."),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for budget.html.")],
    target: Annotated[Path | None, typer.Option(metavar="FILE", help="Target file, where it lies elsewhere.")] = None,
    ranges: Annotated[str, typer.Option(metavar="M,M,...", help="Ranges, m.")] = "0.3,0.5,0.8,1.1,1.5",
    angles: Annotated[str, typer.Option(metavar="DEG,...", help="Viewing angles, degrees.")] = "0,15,30,45,60",
    at: Annotated[
        float | None, typer.Option(metavar="M", help="Range of --require and of the details; the largest by default.")
    ] = None,
    require: Annotated[
        list[str] | None,
        typer.Option(metavar="VALUE", help="Accuracy wanted (1 sigma), e.g. 1mm or 0.1deg; may be repeated."),
    ] = None,
    check: Annotated[
        bool, typer.Option("--check", help="Compare with a Monte Carlo simulation, which takes minutes.")
    ] = False,
    noise: Annotated[float, typer.Option(metavar="GREY", help="Noise of a pixel, grey levels.")] = 1.5,
    contrast: Annotated[float, typer.Option(metavar="GREY", help="Step at an edge, grey levels.")] = 100.0,
    displacement: Annotated[
        float, typer.Option(metavar="PX", help="Displacement of whole lines, offset and tilt, px.")
    ] = 0.02,
    tolerance: Annotated[
        float, typer.Option(metavar="MM", help="Tolerance of the target's corners, each coordinate, mm.")
    ] = 0.05,
    timing: Annotated[float, typer.Option(metavar="MS", help="Time between the two exposures, ms.")] = 0.1,
    speed: Annotated[
        float, typer.Option(metavar="M/S", help="Speed of the target relative to the cameras, m/s.")
    ] = 0.1,
) -> int:
    """Tell how far the pose may err, from which causes, and what must improve: tables, and budget.html in DIR."""
    from rvdnav.cli.budget import assume, budget

    assumptions = assume(noise, contrast, displacement, tolerance, timing, speed)
    return budget(
        path, out, target, assumptions, ranges=ranges, angles=angles, at=at, requirements=require or [], checked=check
    )


@app.command("bench", short_help="Time every stage and the whole frame.")
def _bench(
    sequence: Annotated[
        Path | None,
        typer.Argument(metavar="SEQUENCE", help="Folder of a stereo sequence; examples/approach by default."),
    ] = None,
    frames: Annotated[int, typer.Option(min=2, metavar="N", help="How many, shown forth and back.")] = 200,
    json_path: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Also write the figures and what ran them there.")
    ] = None,
) -> int:
    """Time the whole frame and every stage, by turns with what OpenCV does with the same images."""
    from rvdnav.cli.bench import bench

    return bench(sequence, frames, json_path)


@calibrate_app.command("images", short_help="Calibrate from pictures of a board; the word may be left out.")
def _calibrate(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder or OpenCV list of the pictures.")],
    board: Annotated[str, typer.Option(metavar="9x6", help="The board's inner corners.")],
    square: Annotated[str, typer.Option(metavar="25mm", help="Side of a square.")],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the results.")],
    marker: Annotated[str | None, typer.Option(metavar="18mm", help="Side of a marker: a ChArUco board.")] = None,
    dictionary: Annotated[
        str | None, typer.Option(metavar="NAME", help="Dictionary of the markers; 5X5_100 by default.")
    ] = None,
    baseline: Annotated[
        str | None, typer.Option(metavar="120mm", help="Distance of the cameras, if known: refuse what differs by 2 %.")
    ] = None,
) -> int:
    """Calibrate a stereo rig from pictures of a board: camchain.yaml, rig.yaml and calibration.html in DIR."""
    from rvdnav.cli.calibrate import calibrate_folder

    return calibrate_folder(folder, board, square, out, marker=marker, dictionary=dictionary, baseline=baseline)


@app.command("experiment", short_help="Repeat the paper's experiment and examine its claims.")
def _experiment(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Which experiment: paper is the only one.")],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="Folder for the report.")],
    run: Annotated[
        Path | None,
        typer.Option(
            "--run",
            metavar="PATH",
            help="Sequence with true poses, or scenario to render; examples/scenarios/paper.yaml by default.",
        ),
    ] = None,
) -> int:
    """Repeat the paper's experiment: its figures 9 to 14 and its claims about edges, in DIR/experiment.html."""
    from rvdnav.cli.experiment import experiment

    return experiment(name, run, out)


@app.command("campaign", short_help="Run many sequences with faults and seeds, on cores or a cluster.")
def _campaign(
    plan: Annotated[
        Path, typer.Argument(metavar="CAMPAIGN", help="Campaign file (YAML): sequences, scenarios, seeds, faults.")
    ],
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Folder for the results; goes on where it stopped.")
    ],
    backend: Annotated[str, typer.Option(metavar="NAME", help="local, dask or ray.")] = "local",
    scheduler: Annotated[
        str | None,
        typer.Option(
            metavar="ADDRESS", help="Of a running Dask or Ray cluster; without it one is started on this machine."
        ),
    ] = None,
    jobs: Annotated[int, typer.Option(metavar="N", help="Trials at once; -1: as many as there are cores.")] = -1,
) -> int:
    """Run many sequences with faults and seeds: results.parquet and campaign.html in DIR."""
    from rvdnav.cli.campaign import campaign

    return campaign(plan, out, backend, scheduler, jobs)


@calibrate_app.command("check", short_help="Tell from a flown sequence whether its rig is still true.")
def _check(
    sequence: Annotated[Path, typer.Argument(metavar="SEQUENCE", help="Folder of the stereo sequence.")],
) -> int:
    """Tell from a flown sequence whether its rig is still true; exit code 1 when re-calibration is due."""
    from rvdnav.cli.check import check

    return check(sequence)


def execute(arguments: Sequence[str]) -> int:
    """Run one command line and return its exit code; a user's mistake gets one line on stderr, never a traceback."""
    for before, argument in zip(["", *arguments], arguments, strict=False):
        if not argument or (argument.startswith("--") and argument.endswith("=")):
            return _complain(f"the value after {argument.rstrip('=') or before or 'rvdnav'} is empty")
    try:
        code = app(args=list(arguments) or ["--help"], prog_name="rvdnav", standalone_mode=False)
    except _UsageError as error:
        return _complain(error.format_message())
    except InputError as error:
        return _complain(str(error))
    except OSError as error:  # of what the commands foresee nothing: the disk is full, say
        return _complain(f"{error.filename or 'the output'}: {error.strerror or error}")
    except (KeyboardInterrupt, typer.Abort):
        return EXIT_INTERRUPTED
    return int(code or 0)


def _complain(fault: str) -> int:
    print(one_line(f"rvdnav: {' '.join(fault.split())}"), file=sys.stderr)
    return EXIT_BAD_INPUT


def main() -> NoReturn:
    """Entry point of the ``rvdnav`` program."""
    terminated = False

    def terminate(_number: int, _frame: FrameType | None) -> NoReturn:
        nonlocal terminated
        terminated = True
        raise KeyboardInterrupt  # so that half-written output is removed on the way out, as after any interrupt

    signal.signal(signal.SIGTERM, terminate)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a name that is no text, or a terminal that has no sigma
            stream.reconfigure(errors="replace")
    code = execute(sys.argv[1:])
    sys.exit(EXIT_TERMINATED if terminated and code == EXIT_INTERRUPTED else code)
