"""Calibration of the stereo rig from pictures of a flat board."""

from rvdnav.calibration.board import Board
from rvdnav.calibration.calibrate import Calibration, CalibrationError, calibrate
from rvdnav.calibration.sources import ImagePair, read_pairs
from rvdnav.calibration.views import Dropped

__all__ = ["Board", "Calibration", "CalibrationError", "Dropped", "ImagePair", "calibrate", "read_pairs"]
