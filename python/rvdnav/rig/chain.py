"""What the calibration of one or two cameras says, wherever it stands, before they are placed in the world."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np

from rvdnav.camera import CameraModel
from rvdnav.errors import InputError
from rvdnav.pose.arrays import FloatArray
from rvdnav.rig.rig import Rig, world_from_camchain

# What the core takes: sides of an image; rectified pixels from the principal point, and from where they were.  px
_SIDE = (16, 4096)
_REACH = 8191.0
_SHIFT = 4095.0


@attrs.frozen
class CameraChain:
    """Cameras, the left one first, and the left one's pose (4, 4) in the right one's frame, where there are two.

    path: the file that says so.
    """

    path: Path
    cameras: tuple[CameraModel, ...]
    T_cam1_cam0: FloatArray | None

    @property
    def rig(self) -> Rig:
        """In the world of two cameras as `world_from_camchain` has it, or in the frame of one.

        Raises InputError naming the file when they are no rig, or one whose images the core cannot rectify.
        """
        try:
            derived = (np.eye(4),) if self.T_cam1_cam0 is None else world_from_camchain(self.T_cam1_cam0)
            return Rig(self.cameras, derived)
        except ValueError as error:
            raise InputError(f"{self.path}: {error}") from error

    def folds(self) -> list[str]:
        """For the user: which images have pixels without a ray."""
        return [
            f"{self.path.name}: cam{index}: the distortion folds back in the image: about {camera.pixels_without_ray} "
            "of its pixels have no ray, and nothing is measured there"
            for index, camera in enumerate(self.cameras)
            if camera.pixels_without_ray
        ]


def check_side(width: float, height: float) -> tuple[int, int]:
    """An image's size as whole numbers.  Raises ValueError unless they are, and of an image that the core takes."""
    if width != int(width) or height != int(height):
        raise ValueError("is not two whole numbers")
    if not all(_SIDE[0] <= side <= _SIDE[1] for side in (width, height)):
        raise ValueError(f"is {width:g} x {height:g}: a side has {_SIDE[0]} to {_SIDE[1]} px")
    return int(width), int(height)


def within_reach(path: Path, rig: Rig) -> Rig:
    """The rig, if the core can rectify its images.  Raises InputError naming the file that placed it so."""
    middle = 0.5 * np.array([rig.width - 1, rig.height - 1])
    corners = middle * (1.0 + np.array([[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]]))
    for index in range(len(rig.cameras)):
        rectified = rig.raw_to_rect(index, corners)
        for far, most in ((np.hypot(*rectified.T), _REACH), (np.abs(rectified - (corners - middle)), _SHIFT)):
            if (far > most).any():
                raise InputError(
                    f"{path}: cam{index}: rectification takes a corner of the image {np.nanmax(far):.0f} px away, "
                    f"more than {most:g}: it looks too far aside or its distortion is too strong"
                )
    return rig
