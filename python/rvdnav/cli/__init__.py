"""The command line: ``rvdnav``."""

from rvdnav.cli.app import main

__all__ = ["main"]
