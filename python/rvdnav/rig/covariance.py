"""The parameters of a rig's calibration and their covariance."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from rvdnav.pose.arrays import FloatArray, float_array

CAMERA_PARAMETERS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2")
PAIR_PARAMETERS = ("rx", "ry", "rz", "tx", "ty", "tz")
_STEPS = {"f": 1e-2, "c": 1e-2, "k": 1e-5, "p": 1e-5, "r": 1e-6, "t": 1e-6}
# Of correlations: what the rounding of a written matrix may do.
_ROUNDING = 1e-6


def calibration_parameters(cameras: int) -> tuple[str, ...]:
    """Names of the calibration's parameters, in the order of every covariance and change of them.

    For each camera fx, fy, cx, cy (px), k1, k2, p1, p2; for two then (rx, ry, rz), rad, the d of R_cam1_cam0 =
    exp([d]x) R̂, and the translation of T_cam1_cam0 (tx, ty, tz), m: 8 names for one camera, 22 for two.
    """
    own = [f"cam{camera}.{name}" for camera in range(cameras) for name in CAMERA_PARAMETERS]
    return (*own, *(f"cam1_cam0.{name}" for name in PAIR_PARAMETERS)) if cameras == 2 else tuple(own)


def calibration_steps(cameras: int) -> FloatArray:
    """Changes (8,) or (22,) of the calibration's parameters that suit central differences by them."""
    return np.array([_STEPS[name.partition(".")[2][0]] for name in calibration_parameters(cameras)])


def calibration_covariance(matrix: ArrayLike, cameras: int) -> FloatArray:
    """A covariance (n, n) of the calibration's parameters, read-only.

    Raises ValueError when it has another size, is not finite, not symmetric or not positive semi-definite.
    """
    size = len(calibration_parameters(cameras))
    covariance = float_array(matrix, size, size)
    if (np.diagonal(covariance) < 0.0).any():
        raise ValueError("a variance is negative")
    # Of correlations, so that the units cancel; a parameter without variance is held fixed.
    sigma = np.sqrt(np.diagonal(covariance))
    units = np.outer(np.where(sigma > 0.0, sigma, 1.0), np.where(sigma > 0.0, sigma, 1.0))
    if (np.abs(covariance - covariance.T) > _ROUNDING * units).any():
        raise ValueError("it is not symmetric")
    if np.linalg.eigvalsh(covariance / units)[0] < -_ROUNDING * size:
        raise ValueError("it is not positive semi-definite")
    symmetric: FloatArray = 0.5 * (covariance + covariance.T)
    symmetric.setflags(write=False)
    return symmetric


# Of a calibration made by hand with a few pictures of a printed board: focal lengths as a part of themselves, and the
# rest in the units of the parameters; of the translation as a part of the baseline.
_HAND_FOCAL = 0.002
_HAND_SIGMA = {"c": 1.0, "k1": 0.01, "k2": 0.02, "p": 0.0005, "r": math.radians(0.03), "t": 0.001}


def hand_calibration_covariance(focal: float, baseline: float, cameras: int) -> FloatArray:
    """What stands for a covariance (n, n) that nobody has given; focal, px, baseline, m: of the rig.

    fx and fy of a camera err together, as all else does by itself.
    """
    names = [name.partition(".")[2] for name in calibration_parameters(cameras)]
    sigma = np.array([_HAND_SIGMA.get(name, _HAND_SIGMA.get(name[0], 0.0)) for name in names])
    sigma[[name[0] == "t" for name in names]] *= baseline
    covariance = np.diag(sigma**2)
    for camera in range(cameras):
        own = slice(8 * camera, 8 * camera + 2)
        covariance[own, own] = (_HAND_FOCAL * focal) ** 2 * np.array([[1.0, 0.99], [0.99, 1.0]])
    return covariance
