"""What the navigator says about one frame: health state, pose, covariance and the evidence behind them."""

from __future__ import annotations

import enum
from collections.abc import Iterable, Mapping
from typing import Any

import attrs
import numpy as np

from rvdnav.conventions import check_rigid
from rvdnav.corrections import Corrections
from rvdnav.errors import InputError
from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.euler import EulerAngles, euler_from_rotation
from rvdnav.typed import check_type

TOTAL = "total"
"""Name in ``Solution.stage_times`` of the whole process call; the stages of the two views overlap, so it is no sum."""


class State(enum.Enum):
    """Health of the navigation after a frame."""

    SEARCHING = "SEARCHING"
    """No target is held; every frame is searched without a prior."""
    TRACKING = "TRACKING"
    """This frame's own measurement passed every gate: its pose is published."""
    COASTING = "COASTING"
    """The target is held by prediction alone."""
    LOST = "LOST"
    """Coasting lasted too long; the next frame searches again."""


class Mode(enum.Enum):
    """Which views stand behind a published pose."""

    STEREO = "STEREO"
    MONO_LEFT = "MONO_LEFT"
    MONO_RIGHT = "MONO_RIGHT"


@enum.unique
class Reason(enum.Enum):
    """Why a frame was not published, or what was remarkable about it; the value is its one-line description."""

    NO_TARGET = "no bracket was found in the images"
    NO_PRIOR = "this target cannot be searched for: it needs a pose to start from"
    AMBIGUOUS = "two different poses explain the images about equally well"
    TOO_FEW_LINES = "too few edges of the target were measured"
    RESIDUALS = "the measured edges do not fit the model"
    DISPLACED = "edges of the bars were taken for their neighbours"
    CROSS_VIEW = "the two views contradict each other"
    COVARIANCE = "the geometry leaves the pose too uncertain"
    RANGE_GATE = "the range lies outside the gate"
    MOTION = "the motion since the last frame is not plausible"
    NOT_CONVERGED = "the refinement did not converge"
    DEGENERATE = "the measured geometry does not determine a pose"
    LEFT_MISSING = "there is no left image"
    RIGHT_MISSING = "there is no right image"
    LEFT_UNUSABLE = "the left image is black, saturated or without contrast"
    RIGHT_UNUSABLE = "the right image is black, saturated or without contrast"
    LIMIT = "a work limit was reached"
    TIME_ORDER = "the frame is not newer than the one before"
    UNKNOWN_SIZE = "the target's size is not known yet, and one camera cannot measure it"
    DUPLICATE = "an image is the one before once more"
    INTERLACED = "the images are interlaced, and rig.yaml does not say so"
    TARGET_TOLERANCE = "the target seems to differ from its file by more than its tolerance says"
    CALIBRATION = "the calibration seems to be off by more than its covariance says"

    @property
    def description(self) -> str:
        """One line in plain words."""
        return self.value


@attrs.frozen
class LineResidual:
    """How one edge of the target, seen by one camera, agrees with the solution.

    Residuals are measured minus predicted position across the edge, in rectified pixels; both are 0 without samples.
    """

    camera: int = attrs.field(validator=attrs.validators.in_((0, 1)))
    edge: str
    used: bool
    samples: int = attrs.field(validator=attrs.validators.ge(0))
    rms_px: float = 0.0
    mean_px: float = 0.0

    def __attrs_post_init__(self) -> None:
        if not (np.isfinite(self.rms_px) and np.isfinite(self.mean_px)):
            raise ValueError(f"residuals of {self.edge} in camera {self.camera} are not finite")


@attrs.frozen
class Acquisition:
    """What a search of the whole images for the bracket found.

    score: part of the bracket's edges that the best pose finds covered, 0 to 1.  runner_up: the score of the best
    clearly different pose, 0 if there was none.  hypotheses: number of poses that were tested.
    """

    score: float
    runner_up: float
    hypotheses: int


def _by_name(value: Mapping[str, float]) -> dict[str, float]:
    return {name: float(number) for name, number in value.items()}


@attrs.frozen
class LearnedDimensions:
    """What was learnt so far of the size of a target of unknown dimensions.

    sizes_m, sigmas_m: by the names of `rvdnav.trapezoid.DIMENSIONS`, m.  frames: that taught it.  known: well enough
    for one camera to navigate by it.  Raises ValueError for a number that is not positive.
    """

    sizes_m: dict[str, float] = attrs.field(converter=_by_name)
    sigmas_m: dict[str, float] = attrs.field(converter=_by_name)
    frames: int
    known: bool

    def __attrs_post_init__(self) -> None:
        if self.sizes_m.keys() != self.sigmas_m.keys():
            raise ValueError("sizes and their standard deviations differ in their names")
        for name, number in (*self.sizes_m.items(), *self.sigmas_m.items()):
            if not (np.isfinite(number) and number > 0.0):
                raise ValueError(f"the learnt {name} is not positive")


def _array(value: Any, shape: tuple[int, ...], what: str) -> FloatArray:
    array = np.array(value, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"{what} has shape {array.shape}, not {shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{what} is not finite")
    array.setflags(write=False)
    return array


def _pose(value: Any) -> FloatArray | None:
    if value is None:
        return None
    pose = _array(value, (4, 4), "a pose")
    try:
        check_rigid(pose)
    except ValueError as error:
        raise ValueError(f"a pose is no transform: {error}") from error
    return pose


def _covariance(value: Any) -> FloatArray | None:
    if value is None:
        return None
    covariance = _array(value, (6, 6), "a covariance")
    if not np.allclose(covariance, covariance.T, rtol=1e-6, atol=1e-15):
        raise ValueError("a covariance is not symmetric")
    if (np.diag(covariance) <= 0).any():
        raise ValueError("a variance is not positive")
    deviations = np.sqrt(np.diag(covariance))
    try:
        np.linalg.cholesky(covariance / np.outer(deviations, deviations))  # of correlations: the units cancel
    except np.linalg.LinAlgError:
        raise ValueError("a covariance is not positive definite") from None
    return covariance


def _view_lines(value: Mapping[int, Any]) -> dict[int, FloatArray]:
    lines: dict[int, FloatArray] = {}
    for camera in sorted(value):
        rows = np.asarray(value[camera], dtype=np.float64).reshape(-1, 4)
        lines[int(camera)] = _array(rows, rows.shape, "a drawn line")
    return lines


def _residuals(value: Iterable[LineResidual]) -> tuple[LineResidual, ...]:
    return tuple(value)


def _reasons(value: Iterable[Reason]) -> frozenset[Reason]:
    return frozenset(value)


def _stage_times(value: Mapping[str, float]) -> dict[str, float]:
    return dict(value)


def _same_view_lines(a: Mapping[int, FloatArray], b: Mapping[int, FloatArray]) -> bool:
    return a.keys() == b.keys() and all(np.array_equal(a[camera], b[camera]) for camera in a)


_EQ_ARRAY = attrs.cmp_using(eq=np.array_equal)


@attrs.frozen(kw_only=True)
class Solution:
    """The navigator's answer for one frame.

    Published <=> ``T_world_target`` is not None <=> ``state`` is TRACKING: never a pose that this frame's own images
    did not support.  Poses map the capture frame C to the world W (4x4, metres).  Covariances are 6x6 in the order
    (position, rotation): p = p_hat + dp, R = exp([dtheta]x) R_hat, both in W; units m^2, m rad, rad^2.

    Raises ValueError where the parts contradict each other.
    """

    timestamp_ns: int
    state: State
    mode: Mode | None = None
    """Set exactly while TRACKING."""
    reasons: frozenset[Reason] = attrs.field(default=frozenset(), converter=_reasons)
    T_world_target: FloatArray | None = attrs.field(default=None, converter=_pose, eq=_EQ_ARRAY)
    """The raw solution of this frame alone: what is published and judged."""
    predicted_T_world_target: FloatArray | None = attrs.field(default=None, converter=_pose, eq=_EQ_ARRAY)
    smoothed_T_world_target: FloatArray | None = attrs.field(default=None, converter=_pose, eq=_EQ_ARRAY)
    rival_T_world_target: FloatArray | None = attrs.field(default=None, converter=_pose, eq=_EQ_ARRAY)
    """The other one of the two poses that a single view of a planar target leaves, where it cannot be ruled out; the
    covariance of a published pose holds it."""
    covariance: FloatArray | None = attrs.field(default=None, converter=_covariance, eq=_EQ_ARRAY)
    """Of the published pose, else of the prediction."""
    acquisition: Acquisition | None = None
    """Where the whole images were searched."""
    dimensions: LearnedDimensions | None = None
    """Of a target of unknown dimensions, once there are any."""
    corrections: Corrections | None = None
    """Of target and calibration, with a published pose; None where both are known exactly."""
    line_residuals: tuple[LineResidual, ...] = attrs.field(default=(), converter=_residuals)
    sigma0: float | None = None
    """A-posteriori standard deviation of unit weight: 1 where the noise model fits."""
    view_lines: dict[int, FloatArray] = attrs.field(
        factory=dict, converter=_view_lines, eq=attrs.cmp_using(eq=_same_view_lines)
    )
    """Camera index -> (n, 4) measured segments x0, y0, x1, y1 in rectified pixels, for drawing."""
    stage_times: dict[str, float] = attrs.field(factory=dict, converter=_stage_times, eq=False)
    """Stage name -> wall time in seconds, ``TOTAL`` for the whole call; the only part that differs between two runs."""

    def __attrs_post_init__(self) -> None:
        tracking = self.state is State.TRACKING
        if tracking != (self.T_world_target is not None):
            raise ValueError("a pose is published exactly while TRACKING")
        if tracking != (self.mode is not None):
            raise ValueError("a mode is given exactly while TRACKING")
        if tracking and self.covariance is None:
            raise ValueError("a published pose needs its covariance")
        if self.covariance is not None and not tracking and self.predicted_T_world_target is None:
            raise ValueError("a covariance needs the pose that it belongs to")
        if self.corrections is not None and not tracking:
            raise ValueError("corrections belong to a published pose")
        if self.sigma0 is not None and not np.isfinite(self.sigma0):
            raise ValueError("sigma0 is not finite")

    @property
    def published(self) -> bool:
        """Whether this frame's pose may be used."""
        return self.T_world_target is not None

    @property
    def euler(self) -> EulerAngles | None:
        """Attitude angles (phi, theta, psi) of the published pose, radians (paper eqs. 9-10)."""
        return None if self.T_world_target is None else euler_from_rotation(self.T_world_target[:3, :3])

    def to_json(self) -> dict[str, Any]:
        """As an object for ``json.dumps``: finite numbers, fixed key order, wall times alone under the last key."""
        euler = self.euler
        return {
            "timestamp_ns": int(self.timestamp_ns),
            "state": self.state.name,
            "mode": None if self.mode is None else self.mode.name,
            "reasons": sorted(reason.name for reason in self.reasons),
            "T_world_target": _listed(self.T_world_target),
            "predicted_T_world_target": _listed(self.predicted_T_world_target),
            "smoothed_T_world_target": _listed(self.smoothed_T_world_target),
            "rival_T_world_target": _listed(self.rival_T_world_target),
            "euler": None if euler is None else {name: float(angle) for name, angle in euler._asdict().items()},
            "covariance": _listed(self.covariance),
            "acquisition": None if self.acquisition is None else attrs.asdict(self.acquisition),
            "dimensions": None if self.dimensions is None else attrs.asdict(self.dimensions),
            "corrections": None if self.corrections is None else self.corrections.to_json(),
            "sigma0": None if self.sigma0 is None else float(self.sigma0),
            "line_residuals": [
                {
                    "camera": int(line.camera),
                    "edge": line.edge,
                    "used": bool(line.used),
                    "samples": int(line.samples),
                    "rms_px": float(line.rms_px),
                    "mean_px": float(line.mean_px),
                }
                for line in self.line_residuals
            ],
            "view_lines": {str(camera): lines.tolist() for camera, lines in self.view_lines.items()},
            "stage_times_s": {stage: float(seconds) for stage, seconds in self.stage_times.items()},
        }

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Solution:
        """The inverse of ``to_json``.  Raises InputError naming the fault (the caller knows the file)."""
        try:
            solution = cls(
                timestamp_ns=data["timestamp_ns"],
                state=State[data["state"]],
                mode=None if data["mode"] is None else Mode[data["mode"]],
                reasons=frozenset(Reason[name] for name in data["reasons"]),
                T_world_target=data["T_world_target"],
                predicted_T_world_target=data["predicted_T_world_target"],
                smoothed_T_world_target=data["smoothed_T_world_target"],
                rival_T_world_target=data["rival_T_world_target"],
                covariance=data["covariance"],
                acquisition=None if data["acquisition"] is None else Acquisition(**data["acquisition"]),
                dimensions=None if data["dimensions"] is None else LearnedDimensions(**data["dimensions"]),
                corrections=None if data["corrections"] is None else Corrections.from_json(data["corrections"]),
                sigma0=data["sigma0"],
                line_residuals=tuple(LineResidual(**line) for line in data["line_residuals"]),
                view_lines={int(camera): lines for camera, lines in data["view_lines"].items()},
                stage_times=data["stage_times_s"],
            )
            check_type(solution, cls, "the solution")
        except KeyError as error:
            raise InputError(f"unknown or missing {error.args[0]!r} in a solution") from error
        except (AttributeError, OverflowError, TypeError, ValueError) as error:
            raise InputError(f"not a solution: {error}") from error
        return solution


def _listed(array: FloatArray | None) -> list[Any] | None:
    return None if array is None else array.tolist()
