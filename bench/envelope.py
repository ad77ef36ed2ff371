"""The envelope: in which images, and with what knowledge, the navigator may be used; docs/envelope.md.

    python bench/envelope.py SEQUENCE... [--every N] [--only REGEX] [--jobs N] [--results FILE] [--out FILE.md]
                             [--picture FILE.svg]

A line is one fault of one strength on one sequence, in all frames and both cameras, by a fresh navigator with default
settings.  Faults at random in what the navigator is told are drawn several times, and the draws counted together.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
from collections.abc import Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from envelope_picture import Cell, picture
from rvdnav import Navigator, open_sequence
from rvdnav.errors import InputError
from rvdnav.evaluation import PAPER_ATTITUDE_RAD, PAPER_POSITION_M, evaluate
from rvdnav.faults import STRENGTHS, FaultySequence, parse_fault
from rvdnav.files import read_text, write_text_atomically
from rvdnav.rig import calibration_parameters

SIGMAS = 5.0
DRAWS = 5
"""Of faults at random in what the navigator is told."""


@attrs.frozen
class Wanted:
    """The share of frames that shall be published, and the largest median errors."""

    published: float
    position_mm: float = 1e3 * PAPER_POSITION_M
    attitude_deg: float = float(np.degrees(PAPER_ATTITUDE_RAD))


ALMOST_ALL = Wanted(0.95, 2.0, 1.5)
MOST = Wanted(0.80)
MORE_THAN_HALF = Wanted(0.60)
NEES_RATIO = (0.3, 3.0)
BEYOND_SHARE = 0.01


@attrs.frozen
class Case:
    """A fault as `rvdnav run --fault` takes it, without its frames, and what is wanted of it, if anything."""

    fault: str
    wanted: Wanted | None = None

    @property
    def draws(self) -> int:
        """How often it is drawn."""
        return DRAWS if self.fault.startswith(("target_", "calibration")) else 1


def _cases(name: str, unasked: Iterable[str], asked: dict[str, Wanted]) -> list[Case]:
    strengths = {**dict.fromkeys(unasked), **asked}
    return [
        Case(f"{name}={strength}", strengths[strength])
        for strength in sorted(strengths, key=lambda text: float(text.partition(",")[0]))
    ]


NO_FAULT = "none"
EXACT = "exact"
"""No fault, and the navigator is told that sizes and calibration are exact."""
CASES = [
    Case(EXACT, ALMOST_ALL),
    Case(NO_FAULT, ALMOST_ALL),
    *_cases("noise", ["40"], {"6": ALMOST_ALL, "12": ALMOST_ALL, "25": MOST}),
    *_cases("blur", ["6"], {"1": ALMOST_ALL, "2.5": ALMOST_ALL, "4": MOST}),
    *_cases("motion_blur", ["15"], {"2": ALMOST_ALL, "5": ALMOST_ALL, "9": MOST}),
    *_cases("jpeg", ["20", "10"], {"80": ALMOST_ALL, "40": ALMOST_ALL}),
    *_cases("gamma", ["0.3", "3.5"], {"0.45": ALMOST_ALL, "0.7": ALMOST_ALL, "1.5": ALMOST_ALL, "2.2": ALMOST_ALL}),
    *_cases("sharpened", ["4"], {"0.5": ALMOST_ALL, "1": ALMOST_ALL, "2": ALMOST_ALL}),
    *_cases("grey_steps", ["32"], {"8": ALMOST_ALL, "16": ALMOST_ALL}),
    Case("field_doubled", ALMOST_ALL),
    *_cases("rolling_shutter", ["8"], {"1": ALMOST_ALL, "3": ALMOST_ALL}),
    *_cases("interlaced", [], {"-125": MOST, "20": MOST, "125": MOST}),
    *_cases("interlaced_bottom", [], {"20": MOST, "125": MOST}),
    *_cases("row_noise", ["2", "5", "10"], {}),
    *_cases("hot_pixels", ["1", "10"], {}),
    *_cases("flare", ["40", "80", "160"], {}),
    *_cases("vignetting", ["0.4", "0.8"], {}),
    *_cases("target_sizes", ["3"], {"0.1": ALMOST_ALL, "0.3": ALMOST_ALL, "1": MOST}),
    *_cases("target_points", ["3"], {"0.1": ALMOST_ALL, "0.3": ALMOST_ALL, "1": MOST}),
    *_cases("calibration", ["1,6,0.2"], {"0.05,0.3,0.01": ALMOST_ALL, "0.2,1,0.03": MOST, "0.5,3,0.1": MORE_THAN_HALF}),
]


@attrs.frozen
class Run:
    """One run of the navigator: a case's draw on a sequence, on every n-th frame."""

    sequence: str
    fault: str
    draw: int
    every: int

    def measure(self) -> Outcome:
        """What comes of it."""
        recorded = open_sequence(self.sequence)
        if recorded.truth is None:
            raise InputError(f"{self.sequence}: holds no groundtruth.tum")
        faults = [] if self.fault in (EXACT, NO_FAULT) else [parse_fault(f"{self.fault}:all")]
        sequence = FaultySequence(recorded, faults, seed=self.draw)
        rig, target = sequence.rig, sequence.target
        if self.fault == EXACT:
            size = len(calibration_parameters(len(rig.cameras)))
            rig = attrs.evolve(rig, calibration_covariance=np.zeros((size, size)))
            target = attrs.evolve(target, tolerance=dict.fromkeys(target.points, 0.0))
        navigator = Navigator(rig, target)
        solutions = [navigator.process(sequence[index]) for index in range(0, len(sequence), self.every)]
        result = evaluate(solutions, recorded.truth)
        return Outcome(
            frames=result.frames,
            wrong=int(result.wrong.sum()),
            beyond=int((np.abs(result.components) > SIGMAS * result.sigmas).any(axis=1).sum()),
            position_mm=(1e3 * result.position_m).tolist(),
            attitude_deg=np.degrees(result.attitude_rad).tolist(),
            nees_ratio=(result.nees / 6.0).tolist(),
        )


@attrs.frozen
class Outcome:
    """What came of one run or of several together.

    frames with a true pose; of those published: how many wrong (`Evaluation.wrong`), how many beyond SIGMAS, the errors
    and NEES / 6 of each.
    """

    frames: int
    wrong: int
    beyond: int
    position_mm: list[float]
    attitude_deg: list[float]
    nees_ratio: list[float]

    @classmethod
    def of(cls, outcomes: Iterable[Outcome]) -> Outcome:
        """All together."""
        first, *others = outcomes
        for other in others:
            first = cls(*(a + b for a, b in zip(attrs.astuple(first), attrs.astuple(other), strict=True)))
        return first

    @property
    def published(self) -> float:
        """Share of the frames."""
        return len(self.position_mm) / self.frames

    @property
    def within(self) -> float:
        """Share of the published frames within the paper's 20 mm and 2 degrees."""
        good = (np.array(self.position_mm) <= 1e3 * PAPER_POSITION_M) & (
            np.array(self.attitude_deg) <= np.degrees(PAPER_ATTITUDE_RAD)
        )
        return float(good.mean())

    def failures(self, wanted: Wanted) -> list[str]:
        """In which respects it is not what is wanted."""
        if not self.position_mm:
            return ["published"]
        misses = {
            "published": self.published < wanted.published,
            "position": np.median(self.position_mm) > wanted.position_mm,
            "attitude": np.median(self.attitude_deg) > wanted.attitude_deg,
            "NEES": np.median(self.nees_ratio) < NEES_RATIO[0],
        }
        return [*(name for name, missed in misses.items() if missed), *self.lies]

    @property
    def lies(self) -> list[str]:
        """In which respects the published poses are worse than they say."""
        if not self.position_mm:
            return []
        lies = {
            "wrong": self.wrong > 0,
            "NEES": np.median(self.nees_ratio) > NEES_RATIO[1],
            "beyond 5σ": self.beyond >= BEYOND_SHARE * len(self.position_mm),
        }
        return [name for name, told in lies.items() if told]


HEADINGS = (
    "fault",
    "sequence",
    "published",
    "wrong",
    "within 20 mm, 2°",
    "median error, mm / °",
    "NEES/6, median / mean",
    "beyond 5σ",
    "wanted",
    "missed",
)


def row(case: Case, name: str, outcome: Outcome) -> tuple[str, ...]:
    """The cells of a line of the table."""
    count = len(outcome.position_mm)
    measured = ("–", "–", "–", "–")
    if count:
        nees = outcome.nees_ratio
        measured = (
            f"{100.0 * outcome.within:.0f} %",
            f"{np.median(outcome.position_mm):.2f} / {np.median(outcome.attitude_deg):.2f}",
            f"{np.median(nees):.2f} / {np.mean(nees):.2f}",
            f"{100.0 * outcome.beyond / count:.1f} %",
        )
    wanted = "–" if case.wanted is None else f"≥ {100.0 * case.wanted.published:.0f} %"
    missed = "–" if case.wanted is None else ", ".join(outcome.failures(case.wanted)) or "nothing"
    return (
        case.fault,
        name,
        f"{100.0 * outcome.published:.0f} % of {outcome.frames}",
        str(outcome.wrong),
        *measured,
        wanted,
        missed,
    )


def measure_all(runs: list[Run], jobs: int, results: Path | None) -> Iterator[tuple[Run, Outcome]]:
    """The outcomes of all runs as they come; those in the file are taken from there, the others are added to it."""
    done = _stored(results)
    for run in runs:
        if run in done:
            yield run, done[run]
    missing = [run for run in runs if run not in done]
    with ProcessPoolExecutor(jobs) as pool:
        pending = {pool.submit(Run.measure, run): run for run in missing}
        for future in as_completed(pending):
            run, outcome = pending[future], future.result()
            if results is not None:
                with results.open("a", encoding="utf-8") as file:
                    file.write(json.dumps({"run": attrs.asdict(run), "outcome": attrs.asdict(outcome)}) + "\n")
            yield run, outcome


def _stored(results: Path | None) -> dict[Run, Outcome]:
    if results is None or not results.exists():
        return {}
    lines: list[dict[str, Any]] = [json.loads(line) for line in results.read_text("utf-8").splitlines()]
    return {Run(**line["run"]): Outcome(**line["outcome"]) for line in lines}


def table(rows: Iterable[tuple[str, ...]]) -> list[str]:
    """Lines of a Markdown table."""
    return [f"| {' | '.join(cells)} |" for cells in (HEADINGS, ("---",) * len(HEADINGS), *rows)]


MARK = "<!-- table: python bench/envelope.py -->\n"


def around_table(page: Path) -> tuple[str, str]:
    """The page's text up to its mark, after which the table stands, and what comes after the table.

    A page that isn't there is the mark alone.  Raises InputError for one without the mark, or without a folder.
    """
    if not page.parent.is_dir():
        raise InputError(f"{page.parent}: no such folder")
    before, found, after = read_text(page).partition(MARK) if os.path.exists(page) else ("", MARK, "")
    if not found:
        raise InputError(f"{page}: has no line {MARK.strip()}")
    return before + found, after[after.find("\n\n") :] if "\n\n" in after else "\n"


def cells(outcomes: dict[str, Outcome]) -> dict[str, list[Cell]]:
    """The picture's cells by fault, from what came of each case on all sequences together."""
    rows: dict[str, list[Cell]] = {}
    for fault, outcome in outcomes.items():
        name, _, strength = fault.partition("=")
        units = ", ".join(number.unit for number in STRENGTHS.get(name, ()) if not number.optional)
        label = name.replace("_", " ") + (f" ({units})" if units else "")
        rows.setdefault(label, []).append(Cell(strength, outcome.published, not outcome.lies))
    return rows


def main(arguments: list[str]) -> None:
    """Measure, print the table, and write it into the page.  Raises InputError."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequences", nargs="+", metavar="SEQUENCE")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="only every N-th frame")
    parser.add_argument("--only", default="", metavar="REGEX", help="only the faults that match, such as ^blur")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), metavar="N", help="runs at once")
    parser.add_argument("--results", type=Path, metavar="FILE", help="keep the outcomes here, and go on from them")
    parser.add_argument("--out", type=Path, metavar="FILE.md", help="write the table into this page")
    parser.add_argument("--picture", type=Path, metavar="FILE.svg", help="draw it")
    given = parser.parse_args(arguments)
    if given.out is not None:
        before, after = around_table(given.out)  # a page that cannot take it is refused before the work is done
    cases = [case for case in CASES if re.search(given.only, case.fault)]
    runs = [
        Run(path, case.fault, draw, given.every)
        for case in cases
        for path in given.sequences
        for draw in range(case.draws)
    ]
    outcomes: dict[Run, Outcome] = {}
    for run, outcome in measure_all(runs, given.jobs, given.results):
        outcomes[run] = outcome
        print(f"{len(outcomes)} of {len(runs)}", end="\r", file=sys.stderr, flush=True)
    rows: list[tuple[str, ...]] = []
    together: dict[str, Outcome] = {}
    for case in cases:
        on_each = {
            path: Outcome.of(outcomes[Run(path, case.fault, draw, given.every)] for draw in range(case.draws))
            for path in given.sequences
        }
        rows += [row(case, Path(path).resolve().name, outcome) for path, outcome in on_each.items()]
        together[case.fault] = Outcome.of(on_each.values())
    lines = table(rows)
    print("\n".join(lines))
    if given.out is not None:
        write_text_atomically(given.out, before + "\n".join(lines) + after)
    if given.picture is not None:
        write_text_atomically(given.picture, picture(cells(together)))


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except InputError as error:
        sys.exit(f"envelope: {error}")
