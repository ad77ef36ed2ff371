"""The one place that reads and writes YAML: plain data only, every error names the file and the key."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import yaml

from rvdnav.errors import InputError
from rvdnav.files import read_text
from rvdnav.pose.arrays import FloatArray


class _Loader(yaml.SafeLoader):
    """The safe loader, strict about keys given twice and without PyYAML's blind spot for numbers such as 1e-3."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        seen: set[str] = set()
        for key, _ in node.value:
            if key.value in seen:
                raise yaml.constructor.ConstructorError(None, None, f"key {key.value!r} is given twice", key.start_mark)
            if isinstance(key.value, str):
                seen.add(key.value)
        return super().construct_mapping(node, deep)


_Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float",
    re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)[eE][-+]?[0-9]+$"),
    list("-+.0123456789"),
)


@attrs.frozen
class Section:
    """A mapping of a YAML file, read key by key.

    Every method raises InputError naming the file and the key when the key is missing or its value is of another kind;
    numbers must be finite.
    """

    path: Path
    values: dict[str, Any]
    prefix: str = ""
    """Where in the file the mapping stands: "cam0." for the keys below cam0."""

    def __contains__(self, key: str) -> bool:
        return key in self.values

    def __iter__(self) -> Iterator[str]:
        return iter(self.values)

    def fault(self, key: str, what: str) -> InputError:
        """The error "file: key what"."""
        return InputError(f"{self.path}: {self.prefix}{key} {what}")

    def _get(self, key: str) -> Any:
        if key not in self.values:
            raise self.fault(key, "is missing")
        return self.values[key]

    def section(self, key: str) -> Section:
        """The mapping below a key."""
        value = self._get(key)
        if not isinstance(value, dict):
            raise self.fault(key, "is not a mapping of keys to values")
        return _section(self.path, value, f"{self.prefix}{key}.")

    def sections(self, key: str) -> list[Section]:
        """The list of mappings below a key."""
        value = self._get(key)
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            raise self.fault(key, "is not a list of mappings")
        return [_section(self.path, item, f"{self.prefix}{key}[{i}].") for i, item in enumerate(value)]

    def text(self, key: str) -> str:
        """A text."""
        value = self._get(key)
        if not isinstance(value, str):
            raise self.fault(key, "is not a text")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        """A list of texts."""
        value = self._get(key)
        if not _is_text_list(value):
            raise self.fault(key, "is not a list of names")
        return tuple(value)

    def text_lists(self, key: str) -> list[tuple[str, ...]]:
        """A list of lists of texts."""
        value = self._get(key)
        if not isinstance(value, list) or not all(_is_text_list(item) for item in value):
            raise self.fault(key, "is not a list of lists of names")
        return [tuple(item) for item in value]

    def number(self, key: str) -> float:
        """A finite number."""
        return float(self.numbers(key))

    def numbers(self, key: str, *shape: int) -> FloatArray:
        """An array of finite numbers of that shape."""
        value = self._get(key)
        if not _has_shape(value, shape):
            size = " x ".join(str(length) for length in shape)
            raise self.fault(key, f"is not a list of {size} numbers" if shape else "is not a number")
        try:
            array = np.array(value, dtype=np.float64)
        except OverflowError:  # a whole number of more than 308 digits
            array = np.array(np.inf)
        if not np.isfinite(array).all():
            raise self.fault(key, "is not finite")
        return array


def _section(path: Path, values: dict[Any, Any], prefix: str) -> Section:
    for key in values:
        if not isinstance(key, str):
            raise InputError(f"{path}: {prefix}{key} is a key that is not a text")
    return Section(path, values, prefix)


def _is_text_list(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(item, str) for item in value)


def _has_shape(value: Any, shape: tuple[int, ...]) -> bool:
    if not shape:
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    return isinstance(value, list) and len(value) == shape[0] and all(_has_shape(item, shape[1:]) for item in value)


def read_yaml(path: Path) -> Section:
    """The mapping that a YAML file holds.

    Raises InputError naming the file, and the line where there is one, when it is missing or no such file.
    """
    text = read_text(path)
    try:
        values = yaml.load(text, _Loader)
    except yaml.MarkedYAMLError as error:
        line = f"line {error.problem_mark.line + 1}: " if error.problem_mark else ""
        raise InputError(f"{path}: {line}{error.problem or 'not YAML'}") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(values, dict):
        raise InputError(f"{path}: not a mapping of keys to values")
    return _section(path, values, "")
