"""What a navigator made of a fault: whether it refused the struck frames, and how soon."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

import attrs
import numpy as np

from rvdnav.evaluation import Evaluation
from rvdnav.solution import Solution


@attrs.frozen(eq=False)
class Response:
    """Solutions of the struck frames and of those after the last of them, in the order of arrival.

    A dropped frame has no solution and is in neither.
    """

    struck: tuple[Solution, ...]
    after: tuple[Solution, ...]

    @classmethod
    def of(cls, struck_ns: Iterable[int], solutions: Iterable[Solution]) -> Response:
        """From the stamps of the struck frames and the solutions of a run."""
        stamps = frozenset(struck_ns)
        last = max(stamps, default=-1)
        run = tuple(solutions)
        return cls(
            tuple(solution for solution in run if solution.timestamp_ns in stamps),
            tuple(solution for solution in run if solution.timestamp_ns > last),
        )

    @property
    def refused(self) -> int:
        """Struck frames without a pose."""
        return sum(not solution.published for solution in self.struck)

    @property
    def reasons(self) -> tuple[str, ...]:
        """Names of the reasons of the struck frames, the commonest first."""
        counts = Counter(name for solution in self.struck for name in sorted(r.name for r in solution.reasons))
        return tuple(name for name, _ in counts.most_common())

    @property
    def alarm(self) -> int | None:
        """Frames until the alarm: struck frames before the first one that is refused, or published with a reason beside
        its pose, such as a camera that takes no part; None without any."""
        return _position([not solution.published or bool(solution.reasons) for solution in self.struck])

    @property
    def again(self) -> int | None:
        """Frames refused after the last struck one before a pose is published; None without any published."""
        return _position([solution.published for solution in self.after])

    def wrong(self, evaluation: Evaluation) -> int:
        """Struck frames whose published pose is wrong (`Evaluation.wrong`)."""
        stamps = [solution.timestamp_ns for solution in self.struck]
        return int(np.count_nonzero(evaluation.wrong & np.isin(evaluation.timestamps_ns, stamps)))


def _position(flags: list[bool]) -> int | None:
    return flags.index(True) if True in flags else None
