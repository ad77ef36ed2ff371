"""The one place that parses JSON, with limits that hold for any text and what our own files never hold refused."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NoReturn

from rvdnav.files import UNPRINTABLE, write_text_atomically

_DEEPEST = 30
_LARGEST_WHOLE = 2**63


def parse_object(text: str) -> dict[str, Any]:
    """The object that a JSON text holds.

    Raises ValueError saying in one line what is wrong: no JSON or no object, a key given twice, NaN, a number beyond
    64 bits, a text with control characters, or lists and objects nested too deep.
    """
    try:
        data = json.loads(text, object_pairs_hook=_object, parse_constant=_constant, parse_int=_whole)
    except json.JSONDecodeError as error:
        raise ValueError(f"not JSON: {error}") from error
    except RecursionError as error:
        raise ValueError(f"nested more than {_DEEPEST} deep") from error
    if not isinstance(data, dict):
        raise ValueError("not an object")
    _check(data, 0)
    return data


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    data = dict(pairs)
    if len(data) < len(pairs):
        names = [name for name, _ in pairs]
        raise ValueError(f"{next(name for name in names if names.count(name) > 1)!r} is given twice")
    return data


def _constant(text: str) -> NoReturn:
    raise ValueError(f"{text} is no number")


def _whole(text: str) -> int:
    if len(text) > 20 or abs(int(text)) > _LARGEST_WHOLE:
        raise ValueError(f"the number {text} has more than 64 bits")
    return int(text)


def _check(value: Any, depth: int) -> None:
    if depth > _DEEPEST:
        raise ValueError(f"nested more than {_DEEPEST} deep")
    if isinstance(value, str):
        if UNPRINTABLE.search(value):
            raise ValueError(f"a text with control characters, {value[:20]!r}")
    elif isinstance(value, dict):
        for key, item in value.items():
            _check(key, depth)
            _check(item, depth + 1)
    elif isinstance(value, list):
        for item in value:
            _check(item, depth + 1)


def write_json(path: Path, record: Mapping[str, Any]) -> None:
    """Write an object of finite numbers as a file, whole or not at all.  Raises InputError if it cannot be written."""
    write_text_atomically(path, json.dumps(record, indent=1, allow_nan=False) + "\n")
