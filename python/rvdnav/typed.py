"""Whether values are what the annotations of their attrs classes say: for what was read from files."""

from __future__ import annotations

import types
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, Union, get_args, get_origin, get_type_hints

import attrs
import numpy as np


def check_type(value: Any, hint: Any, name: str) -> None:
    """Raise ValueError, naming the place, unless a value and all that it carries are as annotated.

    Understood are classes, None, unions, arrays of a type of number, and tuples, lists, sets and mappings of all these.
    An int counts as a float, a truth value as neither.
    """
    origin, parameters = get_origin(hint), get_args(hint)
    if hint is Any:
        return
    if origin in (Union, types.UnionType):
        _check_union(value, parameters, name)
    elif origin is np.ndarray:
        (number,) = get_args(parameters[1])
        if not isinstance(value, np.ndarray) or value.dtype != number:
            raise ValueError(f"{name} is no array of {number.__name__}")
    elif origin is not None:
        _check_container(value, origin, parameters, name)
    elif hint is float:
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            raise ValueError(f"{name} is no number")
    elif hint is None or hint is types.NoneType:
        if value is not None:
            raise ValueError(f"{name} is not null")
    elif not isinstance(value, hint) or (hint is int and isinstance(value, bool)):
        raise ValueError(f"{name} is no {hint.__name__}")
    elif attrs.has(hint):
        for field, field_hint in _fields(hint).items():
            check_type(getattr(value, field), field_hint, f"{name}.{field}")


def _check_union(value: Any, hints: tuple[Any, ...], name: str) -> None:
    others = [hint for hint in hints if hint is not types.NoneType]
    if value is None and len(others) < len(hints):
        return
    if len(others) == 1:  # which tells what is wrong within it
        return check_type(value, others[0], name)
    for hint in others:
        try:
            return check_type(value, hint, name)
        except ValueError:
            continue
    raise ValueError(f"{name} is of another type")


def _check_container(value: Any, origin: Any, hints: tuple[Any, ...], name: str) -> None:
    if not isinstance(value, origin):
        raise ValueError(f"{name} is no {origin.__name__}")
    if origin is tuple and hints[-1] is not ...:
        if len(value) != len(hints):
            raise ValueError(f"{name} has {len(value)} items, not {len(hints)}")
        items = list(zip(value, hints, strict=True))
    elif issubclass(origin, Mapping):
        items = [(part, hint) for item in value.items() for part, hint in zip(item, hints, strict=True)]
    else:
        items = [(item, hints[0]) for item in value]
    for item, hint in items:
        check_type(item, hint, f"an item of {name}")


@cache
def _fields(cls: type) -> dict[str, Any]:
    hints = get_type_hints(cls)
    return {field.name: hints[field.name] for field in attrs.fields(cls)}


def classes_within(hint: Any) -> Iterator[type]:
    """The classes that values of a type may be made of, as annotated; itself among them, some more than once."""
    if isinstance(hint, type) and get_origin(hint) is None:
        yield hint
        if attrs.has(hint):
            for field in _fields(hint).values():
                yield from classes_within(field)
    for parameter in get_args(hint):
        yield from classes_within(parameter)
