"""The camera rig: one or two calibrated cameras in the world W, what their calibration may err, and the rig's files."""

from rvdnav.rig.chain import CameraChain, check_side
from rvdnav.rig.covariance import calibration_parameters, calibration_steps
from rvdnav.rig.euroc import SENSOR, read_sensors
from rvdnav.rig.files import CAMCHAIN, RIG, load_rig, place_rig, save_rig
from rvdnav.rig.rig import MIN_BASELINE_M, Rig, world_from_camchain

__all__ = [
    "CAMCHAIN",
    "MIN_BASELINE_M",
    "RIG",
    "SENSOR",
    "CameraChain",
    "Rig",
    "calibration_parameters",
    "calibration_steps",
    "check_side",
    "load_rig",
    "place_rig",
    "read_sensors",
    "save_rig",
    "world_from_camchain",
]
