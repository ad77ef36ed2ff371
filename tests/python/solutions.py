"""Made-up runs for the tests of what comes after the navigator."""

from __future__ import annotations

import numpy as np
from rvdnav.solution import LineResidual, Mode, Reason, Solution, State
from scipy.spatial.transform import Rotation

SIGMAS = np.array([2e-3, 1e-3, 1e-3, 4e-3, 8e-3, 8e-3])


class Truth(dict):
    """True poses by timestamp."""

    def at(self, timestamp_ns):
        return self.get(timestamp_ns)


def transform(position, rotation_vector=(0, 0, 0)):
    """4x4 of a position and an active rotation vector."""
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(rotation_vector).as_matrix()
    T[:3, 3] = position
    return T


def perturbed(T, error):
    """T moved by error = (position, rotation vector), both in W."""
    return transform(
        T[:3, 3] + error[:3], (Rotation.from_rotvec(error[3:]) * Rotation.from_matrix(T[:3, :3])).as_rotvec()
    )


def true_poses(timestamps_ns):
    """An approach from 1.4 m, 4 cm a frame, with a slow turn."""
    return Truth(
        {ns: transform([1.4 - 0.04 * i, 0.01, 0.05], [0.01 * i, 0.1, -0.2]) for i, ns in enumerate(timestamps_ns)}
    )


def a_run(timestamps_ns, seed=5):
    """Searches once, tracks with errors drawn from its covariance, coasts over frame 5."""
    rng = np.random.default_rng(seed)
    covariance = np.diag(SIGMAS**2)
    solutions = []
    for i, (timestamp_ns, true) in enumerate(true_poses(timestamps_ns).items()):
        times = {"edges": 0.002, "refine": 0.004 + 0.001 * i, "total": 0.01}
        if i == 0:
            reasons = {Reason.AMBIGUOUS}
            solution = Solution(timestamp_ns=timestamp_ns, state=State.SEARCHING, reasons=reasons, stage_times=times)
        elif i == 5:
            solution = Solution(
                timestamp_ns=timestamp_ns,
                state=State.COASTING,
                reasons={Reason.TOO_FEW_LINES, Reason.LEFT_UNUSABLE},
                predicted_T_world_target=true,
                covariance=4 * covariance,
                stage_times=times,
            )
        else:
            solution = Solution(
                timestamp_ns=timestamp_ns,
                state=State.TRACKING,
                mode=Mode.STEREO,
                T_world_target=perturbed(true, rng.normal(size=6) * SIGMAS),
                covariance=covariance,
                line_residuals=(LineResidual(0, "l1_outer", True, 30, 0.05, 0.01),),
                view_lines={0: [[-10.0, -12.0, 10.0, -11.0]], 1: [[-9.0, -12.0, 11.0, -11.0]]},
                stage_times=times,
            )
        solutions.append(solution)
    return solutions


FRAMES = 8


class Scripted:
    """A navigator that gives the made-up run of 8 frames, so that what calls it is tested alone."""

    memory = None
    learned_target = None

    def __init__(self, rig, target, **options):
        self.run = None

    def process(self, frame):
        if self.run is None:
            self.run = iter(a_run([frame.timestamp_ns + 125_000_000 * i for i in range(FRAMES)]))
        return next(self.run)
