"""VRML models (.wrl) of flat faces as target.yaml.  Materials, lights and transforms are not looked at.

python examples/real/wrl_to_target.py MODEL.wrl target.yaml
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import numpy as np
from rvdnav.target import Target
from rvdnav.target_writer import save_target
from solid import Points, solid

_FACE_SET = re.compile(r"\bpoint\s*\[([^]]*)\].*?\bcoordIndex\s*\[([^]]*)\]", re.DOTALL)


def target_from_wrl(path: Path, name: str) -> Target:
    """All indexed face sets of the model together.  Raises ValueError for a file without any."""
    text = re.sub(r"#.*", "", path.read_text(encoding="utf-8", errors="replace"))
    faces: list[Points] = []
    for coordinates, indices in _FACE_SET.findall(text):
        points = np.array(coordinates.replace(",", " ").split(), np.float64).reshape(-1, 3)
        loop: list[int] = []
        for index in [*map(int, indices.replace(",", " ").split()), -1]:
            if index >= 0:
                loop.append(index)
            elif loop:
                faces.append(points[loop])
                loop = []
    if not faces:
        raise ValueError(f"{path}: holds no IndexedFaceSet")
    return solid(name, faces)


if __name__ == "__main__":
    save_target(target_from_wrl(Path(sys.argv[1]), Path(sys.argv[1]).stem), sys.argv[2])
