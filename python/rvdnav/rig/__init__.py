"""The camera rig: one or two calibrated cameras in the world W, what their calibration may err, and the rig's files."""

from rvdnav.rig.covariance import calibration_parameters, calibration_steps
from rvdnav.rig.files import CAMCHAIN, RIG, load_rig, save_rig
from rvdnav.rig.rig import MIN_BASELINE_M, Rig, world_from_camchain

__all__ = [
    "CAMCHAIN",
    "MIN_BASELINE_M",
    "RIG",
    "Rig",
    "calibration_parameters",
    "calibration_steps",
    "load_rig",
    "save_rig",
    "world_from_camchain",
]
