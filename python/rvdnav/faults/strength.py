"""How strong a fault is: the numbers that a user gives with its name, and their limits."""

from __future__ import annotations

import math

import attrs

from rvdnav.errors import InputError


@attrs.frozen
class Strength:
    """One number of a fault's strength: what it is, its unit or "", and the limits that it lies within."""

    name: str
    unit: str
    low: float
    high: float
    optional: bool = False


def parse_strengths(given: str | None, wanted: tuple[Strength, ...]) -> tuple[float, ...]:
    """The numbers of a text such as ``0.05,0.3,0.01``; optional ones may be left out from the end.

    Raises InputError for a number that is none, beyond its limits, missing, or too many.
    """
    texts = [] if given is None else given.split(",")
    required = sum(not strength.optional for strength in wanted)
    if not required <= len(texts) <= len(wanted):
        listed = ", ".join(
            s.name + (f" ({s.unit})" if s.unit else "") + (" if wanted" if s.optional else "") for s in wanted
        )
        raise InputError(f"its strength is {listed}" if wanted else "it has no strength")
    values = []
    for text, strength in zip(texts, wanted, strict=False):
        value = _number(text)
        if value is None or not strength.low <= value <= strength.high:
            limits = f"from {strength.low:g} to {strength.high:g} {strength.unit}".rstrip()
            raise InputError(f"{strength.name} {text!r} is no number {limits}")
        values.append(value)
    return tuple(values)


def _number(text: str) -> float | None:
    if not text.isascii() or "_" in text:
        return None
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None
