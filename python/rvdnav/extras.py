"""What optional features import: packages of the extras that `pyproject.toml` names."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from rvdnav.errors import InputError


@contextmanager
def needs_extra(extra: str, what: str) -> Iterator[None]:
    """For imports of the packages of an extra, which `what` needs.  Raises InputError where one cannot be imported."""
    try:
        yield
    except ImportError as error:
        raise InputError(f"{what}: {error}; install rvdnav with the extra '{extra}'") from error
