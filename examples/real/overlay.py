"""Pictures to look at: the target projected into a sequence's images at the poses of a run, and all on one sheet.

    rvdnav run SEQUENCE --out DIR --initial-pose "$(cat SEQUENCE/initial_pose.txt)"
    python examples/real/overlay.py SEQUENCE DIR PICTURES [EVERY]

Published frames have the target in green, others their reasons in red.  Each frame's mean distance from the image's own
edges stands beside its number, px (`edge_distance`).
"""

from __future__ import annotations

import sys
from pathlib import Path

import cv2
import numpy as np
from edge_distance import edge_distances, projected_edges
from numpy.typing import NDArray
from rvdnav.navigator.edge_model import edge_model
from rvdnav.output import read_solutions
from rvdnav.sequence import Sequence, open_sequence
from rvdnav.solution import Solution

_GREEN, _RED = (0, 220, 0), (0, 0, 255)
_FRACTION_BITS = 4
_TILE = (480, 360)
_ACROSS = 6


def overlay(sequence: Sequence, index: int, solution: Solution) -> NDArray[np.uint8]:
    """The images (h, w, 3) of a frame, side by side, with what was made of it."""
    frame, model = sequence[index], edge_model(sequence.target)
    views = []
    for camera, image in enumerate((frame.left, frame.right)):
        if image is None:
            continue
        picture = cv2.cvtColor(image.pixels, cv2.COLOR_GRAY2BGR)
        text, colour = f"{index} {'+'.join(sorted(reason.name for reason in solution.reasons))}", _RED
        T = solution.T_world_target
        if T is not None:
            for _, uv in projected_edges(sequence.rig, camera, model, T):
                places = np.rint(uv * 2**_FRACTION_BITS).astype(np.int32).reshape(-1, 1, 2)
                cv2.polylines(picture, [places], False, _GREEN, 1, cv2.LINE_AA, _FRACTION_BITS)
            distances = edge_distances(image.pixels, sequence.rig, camera, model, T)
            text, colour = f"{index} {np.concatenate(list(distances.values())).mean():.2f} px", _GREEN
        cv2.putText(picture, text, (6, 24), cv2.FONT_HERSHEY_SIMPLEX, 0.7, colour, 2, cv2.LINE_AA)
        views.append(picture)
    return np.hstack(views).astype(np.uint8)


def contact_sheet(pictures: list[NDArray[np.uint8]]) -> NDArray[np.uint8]:
    """The pictures reduced, in rows."""
    tiles = [cv2.resize(picture, _TILE, interpolation=cv2.INTER_AREA) for picture in pictures]
    tiles += [np.zeros_like(tiles[0])] * (-len(tiles) % _ACROSS)
    rows = [np.hstack(tiles[first : first + _ACROSS]) for first in range(0, len(tiles), _ACROSS)]
    return np.vstack(rows).astype(np.uint8)


def main(sequence_path: Path, run: Path, out: Path, every: int = 1) -> None:
    sequence, solutions = open_sequence(sequence_path), read_solutions(run)
    out.mkdir(parents=True, exist_ok=True)
    pictures = []
    for index in range(0, len(solutions), every):
        pictures.append(overlay(sequence, index, solutions[index]))
        cv2.imwrite(str(out / f"{index:05d}.png"), pictures[-1])
    cv2.imwrite(str(out / "sheet.png"), contact_sheet(pictures))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:4]), *map(int, sys.argv[4:5]))
