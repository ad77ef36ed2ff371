"""Faults of what a navigator is told: a rig and a target that are not quite those of the images, which stay.

Errors that leave no rig or no target raise ValueError.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from rvdnav.pose.arrays import FloatArray
from rvdnav.rig import Rig, calibration_parameters
from rvdnav.target import Target
from rvdnav.trapezoid import Trapezoid

_M_PER_MM = 1e-3


def calibration(rig: Rig, rng: np.random.Generator, focal_percent: float, centre_px: float, turn_deg: float) -> Rig:
    """Normal errors of these standard deviations: of each camera's focal length (fx and fy alike) and of both
    coordinates of its principal point, and of the rotation between the cameras about each axis."""
    delta = np.zeros(len(calibration_parameters(len(rig.cameras))))
    for index, camera in enumerate(rig.cameras):
        factor = 0.01 * focal_percent * rng.standard_normal()
        delta[8 * index : 8 * index + 2] = factor * np.array([camera.fx, camera.fy])
        delta[8 * index + 2 : 8 * index + 4] = centre_px * rng.standard_normal(2)
    if rig.is_stereo:
        delta[16:19] = math.radians(turn_deg) * rng.standard_normal(3)
    return rig.perturbed(delta)


def target_sizes(target: Target, rng: np.random.Generator, sigma_mm: float) -> Target:
    """Sizes off by normal errors: a bracket's bases, height, bar widths and thickness; any other target is stretched
    along each axis of C by what takes such an error over its whole extent."""
    sigma = _M_PER_MM * sigma_mm
    bracket = target.bracket
    if bracket is None:
        points = np.array(list(target.points.values()))
        extents = np.maximum(np.ptp(points, axis=0), _M_PER_MM)
        return _with_points(target, points * (1.0 + sigma * rng.standard_normal(3) / extents))
    widths = bracket.bar_widths.mean(axis=1)
    sizes = np.array([bracket.long_base, bracket.short_base, bracket.heights.mean(), *widths[:2], widths[2:].mean()])
    changed = sizes + sigma * rng.standard_normal(len(sizes))
    shift = np.concatenate(Trapezoid.of(changed).apexes) - np.concatenate(Trapezoid.of(sizes).apexes)
    by_corner = np.concatenate([bracket.outer, bracket.inner])
    moved = {
        name: p + shift[int(np.argmin(np.linalg.norm(by_corner - p, axis=1)))] for name, p in target.points.items()
    }
    return _thickened(_with_points(target, np.array(list(moved.values()))), sigma * rng.standard_normal())


def target_points(target: Target, rng: np.random.Generator, sigma_mm: float) -> Target:
    """Every point off by normal errors of its own: in the front plane for a bracket, whose thickness errs as well; in
    all directions for another target."""
    sigma = _M_PER_MM * sigma_mm
    points = np.array(list(target.points.values()))
    errors = sigma * rng.standard_normal(points.shape)
    if target.bracket is None:
        return _with_points(target, points + errors)
    errors[:, 0] = 0.0
    return _thickened(_with_points(target, points + errors), sigma * rng.standard_normal())


def _with_points(target: Target, points: FloatArray) -> Target:
    return attrs.evolve(target, points=dict(zip(target.points, points, strict=True)))


def _thickened(target: Target, change: float) -> Target:
    return attrs.evolve(target, bar_thickness=max(target.bar_thickness + change, 0.0))
