"""The faults by name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import attrs

from rvdnav.faults import calibration, delivery, electronics, knowledge, optics, pixels, scanning
from rvdnav.faults.delivery import LEFT, RIGHT, Delivery, Strikes
from rvdnav.faults.strength import Strength
from rvdnav.images import PixelArray
from rvdnav.rig import Rig
from rvdnav.target import Target

_BOTH = (LEFT, RIGHT)
_SIDES = {"left": (LEFT,), "right": (RIGHT,), "both": _BOTH}


@attrs.frozen
class PixelFault:
    """What is done to the images of some cameras: pixels, view, generator and strengths in, pixels out."""

    effect: Callable[..., PixelArray]
    cameras: tuple[int, ...] = _BOTH
    strengths: tuple[Strength, ...] = ()


def _in_one_or_both(name: str, effect: Callable[..., PixelArray], *strengths: Strength) -> dict[str, PixelFault]:
    sides = {f"{name}_left": (LEFT,), f"{name}_right": (RIGHT,), name: _BOTH}
    return {side: PixelFault(effect, cameras, strengths) for side, cameras in sides.items()}


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


_FIELD_DELAY = Strength("delay", "ms", -1000.0, 1000.0)
_SIZE_SIGMA = Strength("sigma", "mm", 0.0, 100.0)
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
    **_in_one_or_both("field_doubled", scanning.field_doubled),
    **_in_one_or_both("blur", optics.blurred, Strength("sigma", "px", 0.1, 30.0)),
    **_in_one_or_both(
        "motion_blur",
        optics.motion_blurred,
        Strength("length", "px", 0.0, 100.0),
        Strength("direction", "degrees", -360.0, 360.0, optional=True),
    ),
    **_in_one_or_both("flare", optics.flare, Strength("level", "grey levels", 0.0, 255.0)),
    **_in_one_or_both("vignetting", optics.vignetted, Strength("loss", "", 0.0, 1.0)),
    **_in_one_or_both("gamma", electronics.gamma, Strength("exponent", "", 0.05, 20.0)),
    **_in_one_or_both("sharpened", electronics.sharpened, Strength("factor", "", 0.0, 20.0)),
    **_in_one_or_both("jpeg", electronics.jpeg, Strength("quality", "", 1.0, 100.0)),
    **_in_one_or_both("noise", electronics.noise, Strength("sigma", "grey levels", 0.0, 128.0)),
    **_in_one_or_both("row_noise", electronics.row_noise, Strength("sigma", "grey levels", 0.0, 128.0)),
    **_in_one_or_both("hot_pixels", electronics.hot_pixels, Strength("share", "‰", 0.0, 1000.0)),
    **_in_one_or_both("grey_steps", electronics.grey_steps, Strength("step", "grey levels", 1.0, 128.0)),
    **_in_one_or_both("interlaced", scanning.interlaced, _FIELD_DELAY),
    **_in_one_or_both("interlaced_bottom", scanning.interlaced_bottom, _FIELD_DELAY),
    **_in_one_or_both("rolling_shutter", scanning.rolling_shutter, Strength("shear", "px", -200.0, 200.0)),
}
MISCALIBRATIONS: dict[str, Callable[[Rig], Rig]] = _miscalibrations()
"""Of a given size."""
RIG_FAULTS: dict[str, Callable[..., Rig]] = {"calibration": knowledge.calibration}
"""Of the calibration, at random: rig, generator and strengths in, rig out."""
TARGET_FAULTS: dict[str, Callable[..., Target]] = {
    "target_sizes": knowledge.target_sizes,
    "target_points": knowledge.target_points,
}
"""Of the target's description, at random: target, generator and strengths in, target out."""
KNOWLEDGE_FAULTS: tuple[str, ...] = (*MISCALIBRATIONS, *RIG_FAULTS, *TARGET_FAULTS)
"""Those that leave the images as they are."""
FAULT_NAMES: tuple[str, ...] = (*DELIVERY_FAULTS, *PIXEL_FAULTS, *KNOWLEDGE_FAULTS)
"""Every name that `parse_fault` knows."""
STRENGTHS: dict[str, tuple[Strength, ...]] = {
    **{name: fault.strengths for name, fault in PIXEL_FAULTS.items() if fault.strengths},
    "calibration": (
        Strength("focal length", "%", 0.0, 20.0),
        Strength("principal point", "px", 0.0, 1000.0),
        Strength("rotation", "degrees", 0.0, 20.0),
    ),
    **dict.fromkeys(TARGET_FAULTS, (_SIZE_SIGMA,)),
}
"""What the faults that are more or less strong are told, by name."""
STEREO_FAULTS: tuple[str, ...] = tuple(
    name for name in FAULT_NAMES if name == "swapped" or "right" in name or name.startswith("miscalibrated_both")
)
"""Those that need a second camera."""
