"""What the commands share of the terminal: results on stdout; notes and progress on stderr."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

from rvdnav.errors import one_line

_NUMBER = re.compile(r"\d+")


class _Output(Console):
    """What is written to a pipe that nobody reads any more is lost, and the command goes on: its files are wanted."""

    def on_broken_pipe(self) -> None:
        self.quiet = True
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self.file.fileno())
        os.close(nowhere)


console = _Output(highlight=False, markup=False)
"""Results, on stdout."""
errors = _Output(stderr=True, highlight=False, markup=False)
"""Notes and progress, on stderr."""


def print_note(text: str) -> None:
    """Something that the user should know, on stderr."""
    errors.print(one_line(f"rvdnav: note: {text}"), soft_wrap=True)


def print_notes(notices: Iterable[str]) -> None:
    """Notes, those that differ in their numbers alone as one: the first of them, and how many more there are."""
    kinds: dict[str, list[str]] = {}
    for notice in notices:
        kinds.setdefault(_NUMBER.sub("#", notice), []).append(notice)
    for first, *others in kinds.values():
        print_note(f"{first} (and {len(others)} more like it)" if others else first)


@contextmanager
def progress_bars() -> Iterator[Callable[[str, int, int], None]]:
    """Gives tell(what, done, total), which shows a bar for each `what`; nothing where stderr is no terminal."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    tasks: dict[str, TaskID] = {}

    def tell(what: str, done: int, total: int) -> None:
        if what in tasks:
            progress.update(tasks[what], completed=done, total=total)
        elif total:  # what an earlier run did is there from the start, or the time left would be reckoned with it
            tasks[what] = progress.add_task(what, total=total, completed=done)

    with Progress(*columns, console=errors, transient=True, disable=not errors.is_terminal) as progress:
        yield tell
