"""Faults of the calibration: a rig that the cameras are not.  The images stay as they are."""

from __future__ import annotations

import math

import attrs
import numpy as np

from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import exp
from rvdnav.rig import Rig

ROTATION_RAD = math.radians(0.3)
FOCAL_FACTOR = 1.02


def turned(rig: Rig, camera: int, axis: int) -> Rig:
    """The rig with one camera turned by ROTATION_RAD about an axis of its own, 0 x to 2 z; W stays where it is."""
    rotation = np.zeros(3)
    rotation[axis] = ROTATION_RAD
    T = rig.T_world_cam[camera].copy()
    T[:3, :3] = T[:3, :3] @ exp(rotation)
    transforms: list[FloatArray] = list(rig.T_world_cam)
    transforms[camera] = T
    return attrs.evolve(rig, T_world_cam=transforms)


def scaled(rig: Rig, camera: int) -> Rig:
    """The rig with both focal lengths of one camera longer by FOCAL_FACTOR."""
    model = rig.cameras[camera]
    cameras = list(rig.cameras)
    cameras[camera] = attrs.evolve(model, fx=FOCAL_FACTOR * model.fx, fy=FOCAL_FACTOR * model.fy)
    return attrs.evolve(rig, cameras=cameras)
