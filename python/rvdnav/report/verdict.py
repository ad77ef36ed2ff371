"""What came of a run, in a sentence, and the frames that are worth looking at."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from rvdnav.evaluation import Evaluation
from rvdnav.report.html import Verdict
from rvdnav.solution import Solution, State
from rvdnav.summary import unpublished_reasons

_MOST_REASONS = 4
_MOST_REFUSED = 3


def run_verdict(solutions: Sequence[Solution], evaluation: Evaluation | None) -> Verdict:
    """Wrong poses first, then losses and refused frames with their reasons counted."""
    published = sum(s.published for s in solutions)
    start = solutions[0].timestamp_ns
    lost = [(s.timestamp_ns - start) * 1e-9 for s in solutions if s.state is State.LOST]
    wrong = 0 if evaluation is None else int(evaluation.wrong.sum())
    sentences = []
    if wrong:
        sentences.append(f"{wrong} of {published} published poses {'is' if wrong == 1 else 'are'} wrong.")
    if not published:
        sentences.append(f"No pose was published in {len(solutions)} frames.")
    elif lost:
        times = "once" if len(lost) == 1 else f"{len(lost)} times, first"
        sentences.append(
            f"The target was lost {times} at {lost[0]:.3f} s; {published} of {len(solutions)} frames have a pose."
        )
    elif published < len(solutions):
        sentences.append(f"{published} of {len(solutions)} frames have a pose, and the target was never lost.")
    else:
        judged = "" if evaluation is None or wrong else ", and none is wrong"
        sentences.append(f"Every frame has a pose{judged}.")
    reasons = unpublished_reasons(solutions)
    if reasons:
        counts = ", ".join(f"{reason.name} ({count})" for reason, count in reasons[:_MOST_REASONS])
        more = f" and {len(reasons) - _MOST_REASONS} more reasons" if len(reasons) > _MOST_REASONS else ""
        sentences.append(f"Refused: {counts}{more}.")
    level = "bad" if wrong or not published else "fair" if lost or published < len(solutions) else "good"
    return Verdict(level, " ".join(sentences))


def notable_frames(solutions: Sequence[Solution], evaluation: Evaluation | None) -> dict[int, str]:
    """Numbers of the frames to be shown, in order, and why each.

    The first and the last pose; the worst by its error, else by its covariance; of the refused frames the first one of
    each of the most frequent sets of reasons.
    """
    chosen: dict[int, str] = {}
    published = [number for number, s in enumerate(solutions) if s.published]
    if published:
        chosen[published[0]], chosen[published[-1]] = "first pose", "last pose"
        number, why = _worst(solutions, published, evaluation)
        chosen[number] = why
    refused: dict[frozenset[str], list[int]] = {}
    for number, solution in enumerate(solutions):
        if not solution.published:
            refused.setdefault(frozenset(r.name for r in solution.reasons), []).append(number)
    for numbers in sorted(refused.values(), key=lambda numbers: (-len(numbers), numbers[0]))[:_MOST_REFUSED]:
        chosen[numbers[0]] = "refused" if len(numbers) == 1 else f"refused, as {len(numbers) - 1} more"
    return dict(sorted(chosen.items()))


def _worst(solutions: Sequence[Solution], published: list[int], evaluation: Evaluation | None) -> tuple[int, str]:
    if evaluation is not None and evaluation.published:
        stamp = int(evaluation.timestamps_ns[int(evaluation.position_m.argmax())])
        number = next(number for number in published if solutions[number].timestamp_ns == stamp)
        return number, f"largest error, {1e3 * evaluation.position_m.max():.2f} mm"
    sigmas = [np.sqrt(np.trace(s.covariance[:3, :3])) for s in solutions if s.published and s.covariance is not None]
    worst = int(np.argmax(sigmas))
    return published[worst], f"largest σ, {1e3 * sigmas[worst]:.2f} mm"
