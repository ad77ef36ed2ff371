"""A constant-velocity filter on the target's pose; its prediction opens the next frame's search windows.

Error-state Kalman filter on position, rotation, linear and angular velocity, all in W.  The error is that of every
covariance here: p = p̂ + dp, R = exp([dtheta]x) R̂.
References: J. Solà, "Quaternion kinematics for the error-state Kalman filter" (2017), with global angular errors;
Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to Tracking and Navigation" (2001), section 6.2.
"""

from __future__ import annotations

import numpy as np
from attrs import frozen

from rvdnav.pose.arrays import FloatArray, float_array
from rvdnav.pose.errors import PoseError
from rvdnav.pose.so3 import difference, exp, left_jacobian, make_T, perturb, project_to_so3

_INITIAL_LINEAR_SIGMA = 0.3
_INITIAL_ANGULAR_SIGMA = 0.3


@frozen(eq=False)
class PredictedPose:
    """T_world_target (4, 4) and its covariance (6, 6), order (position, rotation) in W; m², m·rad, rad²."""

    T_world_target: FloatArray
    covariance: FloatArray


@frozen(eq=False)
class FilterState:
    """What the filter knows at timestamp_ns: pose T (4, 4) = T_world_target; velocity (6,): linear, m/s, and angular,
    rad/s, in W; covariance (12, 12) in the order position, rotation, linear velocity, angular velocity."""

    timestamp_ns: int
    T: FloatArray
    velocity: FloatArray
    covariance: FloatArray


class ConstantVelocityFilter:
    """Filter and predictor of the target's pose under nearly constant linear and angular velocity.

    linear_acceleration_density, m/s²/√Hz, and angular_acceleration_density, rad/s²/√Hz: root of the power spectral
    density of the white accelerations that stand for the manoeuvres.  It starts at the first update with zero velocity
    and standard deviations of 0.3 m/s and 0.3 rad/s.
    """

    def __init__(self, linear_acceleration_density: float = 0.05, angular_acceleration_density: float = 0.1) -> None:
        densities = np.repeat([linear_acceleration_density, angular_acceleration_density], 3)
        self._spectrum: FloatArray = densities**2
        self.state: FilterState | None = None
        """None before the first update; may be set to take up a filter that was left."""

    @property
    def initialised(self) -> bool:
        """Whether there was an update since the start or the last reset."""
        return self.state is not None

    @property
    def smoothed(self) -> PredictedPose:
        """The filtered pose at the last update.  Raises PoseError before the first."""
        state = self._started()
        return PredictedPose(state.T, state.covariance[:6, :6])

    @property
    def linear_velocity(self) -> FloatArray:
        """Velocity of the target's origin (3,) in W at the last update, m/s.  Raises PoseError before the first."""
        return self._started().velocity[:3]

    @property
    def angular_velocity(self) -> FloatArray:
        """Angular velocity of the target (3,) in W at the last update, rad/s.  Raises PoseError before the first."""
        return self._started().velocity[3:]

    def reset(self) -> None:
        """Forget everything; the next update starts anew."""
        self.state = None

    def loosen(self) -> None:
        """Believe the velocity no better than at the start: the target has not moved as it did.

        Raises PoseError before the first update.
        """
        state = self._started()
        covariance = state.covariance.copy()
        covariance[6:, 6:] += np.diag(np.repeat([_INITIAL_LINEAR_SIGMA, _INITIAL_ANGULAR_SIGMA], 3) ** 2)
        self.state = FilterState(state.timestamp_ns, state.T, state.velocity, covariance)

    def predict(self, timestamp_ns: int) -> PredictedPose:
        """The pose expected at a time not before the last update; the filter itself stays where it is.

        Raises PoseError before the first update and for an earlier time.
        """
        state = self._propagated(timestamp_ns)
        return PredictedPose(state.T, state.covariance[:6, :6])

    def update(self, timestamp_ns: int, T_world_target: FloatArray, covariance: FloatArray) -> None:
        """Take in a measured pose (4, 4) with its covariance (6, 6), order (position, rotation) in W.

        Raises PoseError if the time is not after the last update, or the covariance is not positive definite.
        """
        T = float_array(T_world_target, 4, 4)
        noise = float_array(covariance, 6, 6)
        if not (np.linalg.eigvalsh(noise) > 0.0).all():
            raise PoseError("the covariance of a measured pose is not positive definite")
        if self.state is None:
            initial = np.repeat([_INITIAL_LINEAR_SIGMA, _INITIAL_ANGULAR_SIGMA], 3) ** 2
            zero = np.zeros((6, 6))
            self.state = FilterState(timestamp_ns, T, np.zeros(6), np.block([[noise, zero], [zero, np.diag(initial)]]))
            return
        if timestamp_ns == self.state.timestamp_ns:
            raise PoseError("two measured poses have the same timestamp")
        prior = self._propagated(timestamp_ns)
        P = prior.covariance
        gain = np.linalg.solve(P[:6, :6] + noise, P[:6]).T
        correction = gain @ difference(T, prior.T)
        # Joseph's form: stays symmetric and positive definite whatever the rounding of the gain.
        keep = np.eye(12)
        keep[:, :6] -= gain
        posterior = keep @ P @ keep.T + gain @ noise @ gain.T
        corrected = perturb(prior.T, correction[:6])
        self.state = FilterState(
            timestamp_ns,
            make_T(project_to_so3(corrected[:3, :3]), corrected[:3, 3]),
            prior.velocity + correction[6:],
            (posterior + posterior.T) / 2.0,
        )

    def _started(self) -> FilterState:
        if self.state is None:
            raise PoseError("the filter has seen no pose yet")
        return self.state

    def _propagated(self, timestamp_ns: int) -> FilterState:
        state = self._started()
        dt = (timestamp_ns - state.timestamp_ns) * 1e-9
        if dt < 0.0:
            raise PoseError("the time runs backwards: it is before the filter's last pose")
        turn = state.velocity[3:] * dt
        F = np.eye(12)
        F[3:6, 3:6] = exp(turn)
        F[:3, 6:9] = dt * np.eye(3)
        F[3:6, 9:] = dt * left_jacobian(turn)
        # White acceleration, integrated once into the velocity and twice into the pose.
        pose, cross, rate = (np.diag(self._spectrum * dt**power / power) for power in (3, 2, 1))
        Q = np.block([[pose, cross], [cross, rate]])
        covariance = F @ state.covariance @ F.T + Q
        return FilterState(timestamp_ns, perturb(state.T, state.velocity * dt), state.velocity, covariance)
