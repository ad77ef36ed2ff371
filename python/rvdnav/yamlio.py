"""The one place that reads YAML: plain data only and little of it, every error names the file and the key.

What is read is YAML's core: mappings with texts for keys, lists, texts, numbers, true, false and null, in one document,
which may begin with OpenCV's header. Whatever else YAML knows is refused by name, none of it being of use in our files;
so is what is too large, aliases counted by what they stand for.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import attrs
import numpy as np
import yaml

from rvdnav.errors import InputError
from rvdnav.files import UNPRINTABLE, read_text
from rvdnav.pose.arrays import FloatArray

_LARGEST_FILE = 1 << 20
_MOST_VALUES = 30_000
_DEEPEST = 20
_LARGEST_NUMBER = 1e30
"""Of which powers can still be reckoned with; nothing that is measured is larger."""
_LONGEST_TEXT = 1_000
_LIKE, _VERY_LIKE = 0.6, 0.8
"""Likeness of two keys, as difflib's ratio, from which one may be the other mistyped: where none is known besides ours,
and where others have keys of their own."""
_TAG = "tag:yaml.org,2002:"
_OPENCV_HEADER = re.compile(r"%YAML:[^\n]*")
_INT = re.compile(r"[-+]?[0-9]{1,400}")
_FLOAT = re.compile(r"[-+]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_WORDS: dict[str, dict[str, bool | None]] = {
    "null": {"": None, "~": None, "null": None},
    "bool": {"true": True, "false": False},
}


class _Loader(yaml.SafeLoader):
    """A loader of YAML's core alone, strict about keys given twice."""

    # What a text without quotes is, by its beginning; PyYAML's own rules know no 1e-3, but sexagesimal numbers.
    yaml_implicit_resolvers: ClassVar[dict[Any, Any]] = {}  # type: ignore[misc]  # an instance's in PyYAML's stubs
    yaml_constructors: ClassVar[dict[Any, Any]] = {}

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._values = 0
        self._depth = 0
        self._anchored: dict[str, int] = {}

    def compose_node(self, parent: yaml.Node | None, index: int) -> yaml.Node | None:
        event: Any = self.peek_event()  # type: ignore[no-untyped-call]  # without types in PyYAML's stubs
        before = self._values
        self._depth += 1
        is_alias = isinstance(event, yaml.AliasEvent)
        self._values += self._anchored.get(event.anchor, 0) if is_alias else 1
        if self._depth > _DEEPEST:
            raise _fault(f"nested more than {_DEEPEST} deep", event)
        if self._values > _MOST_VALUES:
            raise _fault(f"more than {_MOST_VALUES} values", event)
        if is_alias and event.anchor in self.anchors and event.anchor not in self._anchored:
            raise _fault("an alias stands within what it stands for", event)
        node = super().compose_node(parent, index)
        self._depth -= 1
        if event.anchor is not None:
            self._anchored.setdefault(event.anchor, self._values - before)
        return node

    def mapping(self, node: yaml.MappingNode) -> dict[str, Any]:
        if not isinstance(node, yaml.MappingNode):
            raise _fault("not a mapping", node)
        values: dict[str, Any] = {}
        for key_node, value_node in node.value:
            key = self.construct_object(key_node, deep=True) if isinstance(key_node, yaml.ScalarNode) else None
            if not isinstance(key, str):
                raise _fault("a key that is not a text", key_node)
            if key in values:
                raise _fault(f"key {key!r} is given twice", key_node)
            values[key] = self.construct_object(value_node, deep=True)
        return values

    def text(self, node: yaml.ScalarNode) -> str:
        text = str(self.construct_scalar(node))
        if len(text) > _LONGEST_TEXT:
            raise _fault(f"a text of more than {_LONGEST_TEXT} characters, {text[:20]!r}…", node)
        if UNPRINTABLE.search(text):
            raise _fault(f"a text with control characters, {text[:20]!r}", node)
        return text

    def number(self, node: yaml.ScalarNode) -> float:
        text = str(self.construct_scalar(node))
        if _INT.fullmatch(text):
            return int(text) if node.tag == f"{_TAG}int" else float(text)
        if node.tag == f"{_TAG}float" and _FLOAT.fullmatch(text):
            return float(re.sub(r"(?<![0-9])\.(?=[inIN])", "", text))
        raise _fault(f"{text[:20]!r} is no number", node)

    def word(self, node: yaml.ScalarNode) -> bool | None:
        text = str(self.construct_scalar(node))
        words = _WORDS[node.tag.removeprefix(_TAG)]
        if text.lower() not in words:
            raise _fault(f"{text[:20]!r} is no {node.tag.removeprefix(_TAG)}", node)
        return words[text.lower()]

    def items(self, node: yaml.SequenceNode) -> list[Any]:
        return self.construct_sequence(node, deep=True)

    def matrix(self, node: yaml.MappingNode) -> list[list[float]]:
        try:
            return opencv_matrix(self.mapping(node))
        except ValueError as error:
            raise _fault(str(error), node) from error

    def unknown(self, node: yaml.Node) -> Any:
        raise _fault(f"the tag {node.tag.replace(_TAG, '!!')[:40]} is not understood", node)


def _fault(text: str, place: yaml.Node | yaml.Event) -> yaml.MarkedYAMLError:
    mark: Any = place.start_mark
    return yaml.MarkedYAMLError(None, None, text, mark)


for _name, _pattern, _first in (
    ("null", "~|null|Null|NULL|", ["~", "n", "N", ""]),
    ("bool", "true|True|TRUE|false|False|FALSE", list("tTfF")),
    ("int", "[-+]?[0-9]+", list("-+0123456789")),
    ("float", _FLOAT.pattern, list("-+.0123456789")),
):
    _Loader.add_implicit_resolver(_TAG + _name, re.compile(f"({_pattern})$"), _first)
for _name, _read in (
    ("null", _Loader.word),
    ("bool", _Loader.word),
    ("int", _Loader.number),
    ("float", _Loader.number),
    ("str", _Loader.text),
    ("seq", _Loader.items),
    ("map", _Loader.mapping),
    ("opencv-matrix", _Loader.matrix),
):
    _Loader.add_constructor(_TAG + _name, _read)
_Loader.add_constructor(None, _Loader.unknown)


def opencv_matrix(values: Mapping[str, Any]) -> list[list[float]]:
    """The rows of a matrix as OpenCV's FileStorage writes it: rows, cols, dt, data.

    Raises ValueError unless it is one, of single numbers, with as many as rows and columns make.
    """
    sizes, data = [values.get(key) for key in ("rows", "cols")], values.get("data")
    if values.get("dt") not in tuple("ucwsifdh"):
        raise ValueError("a matrix whose dt is none of u, c, w, s, i, f, d, h")
    rows, columns = (size if type(size) is int else -1 for size in sizes)
    if min(rows, columns) < 0:
        raise ValueError("a matrix whose rows or cols is no number of them")
    if not isinstance(data, list) or not all(_has_shape(number, ()) for number in data):
        raise ValueError("a matrix whose data is no list of numbers")
    if len(data) != rows * columns:
        raise ValueError(f"a matrix of {rows} x {columns} with {len(data)} numbers")
    if not data:  # however many rows of no columns
        return []
    return [data[row * columns : (row + 1) * columns] for row in range(rows)]


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

    def only(self, *keys: str) -> None:
        """Raise InputError for a key that is none of those."""
        for key in self.others(*keys, likeness=_LIKE):
            raise self.fault(key, f"is not known; the keys are {', '.join(keys)}")

    def others(self, *keys: str, likeness: float = _VERY_LIKE) -> list[str]:
        """The keys that are none of those.  Raises InputError for one that looks like one of them mistyped."""
        others = [key for key in self.values if key not in keys]
        absent = [key for key in keys if key not in self.values]
        for key in others:
            for near in difflib.get_close_matches(key, absent, 1, likeness):
                raise self.fault(key, f"is not known; did you mean {near}?")
        return others

    def _get(self, key: str) -> Any:
        if key not in self.values:
            raise self.fault(key, "is missing")
        return self.values[key]

    def section(self, key: str) -> Section:
        """The mapping below a key."""
        value = self._get(key)
        if not isinstance(value, dict):
            raise self.fault(key, "is not a mapping of keys to values")
        return Section(self.path, value, f"{self.prefix}{key}.")

    def sections(self, key: str) -> list[Section]:
        """The list of mappings below a key."""
        value = self._get(key)
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            raise self.fault(key, "is not a list of mappings")
        return [Section(self.path, item, f"{self.prefix}{key}[{i}].") for i, item in enumerate(value)]

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

    def whole(self, key: str, least: int, most: int) -> int:
        """A whole number within bounds."""
        value = self.number(key)
        if value != int(value) or not least <= value <= most:
            raise self.fault(key, f"is not a whole number from {least} to {most}")
        return int(self.values[key])

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
        if np.abs(array).max(initial=0.0) > _LARGEST_NUMBER:
            raise self.fault(key, f"is beyond {_LARGEST_NUMBER:g}")
        return array


def _is_text_list(value: Any) -> bool:
    return isinstance(value, list) and all(isinstance(item, str) for item in value)


def _has_shape(value: Any, shape: Sequence[int]) -> bool:
    if not shape:
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    return isinstance(value, list) and len(value) == shape[0] and all(_has_shape(item, shape[1:]) for item in value)


def read_yaml(path: Path) -> Section:
    """The mapping that a YAML file holds.

    Raises InputError naming the file, and the line where there is one, when it is missing or no such file.
    """
    text = read_text(path, _LARGEST_FILE)
    if header := _OPENCV_HEADER.match(text):
        text = text[header.end() :]
    try:
        values = yaml.load(text, _Loader)
    except yaml.MarkedYAMLError as error:
        line = f"line {error.problem_mark.line + 1}: " if error.problem_mark else ""
        raise InputError(f"{path}: {line}{error.problem or 'not YAML'}") from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(values, dict):
        raise InputError(f"{path}: not a mapping of keys to values")
    return Section(path, values)
