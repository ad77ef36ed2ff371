"""How the target moves: one course a coordinate, and the poses along them."""

from __future__ import annotations

import math

import attrs
import numpy as np

from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.euler import EulerAngles, rotation_from_euler
from rvdnav.pose.so3 import make_T


@attrs.frozen
class Course:
    """One coordinate over time: from start to end, with a sine on top.

    ease: 0 for constant speed, 1 for a motion that starts and ends at rest; between them the speed varies less.
    amplitude in the unit of start and end, period, s, phase, rad, of the sine.
    """

    start: float = 0.0
    end: float = 0.0
    ease: float = 0.0
    amplitude: float = 0.0
    period: float = math.inf
    phase: float = 0.0

    def at(self, time: float, duration: float) -> float:
        """The value at a time, s, of a motion that takes `duration`, s."""
        done = time / duration if duration > 0.0 else 0.0
        done = (1.0 - self.ease) * done + self.ease * done * done * (3.0 - 2.0 * done)
        wave = self.amplitude * math.sin(2.0 * math.pi * time / self.period + self.phase)
        return self.start + (self.end - self.start) * done + wave


@attrs.frozen
class Motion:
    """The courses of the target's origin, m in W, and of its attitude angles (paper, eq. 9), rad.

    The paper's experiment: varying speed along x, a sine along z.
    """

    x: Course
    y: Course = Course()
    z: Course = Course()
    phi: Course = Course()
    theta: Course = Course()
    psi: Course = Course()

    def T_world_target(self, time: float, duration: float) -> FloatArray:
        """The pose (4, 4) at a time, s."""
        position = np.array([course.at(time, duration) for course in (self.x, self.y, self.z)])
        angles = [course.at(time, duration) for course in (self.phi, self.theta, self.psi)]
        return make_T(rotation_from_euler(EulerAngles(*angles)), position)
