"""ViSP's ways to say where a target is, as an initial pose: "tx ty tz qx qy qz qw".

A .pos file holds the pose of the object in the camera as a shift and a rotation vector; a .txt file the same as a
matrix of 4x4.  An .init file holds points of the model that a person clicks on in the first image; their pixels follow.

    python examples/real/pose_to_initial_pose.py cube.0.pos
    python examples/real/pose_to_initial_pose.py teabox.init camera.xml U,V U,V U,V U,V
"""

from __future__ import annotations

import re
import sys
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from rvdnav.camera import CameraModel
from rvdnav.pose import exp, make_T, quaternion_xyzw
from solid import Points
from xml_to_rig import camera_from_xml


def pose_from_file(path: Path) -> Points:
    """T_camera_object (4, 4) of a .pos file or of a matrix.  Raises ValueError for a file that holds neither."""
    values = np.array(path.read_text().split(), np.float64)
    if len(values) == 6:
        return make_T(exp(values[3:]), values[:3])
    if len(values) != 16:
        raise ValueError(f"{path}: {len(values)} numbers, neither the 6 of a .pos file nor a matrix of 4x4")
    # Six digits are printed of some: to the nearest rotation.
    T = values.reshape(4, 4)
    U, _, Vt = np.linalg.svd(T[:3, :3])
    return make_T(U @ Vt, T[:3, 3])


def pose_from_clicks(path: Path, camera: CameraModel, pixels: Sequence[tuple[float, float]]) -> Points:
    """T_camera_object (4, 4) that puts an .init file's points on these pixels.  Raises ValueError for other numbers."""
    words = re.sub(r"#.*", "", path.read_text()).split()
    points = np.array(words[1 : 1 + 3 * int(words[0])], np.float64).reshape(-1, 3)
    if len(points) != len(pixels):
        raise ValueError(f"{path}: {len(points)} points but {len(pixels)} pixels")
    K = np.array([[camera.fx, 0, camera.cx], [0, camera.fy, camera.cy], [0, 0, 1]])
    _, turn, shift = cv2.solvePnP(points, np.array(pixels, np.float64), K, camera.distortion, flags=cv2.SOLVEPNP_SQPNP)
    return make_T(exp(turn.ravel()), shift.ravel())


def pose_text(T: Points) -> str:
    """As `rvdnav run --initial-pose` reads it."""
    return " ".join(f"{value:.9g}" for value in (*T[:3, 3], *quaternion_xyzw(T[:3, :3])))


if __name__ == "__main__":
    source = Path(sys.argv[1])
    if source.suffix == ".init":
        clicks = [(float(u), float(v)) for u, v in (word.split(",") for word in sys.argv[3:])]
        print(pose_text(pose_from_clicks(source, camera_from_xml(Path(sys.argv[2])), clicks)))
    else:
        print(pose_text(pose_from_file(source)))
