"""Writes frames of a sequence and its rig as the replay program reads them: SEQUENCE FOLDER INDEX..."""

import sys
from pathlib import Path

import cv2
import numpy as np
from rvdnav.rig import Rig, load_rig


def rig_text(rig: Rig) -> str:
    """The rig as replay.cpp documents it; repr keeps every bit of a double."""
    numbers = [rig.width, rig.height, rig.focal_rect, rig.baseline]
    for i, camera in enumerate(rig.cameras):
        numbers += [camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion]
        numbers += list(np.ravel(rig.R_rect_cam(i)))
    return "\n".join(repr(float(n)) for n in numbers) + "\n"


def main(sequence: Path, folder: Path, indices: list[int]) -> None:
    (folder / "rig.txt").write_text(rig_text(load_rig(sequence)))
    for n, index in enumerate(indices):
        for camera in ("cam0", "cam1"):
            path = sorted((sequence / camera / "data").glob("*.png"))[index]
            pixels = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
            header = f"P5 {pixels.shape[1]} {pixels.shape[0]} 255\n".encode()
            (folder / f"frame{n}_{camera}.pgm").write_bytes(header + pixels.tobytes())


main(Path(sys.argv[1]), Path(sys.argv[2]), [int(i) for i in sys.argv[3:]])
