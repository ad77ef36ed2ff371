"""Cameras other than the example's: large images, regions of larger ones, lenses that fold near a corner."""

from __future__ import annotations

import numpy as np
import pytest
from drawn_scene import Look, bracket_target, draw_images, frame_of, pose
from rvdnav import Navigator
from rvdnav.camera import CameraModel
from rvdnav.conventions import make_T
from rvdnav.rig import Rig

LOOK = Look(thick=False)


def rig_of(width: int, height: int, focal: float, cx: float, k1: float = 0.0) -> Rig:
    """Two equal cameras 0.12 m apart that look straight ahead."""
    camera = CameraModel(width, height, focal, focal, cx, 0.5 * (height - 1), [k1, 0.0, 0.0, 0.0])
    R_world_cam = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    return Rig([camera, camera], [make_T(R_world_cam, np.array([0.0, 0.0, z])) for z in (0.12, 0.0)])


@pytest.mark.parametrize(
    ("rig", "T"),
    [
        pytest.param(rig_of(1280, 1024, 1000.0, 639.5), pose(0.9, 0.0, 0.40), id="lines beyond 512 px"),
        pytest.param(rig_of(704, 576, 1400.0, 1400.0), pose(0.9, 0.0, 0.70, 0.0, 20.0), id="region of a larger image"),
        pytest.param(rig_of(1920, 1080, 1000.0, 959.5, -0.3 / 2.0), pose(0.6, 0.0, 0.05), id="strong distortion"),
        pytest.param(rig_of(2448, 2048, 2200.0, 1223.5), pose(0.9, 0.05, 0.15), id="5 megapixels"),
    ],
)
def test_the_bracket_is_found_in_images_of_other_cameras(rig: Rig, T: np.ndarray) -> None:
    target = bracket_target()
    solution = Navigator(rig, target).process(frame_of(draw_images(rig, target, T, look=LOOK)))
    assert solution.T_world_target is not None
    assert np.linalg.norm(solution.T_world_target[:3, 3] - T[:3, 3]) < 1e-3
