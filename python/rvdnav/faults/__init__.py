"""Fault injection: a recorded sequence played back with named faults, the same ones in every run."""

from rvdnav.faults.catalog import FAULT_NAMES, STRENGTHS
from rvdnav.faults.fault import Fault, parse_fault
from rvdnav.faults.faulty_sequence import FaultySequence
from rvdnav.faults.response import Response

__all__ = ["FAULT_NAMES", "STRENGTHS", "Fault", "FaultySequence", "Response", "parse_fault"]
