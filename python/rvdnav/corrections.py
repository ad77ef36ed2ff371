"""What the frames so far say of a calibration and a target that are known to a tolerance only."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import attrs


def _numbers(value: Any) -> tuple[float, ...]:
    return value if isinstance(value, tuple) else (value,)


def _finite(instance: object, attribute: attrs.Attribute[Any], value: Any) -> None:
    if not all(map(math.isfinite, _numbers(value))):
        raise ValueError(f"{attribute.name} is not finite")


def _positive(instance: object, attribute: attrs.Attribute[Any], value: Any) -> None:
    if not all(0.0 < number < math.inf for number in _numbers(value)):
        raise ValueError(f"{attribute.name} is not positive")


@attrs.frozen
class ParameterCorrection:
    """Of one parameter of the calibration, in its unit: px, m, rad, or none for the lens.

    value: to be added to what was stated.  sigma: standard deviation of the parameter with this correction; stated:
    without it, as it was stated.
    """

    value: float = attrs.field(validator=_finite)
    sigma: float = attrs.field(validator=_positive)
    stated: float = attrs.field(validator=_positive)

    @property
    def in_stated(self) -> float:
        """The correction's size in stated standard deviations."""
        return abs(self.value) / self.stated


def _triple(value: Any) -> tuple[float, ...]:
    return tuple(value)


@attrs.frozen
class PointCorrection:
    """Of one point of the target, m, along the axes of its frame C.

    value: to be added to what was stated.  sigma: standard deviations of the coordinates with this correction; stated:
    of each of them without it, as it was stated.
    """

    value: tuple[float, float, float] = attrs.field(converter=_triple, validator=_finite)
    sigma: tuple[float, float, float] = attrs.field(converter=_triple, validator=_positive)
    stated: float = attrs.field(validator=_positive)

    @property
    def in_stated(self) -> float:
        """The size of its largest coordinate in stated standard deviations."""
        return max(map(abs, self.value)) / self.stated


@attrs.frozen
class Corrections:
    """Of all that is not known exactly, as a published frame and those before it tell.

    calibration: by the names of `rvdnav.rig.calibration_parameters`.  points: by the target's names.
    calibration_scale, target_scale: how many times larger than stated the standard deviations of all of them together
    seem to be; 1 where there are none.  calibration_distance, target_distance: the largest correction of any
    combination of them that the images tell apart, in its stated standard deviation.  frames: that taught it.  What no
    image tells is not corrected, and its sigma is the stated one times the scale.  Raises ValueError for numbers that
    are not finite, and standard deviations and scales that are not positive.
    """

    calibration: dict[str, ParameterCorrection]
    points: dict[str, PointCorrection]
    calibration_scale: float = attrs.field(validator=_positive)
    target_scale: float = attrs.field(validator=_positive)
    calibration_distance: float = attrs.field(validator=_finite)
    target_distance: float = attrs.field(validator=_finite)
    frames: int

    def to_json(self) -> dict[str, Any]:
        """As an object for ``json.dumps``."""
        return attrs.asdict(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Corrections:
        """The inverse of ``to_json``.  Raises TypeError, ValueError or AttributeError for what is none."""
        calibration = {name: ParameterCorrection(**own) for name, own in data["calibration"].items()}
        points = {name: PointCorrection(**own) for name, own in data["points"].items()}
        return cls(**{**data, "calibration": calibration, "points": points})
