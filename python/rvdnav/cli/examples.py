"""The examples, where a command takes one by default."""

from __future__ import annotations

import os
from pathlib import Path

import rvdnav
from rvdnav.errors import InputError


def example(name: str) -> Path:
    """The example of that path in `examples`, beside the working folder or in the checkout that the package is from.

    Raises InputError where there is none.
    """
    path = Path("examples") / name
    for root in (Path(), Path(rvdnav.__file__).resolve().parents[2]):
        if os.path.exists(root / path):
            return root / path
    raise InputError(f"{path}: no such file or folder; name another")
