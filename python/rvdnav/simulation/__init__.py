"""Simulation: scenarios rendered into stereo sequences with known truth.  Rendering needs the extra `rvdnav[sim]`."""

from rvdnav.simulation.course import Course, Motion
from rvdnav.simulation.producer import simulate
from rvdnav.simulation.scenario import Background, Files, Lights, Scenario, Sensor
from rvdnav.simulation.scenario_file import load_scenario
from rvdnav.simulation.solids import box_target, bracket_target

__all__ = [
    "Background",
    "Course",
    "Files",
    "Lights",
    "Motion",
    "Scenario",
    "Sensor",
    "box_target",
    "bracket_target",
    "load_scenario",
    "simulate",
]
