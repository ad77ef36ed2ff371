"""A long run with random faults: nothing is raised, no wrong pose is published, and the memory does not grow.

    python bench/soak.py 20000      # 15 to 30 minutes on one core

The frames of examples/approach are shown forth and back to one navigator, whose time goes on; most images are spoilt.
"""

from __future__ import annotations

import argparse
import os
import signal
import time
import warnings
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import attrs
import numpy as np
from rich.console import Console
from rich.table import Table
from rvdnav import Navigator, open_sequence
from rvdnav.evaluation import is_wrong, pose_error
from rvdnav.faults import Fault, FaultySequence
from rvdnav.faults.catalog import PIXEL_FAULTS
from rvdnav.images import Image, PixelArray
from rvdnav.sequence import Frame, Sequence
from rvdnav.solution import Mode, Solution

APPROACH = Path(__file__).resolve().parents[1] / "examples" / "approach"
SIGMAS = 5.0
STEP_NS = 125_000_000
_LONG_NS = 10_000_000_000
Spoil = Callable[[PixelArray, np.random.Generator], PixelArray]


def _shifted(pixels: PixelArray, rng: np.random.Generator) -> PixelArray:
    return np.roll(pixels, int(rng.integers(-30, 30)), 1)


def _upside_down(pixels: PixelArray, _: np.random.Generator) -> PixelArray:
    return pixels[::-1].copy()


def _turned(pixels: PixelArray, _: np.random.Generator) -> PixelArray:
    return pixels[::-1, ::-1].copy()


def _patched(pixels: PixelArray, rng: np.random.Generator) -> PixelArray:
    result = pixels.copy()
    for _ in range(int(rng.integers(1, 12))):
        y, x = rng.integers(0, result.shape[0] - 5), rng.integers(0, result.shape[1] - 5)
        height, width = rng.integers(5, 200, 2)
        result[y : y + height, x : x + width] = rng.integers(0, 256)
    return result


def _exposed(pixels: PixelArray, rng: np.random.Generator) -> PixelArray:
    noise = rng.normal(0.0, rng.uniform(0.0, 40.0), pixels.shape)
    return np.clip(pixels * rng.uniform(0.02, 4.0) + noise, 0, 255).astype(np.uint8)


def _cut(pixels: PixelArray, rng: np.random.Generator) -> PixelArray:
    result = pixels.copy()
    result[:, : int(rng.integers(0, pixels.shape[1]))] = 0
    return result


MOVING: tuple[Spoil, ...] = (_shifted, _upside_down, _turned)
"""Those that leave a true picture of a target elsewhere: one view by itself cannot tell."""
HIDING: tuple[Spoil, ...] = (_patched, _exposed, _cut)


@attrs.define
class Outcome:
    """What became of a soak's frames.

    Of those published, how many were judged (not seen by moved images alone), and of these wrong (see
    `rvdnav.evaluation.is_wrong`); beyond: off by more than five standard deviations, where no image was moved; the
    states; and the resident memory, bytes, at every tenth of the way.
    """

    frames: int = 0
    published: int = 0
    judged: int = 0
    wrong: int = 0
    beyond: int = 0
    seconds: float = 0.0
    states: Counter[str] = attrs.field(factory=Counter)
    resident: list[int] = attrs.field(factory=list)


def soak(sequence: Sequence, frames: int, seed: int = 0) -> Outcome:
    """Show so many frames to a navigator; whatever it raises or warns of comes out of here, but for an interrupt."""
    rng = np.random.default_rng(seed)
    recorded = list(sequence)
    names = [name for name, fault in PIXEL_FAULTS.items() if not fault.strengths]
    struck = [FaultySequence(sequence, [Fault(name)]) for name in names]
    order = [*range(len(recorded)), *range(len(recorded) - 2, 0, -1)]
    navigator = Navigator(sequence.rig, sequence.target)
    outcome = Outcome()
    now_ns = recorded[0].timestamp_ns
    start = time.perf_counter()
    with warnings.catch_warnings(), suppress(KeyboardInterrupt):
        warnings.simplefilter("error")
        for number in range(frames):
            now_ns += _LONG_NS if rng.random() < 0.005 else STEP_NS
            index = order[number % len(order)]
            source, faulty = recorded[index], struck[rng.integers(len(struck))][index]
            images, moved = zip(*(_delivered(source, faulty, camera, rng) for camera in (0, 1)), strict=True)
            stamp = now_ns - 2 * STEP_NS if rng.random() < 0.01 else now_ns
            solution = navigator.process(Frame(stamp, *images))
            _count(outcome, solution, sequence, source, moved)
            if number % max(frames // 10, 1) == 0:
                outcome.resident.append(_resident())
    outcome.seconds = time.perf_counter() - start
    return outcome


def _delivered(source: Frame, faulty: Frame, camera: int, rng: np.random.Generator) -> tuple[Image | None, bool]:
    """A camera's image as it arrives, of the frame or of the same with a fault, and whether it was moved as a whole."""
    chance = rng.random()
    image = ((source.left, source.right) if chance < 0.5 or chance >= 0.65 else (faulty.left, faulty.right))[camera]
    if image is None or chance < 0.08:
        return None, False
    if chance < 0.65:
        noise = rng.integers(0, 2, image.pixels.shape, np.uint8)  # so that a frame shown again is no duplicate
        return attrs.evolve(image, pixels=np.minimum(image.pixels, 254) + noise), False
    moving = chance < 0.8
    kinds = MOVING if moving else HIDING
    return attrs.evolve(image, pixels=kinds[rng.integers(len(kinds))](image.pixels, rng)), moving


def _count(outcome: Outcome, solution: Solution, sequence: Sequence, source: Frame, moved: tuple[bool, ...]) -> None:
    outcome.frames += 1
    outcome.states[solution.state.name] += 1
    T, covariance, truth = solution.T_world_target, solution.covariance, sequence.truth
    if T is None or covariance is None or truth is None:
        return
    outcome.published += 1
    views = {Mode.STEREO: moved, Mode.MONO_LEFT: moved[:1], Mode.MONO_RIGHT: moved[1:]}
    if solution.mode is None or all(views[solution.mode]):
        return
    outcome.judged += 1
    true = truth.at(source.timestamp_ns)
    assert true is not None
    error = pose_error(T, true)
    position, attitude, distance = (np.array([np.linalg.norm(v)]) for v in (error[:3], error[3:], true[:3, 3]))
    outcome.wrong += bool(is_wrong(position, attitude, distance)[0])
    # An image moved by a pixel is a camera that is calibrated wrongly, which two views do not always tell.
    if not any(moved):
        outcome.beyond += bool((np.abs(error) > SIGMAS * np.sqrt(np.diag(covariance))).any())


def _resident() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def main() -> None:
    """Print the outcome as a table; exit code 1 where a pose was wrong."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frames", type=int, nargs="?", default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
    outcome = soak(open_sequence(APPROACH), arguments.frames, arguments.seed)
    table = Table(show_header=False, title=f"Soak, seed {arguments.seed}", title_justify="left")
    for name, value in (
        ("frames", f"{outcome.frames}, none raised"),
        *((state, str(count)) for state, count in sorted(outcome.states.items())),
        ("published", str(outcome.published)),
        ("judged (not by moved images alone)", str(outcome.judged)),
        ("wrong (> 20 mm or > 2 deg (1 + range / 1 m))", str(outcome.wrong)),
        (f"beyond {SIGMAS:g} sigma, no image moved", str(outcome.beyond)),
        ("resident at every tenth, MB", " ".join(f"{size / 1e6:.0f}" for size in outcome.resident)),
        ("seconds, and ms a frame", f"{outcome.seconds:.0f}, {1e3 * outcome.seconds / max(outcome.frames, 1):.1f}"),
    ):
        table.add_row(name, value)
    Console(highlight=False).print(table)
    raise SystemExit(int(outcome.wrong > 0))


if __name__ == "__main__":
    main()
