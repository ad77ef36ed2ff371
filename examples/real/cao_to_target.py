"""ViSP's CAD models (.cao) as target.yaml: points, straight edges and flat faces.

Cylinders and circles have no straight edges of their own and are left out, which is said.

    python examples/real/cao_to_target.py MODEL.cao target.yaml
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from rvdnav.pose import exp
from rvdnav.target import Target
from rvdnav.target_writer import save_target
from solid import Points, solid

_LOAD = re.compile(r'load\(\s*"([^"]+)"\s*(?:,\s*t\s*=\s*\[([^]]*)\])?\s*(?:,\s*tu\s*=\s*\[([^]]*)\])?\s*\)')


def target_from_cao(path: Path, name: str) -> Target:
    """The model with all that it loads.  Raises ValueError for a file that is none."""
    faces, lines = _read(path)
    return solid(name, faces, lines)


def _read(path: Path) -> tuple[list[Points], list[Points]]:
    """Faces and lines, m, of a model and of the parts that it loads, which are turned first and shifted then."""
    text = re.sub(r"#.*", "", path.read_text(encoding="utf-8", errors="replace"))
    faces: list[Points] = []
    lines: list[Points] = []
    for part, shift, turn in _LOAD.findall(text):
        R, t = exp(_angles(turn)), _angles(shift)
        more_faces, more_lines = _read(path.parent / part)
        faces += [face @ R.T + t for face in more_faces]
        lines += [line @ R.T + t for line in more_lines]
    rows = iter(line.split() for line in _LOAD.sub("", text).splitlines() if line.strip())
    try:
        if next(rows)[0] != "V1":
            raise ValueError(f"{path}: not a .cao model of version 1")
        points = np.array([[float(word) for word in row[:3]] for row in _section(rows)]).reshape(-1, 3)
        segments = [points[[int(word) for word in row[:2]]] for row in _section(rows)]
        for row in _section(rows):
            sides = [segments[int(word)] for word in row[1 : 1 + int(row[0])]]
            faces.append(np.array([side[0] for side in sides]))
        faces += [points[[int(word) for word in row[1 : 1 + int(row[0])]]] for row in _section(rows)]
        rounds = len(_section(rows)) + len(_section(rows))
    except (StopIteration, IndexError) as error:
        raise ValueError(f"{path}: ends too early or names a point that is not there") from error
    if rounds:
        print(f"{path}: {rounds} cylinders or circles are left out")
    return faces, lines + segments


def _section(rows: Iterator[list[str]]) -> list[list[str]]:
    """The rows of a section, which begins with their number; the last sections may be left out."""
    return [next(rows) for _ in range(int(next(rows, ["0"])[0]))]


def _angles(text: str) -> Points:
    """Three lengths, m, or angles in rad unless they are marked as deg; zeros for nothing."""
    values = [float(word.split()[0]) for word in text.split(";")] if text else [0.0, 0.0, 0.0]
    return np.radians(values) if "deg" in text else np.array(values)


if __name__ == "__main__":
    save_target(target_from_cao(Path(sys.argv[1]), Path(sys.argv[1]).stem), sys.argv[2])
