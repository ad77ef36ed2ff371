"""Values of the package as JSON and back, to the last bit.

attrs classes and enumerations of this package, numpy arrays and scalars, bytes, tuples, lists, dictionaries and sets,
nested as they like; so that whatever a class is given to carry is recorded without a word here.  Numbers are decimals
that read back exactly.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Callable
from functools import cache
from typing import Any, TypeVar

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.navigator.memory import Memory
from rvdnav.rig import Rig
from rvdnav.solution import Solution
from rvdnav.target import Target
from rvdnav.typed import check_type, classes_within

_Kind = TypeVar("_Kind")
_RECORDED = (Memory, Rig, Target, Solution)
"""With what they carry, the classes that a record may name: reading it makes no others."""
_PACKAGE = "rvdnav."
_NUMBERS = "biuf"
"""Kinds of numpy's types that are understood: truth values, whole numbers, floating-point numbers."""


def to_json(value: Any) -> Any:
    """The value as an object for ``json.dumps``.  Raises TypeError for one of another kind than those above."""
    if isinstance(value, (np.generic, np.ndarray)):
        return _array_to_json(value)
    if isinstance(value, enum.Enum):
        return {"enum": _name(type(value)), "member": value.name}
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, float):
        return _float_to_json(value)
    if isinstance(value, bytes):
        return {"bytes": value.hex()}
    if isinstance(value, list):
        return [to_json(item) for item in value]
    if isinstance(value, tuple):
        return {"tuple": [to_json(item) for item in value]}
    if isinstance(value, dict):
        return {"dict": [[to_json(key), to_json(item)] for key, item in value.items()]}
    if isinstance(value, frozenset):
        return {"set": sorted((to_json(item) for item in value), key=str)}
    if attrs.has(type(value)):
        fields = {field.name: to_json(getattr(value, field.name)) for field in attrs.fields(type(value))}
        return {"class": _name(type(value)), "fields": fields}
    raise TypeError(f"a {type(value).__module__}.{type(value).__qualname__} cannot be recorded")


def from_json(data: Any) -> Any:
    """The inverse of `to_json`: what a class carries is put back as it was, past its converters, which may round.

    Raises ValueError for anything that `to_json` doesn't give, and where a class has other fields now than then.
    """
    if data is None or isinstance(data, (bool, int, float, str)):
        return data
    if isinstance(data, list):
        return [from_json(item) for item in data]
    for tag, read in _READERS.items():
        if tag in data:
            try:
                return read(data)
            except (AttributeError, KeyError, OverflowError, TypeError) as error:
                raise ValueError(f"not a recorded {tag}: {error}") from error
    raise ValueError(f"not a recorded value: {str(data)[:60]}")


def restored(data: Any, kind: type[_Kind]) -> _Kind:
    """The value of that class that `to_json` gave.

    Raises ValueError unless it is one, everything that it carries is of the annotated type, and the constructors of all
    its parts accept them.
    """
    value = from_json(data)
    if not isinstance(value, kind):
        raise ValueError(f"is no {kind.__name__}")
    check_type(value, kind, kind.__name__)
    return value


def _float_to_json(value: float) -> Any:
    return float(value) if math.isfinite(value) else {"float": repr(float(value))}  # JSON has no inf


def _array_to_json(value: np.generic | NDArray[Any]) -> dict[str, Any]:
    if not _is_understood(value.dtype):
        raise TypeError(f"an array of {value.dtype} cannot be recorded")
    if isinstance(value, np.generic):
        return {"scalar": value.dtype.name, "value": to_json(value.item())}
    # The order in memory decides which of its kernels numpy multiplies with, and so the last bits.
    columns_first = value.flags.f_contiguous and not value.flags.c_contiguous
    values = [to_json(item) for item in value.ravel().tolist()]
    return {"array": value.dtype.name, "shape": list(value.shape), "order": "CF"[columns_first], "values": values}


def _array(data: dict[str, Any]) -> NDArray[Any]:
    values = np.array(from_json(data["values"]), dtype=_dtype(data["array"])).reshape(data["shape"])
    return np.array(values, order=data["order"])


def _scalar(data: dict[str, Any]) -> Any:
    return _dtype(data["scalar"]).type(from_json(data["value"]))


def _dtype(name: str) -> np.dtype[Any]:
    dtype = np.dtype(name)
    if not _is_understood(dtype):
        raise ValueError(f"an array of {name} is none of ours")
    return dtype


def _is_understood(dtype: np.dtype[Any]) -> bool:
    return dtype.kind in _NUMBERS and dtype.itemsize <= 8 and dtype.isnative


def _instance(data: dict[str, Any]) -> Any:
    cls = _find(data["class"])
    fields = data["fields"]
    if not attrs.has(cls) or fields.keys() != {field.name for field in attrs.fields(cls)}:
        raise ValueError(f"{data['class']} has other fields now")
    values = {name: from_json(value) for name, value in fields.items()}
    cls(**{field.alias: values[field.name] for field in attrs.fields(cls) if field.init})  # for its checks alone
    instance = object.__new__(cls)
    for name, value in values.items():
        object.__setattr__(instance, name, value)
    return instance


def _member(data: dict[str, Any]) -> enum.Enum:
    cls = _find(data["enum"])
    if not issubclass(cls, enum.Enum):
        raise ValueError(f"{data['enum']} is no enumeration")
    member: enum.Enum = cls[data["member"]]
    return member


def _name(cls: type) -> str:
    name = f"{cls.__module__}:{cls.__qualname__}"
    if not name.startswith(_PACKAGE):
        raise TypeError(f"a {name} cannot be recorded: it is not of this package")
    return name


@cache
def _classes() -> dict[str, type]:
    """Those that a record may name."""
    found = {cls for kind in _RECORDED for cls in classes_within(kind)}
    return {f"{cls.__module__}:{cls.__qualname__}": cls for cls in found if cls.__module__.startswith(_PACKAGE)}


def _find(name: str) -> type:
    if name not in _classes():
        raise ValueError(f"{name} is no class that is recorded")
    return _classes()[name]


_READERS: dict[str, Callable[[dict[str, Any]], Any]] = {
    "float": lambda data: float(data["float"]),
    "bytes": lambda data: bytes.fromhex(data["bytes"]),
    "tuple": lambda data: tuple(from_json(data["tuple"])),
    "dict": lambda data: {from_json(key): from_json(item) for key, item in data["dict"]},
    "set": lambda data: frozenset(from_json(data["set"])),
    "array": _array,
    "scalar": _scalar,
    "enum": _member,
    "class": _instance,
}
