"""Stereo-vision navigation for spacecraft rendezvous and docking.

    import rvdnav
    sequence = rvdnav.open_sequence("examples/approach")
    navigator = rvdnav.Navigator(sequence.rig, sequence.target)
    for frame in sequence:
        solution = navigator.process(frame)

Names are imported when first used, so that the pose mathematics alone needs neither the C core nor OpenCV.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rvdnav.camera import CameraModel
    from rvdnav.errors import CoreError, InputError, RvdnavError
    from rvdnav.navigator import Navigator
    from rvdnav.rig import Rig, load_rig
    from rvdnav.sequence import Frame, Sequence, open_sequence
    from rvdnav.solution import Mode, Reason, Solution, State
    from rvdnav.target import Target, load_target

__version__ = "0.1.0"

_HOME = {
    "CameraModel": "camera",
    "CoreError": "errors",
    "InputError": "errors",
    "RvdnavError": "errors",
    "Navigator": "navigator",
    "Rig": "rig",
    "load_rig": "rig",
    "Frame": "sequence",
    "Sequence": "sequence",
    "open_sequence": "sequence",
    "Mode": "solution",
    "Reason": "solution",
    "Solution": "solution",
    "State": "solution",
    "Target": "target",
    "load_target": "target",
}

__all__ = [
    "CameraModel",
    "CoreError",
    "Frame",
    "InputError",
    "Mode",
    "Navigator",
    "Reason",
    "Rig",
    "RvdnavError",
    "Sequence",
    "Solution",
    "State",
    "Target",
    "load_rig",
    "load_target",
    "open_sequence",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'rvdnav' has no attribute {name!r}")
    value = getattr(import_module(f"rvdnav.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
