"""What a campaign runs: every source with every fault and every seed."""

from __future__ import annotations

import hashlib
import os
import re
from pathlib import Path

import attrs

from rvdnav.errors import InputError
from rvdnav.faults import Fault, parse_fault
from rvdnav.files import read_text
from rvdnav.yamlio import Section, read_yaml

NO_FAULT = "none"
_MOST_TRIALS = 100_000
_LARGEST_SEED = 2**53


@attrs.frozen
class Source:
    """Where the images of a trial come from: a recorded sequence, or a scenario rendered with a seed.

    path: of the sequence folder or of the scenario file.  seed: of the scenario; None for a recorded sequence.
    content: digest of the scenario file.
    """

    path: Path
    seed: int | None = None
    content: str = ""

    @property
    def name(self) -> str:
        """Short, for tables and folders: approach, paper-3."""
        return self.path.resolve().name if self.seed is None else f"{self.path.stem}-{self.seed}"


@attrs.frozen
class Trial:
    """One run of the navigator.

    faults: as text, joined by blanks; NO_FAULT for none.  seed: of the faults' random numbers.
    """

    source: Source
    faults: str
    seed: int

    @property
    def key(self) -> str:
        """Names the trial and its file; the same for the same trial, another for every other one."""
        text = f"{self.source.path.resolve()}|{self.source.seed}|{self.source.content}|{self.faults}|{self.seed}"
        readable = re.sub(r"[^A-Za-z0-9.-]+", "_", f"{self.source.name}_{self.faults}_{self.seed}")[:80]
        return f"{readable}_{hashlib.sha256(text.encode()).hexdigest()[:12]}"

    def parsed_faults(self) -> list[Fault]:
        """The faults to be injected.  Raises InputError for one that there is not."""
        return parse_faults(self.faults)


def parse_faults(text: str) -> list[Fault]:
    """The faults of a text that joins them by blanks; none for NO_FAULT.  Raises InputError for one there is not."""
    return [] if text == NO_FAULT else [parse_fault(fault) for fault in text.split()]


@attrs.frozen
class Plan:
    """A campaign: its name and its trials, each once."""

    name: str
    trials: tuple[Trial, ...]

    @property
    def sources(self) -> tuple[Source, ...]:
        """Each once, in order."""
        return tuple(dict.fromkeys(trial.source for trial in self.trials))

    @property
    def digest(self) -> str:
        """Of the trials: two plans with the same digest give the same results."""
        return hashlib.sha256("\n".join(trial.key for trial in self.trials).encode()).hexdigest()


def load_plan(path: str | Path) -> Plan:
    """The campaign that a file describes; paths in it are relative to it.

    Keys: `name`; `sequences`, a list of folders; `scenarios`, a list of scenario files; `seeds`, a list of numbers, or
    `{first, count}`; `faults`, a list of texts as `rvdnav run --fault` takes them, several at once joined by blanks,
    and `none`.  A scenario is rendered once for each seed.  A recorded sequence without faults is run once, for nothing
    in it is random.  Raises InputError naming the file and the fault.
    """
    section = read_yaml(Path(path))
    folder = Path(path).parent
    section.only("name", "sequences", "scenarios", "seeds", "faults")
    sequences = [folder / text for text in section.texts("sequences")] if "sequences" in section else []
    scenarios = [folder / text for text in section.texts("scenarios")] if "scenarios" in section else []
    if not sequences and not scenarios:
        raise InputError(f"{path}: neither sequences nor scenarios")
    for place in [*sequences, *scenarios]:
        if not os.path.exists(place):
            raise InputError(f"{path}: {place}: no such {'folder' if place in sequences else 'file'}")
    seeds = _read_seeds(section)
    faults = section.texts("faults") if "faults" in section else (NO_FAULT,)
    places, faults = dict.fromkeys([*sequences, *scenarios]), tuple(dict.fromkeys(" ".join(f.split()) for f in faults))
    if len(places) * len(faults) * len(seeds) > _MOST_TRIALS:
        raise InputError(f"{path}: more than {_MOST_TRIALS} trials")
    contents = {place: hashlib.sha256(read_text(place).encode()).hexdigest() for place in scenarios}
    trials = []
    for fault in faults:
        for place in dict.fromkeys(sequences):
            for seed in seeds[:1] if fault == NO_FAULT else seeds:
                trials.append(Trial(Source(place), fault, seed))
        for place, content in contents.items():
            trials += [Trial(Source(place, seed, content), fault, seed) for seed in seeds]
    try:
        for fault in faults:
            parse_faults(fault)
    except InputError as error:
        raise InputError(f"{path}: faults: {error}") from error
    return Plan(section.text("name"), tuple(trials))


def _read_seeds(section: Section) -> list[int]:
    if "seeds" not in section:
        return [0]
    if isinstance(section.values["seeds"], dict):
        numbers = section.section("seeds")
        numbers.only("first", "count")
        first = numbers.whole("first", 0, _LARGEST_SEED)
        return list(range(first, first + numbers.whole("count", 1, _MOST_TRIALS)))
    values = section.values["seeds"]
    seeds = section.numbers("seeds", len(values) if isinstance(values, list) else 1).tolist()
    if not seeds or any(seed != int(seed) or not 0 <= seed <= _LARGEST_SEED for seed in seeds):
        raise section.fault(
            "seeds", f"is neither a list of whole numbers from 0 to {_LARGEST_SEED} nor {{first, count}}"
        )
    return [int(seed) for seed in dict.fromkeys(values)]
