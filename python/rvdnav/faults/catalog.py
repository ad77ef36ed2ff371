"""The faults by name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import attrs
import numpy as np

from rvdnav.faults import calibration, delivery, pixels
from rvdnav.faults.delivery import LEFT, RIGHT, Delivery, Strikes
from rvdnav.faults.region import Region
from rvdnav.images import PixelArray
from rvdnav.rig import Rig

_BOTH = (LEFT, RIGHT)
_SIDES = {"left": (LEFT,), "right": (RIGHT,), "both": _BOTH}


@attrs.frozen
class PixelFault:
    """What is done to the images of some cameras."""

    effect: Callable[[PixelArray, Region, np.random.Generator], PixelArray]
    cameras: tuple[int, ...]


def _in_one_or_both(name: str, effect: Callable[..., PixelArray]) -> dict[str, PixelFault]:
    return {
        f"{name}_left": PixelFault(effect, (LEFT,)),
        f"{name}_right": PixelFault(effect, (RIGHT,)),
        name: PixelFault(effect, _BOTH),
    }


def _miscalibrations() -> dict[str, Callable[[Rig], Rig]]:
    faults: dict[str, Callable[[Rig], Rig]] = {}
    for side, cameras in _SIDES.items():
        for axis, name in enumerate("xyz"):
            faults[f"miscalibrated_{side}_{name}"] = partial(
                _each, [partial(calibration.turned, camera=camera, axis=axis) for camera in cameras]
            )
        faults[f"miscalibrated_{side}_focal"] = partial(
            _each, [partial(calibration.scaled, camera=camera) for camera in cameras]
        )
    return faults


def _each(changes: list[Callable[[Rig], Rig]], rig: Rig) -> Rig:
    for change in changes:
        rig = change(rig)
    return rig


DELIVERY_FAULTS: dict[str, Callable[[list[Delivery], Strikes], list[Delivery]]] = {
    "dropped": delivery.dropped,
    "duplicated": delivery.duplicated,
    "late": delivery.late,
    "left_behind": delivery.left_behind,
    "right_behind": delivery.right_behind,
    "swapped": delivery.swapped,
}
PIXEL_FAULTS: dict[str, PixelFault] = {
    **_in_one_or_both("black", pixels.black),
    **_in_one_or_both("saturated", pixels.saturated),
    "glare": PixelFault(pixels.glare, _BOTH),
    "occluder_middle": PixelFault(pixels.occluder_middle, _BOTH),
    "occluder_side": PixelFault(pixels.occluder_side, _BOTH),
    "noise_x4": PixelFault(pixels.noise_x4, _BOTH),
    "gain_0.3": PixelFault(pixels.gain_0_3, _BOTH),
    "gain_2": PixelFault(pixels.gain_2, _BOTH),
    **_in_one_or_both("corrupted_rows", pixels.corrupted_rows),
}
CALIBRATION_FAULTS: dict[str, Callable[[Rig], Rig]] = _miscalibrations()
FAULT_NAMES: tuple[str, ...] = (*DELIVERY_FAULTS, *PIXEL_FAULTS, *CALIBRATION_FAULTS)
"""Every name that `parse_fault` knows."""
STEREO_FAULTS: tuple[str, ...] = tuple(
    name for name in FAULT_NAMES if name == "swapped" or "right" in name or name.startswith("miscalibrated_both")
)
"""Those that need a second camera."""
