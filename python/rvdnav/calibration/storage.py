"""Reading of OpenCV's FileStorage, as YAML, JSON or XML, without OpenCV, whose own reader crashes on damaged files."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from rvdnav.errors import InputError
from rvdnav.files import read_text
from rvdnav.yamlio import Section, opencv_matrix, read_yaml

_DEEPEST = 20
_MATRIX = "opencv-matrix"
_ITEM = "_"
_WORD = re.compile(r'"([^"]*)"|(\S+)')
_NUMBER = re.compile(r"[-+]?([0-9]{1,20}(\.[0-9]*)?|\.[0-9]+)([eE][-+]?[0-9]{1,4})?")


def read_storage(path: Path) -> Section:
    """What a FileStorage holds: numbers, texts, lists and mappings, and matrices as lists of their rows.

    Raises InputError naming the file when it is missing or no such file.
    """
    text = read_text(path)
    if not text.lstrip().startswith("<"):
        section = read_yaml(path)
        values = {key: _json_value(section, key) for key in section}
        return Section(path, values)
    if "<!DOCTYPE" in text or "<!ENTITY" in text:
        raise InputError(f"{path}: an XML file with definitions of its own is not read")
    try:
        root = ElementTree.fromstring(text)
        if root.tag != "opencv_storage":
            raise ValueError("is not an OpenCV FileStorage")
        return Section(path, _mapping(root, 0))
    except (ElementTree.ParseError, ValueError) as error:
        raise InputError(f"{path}: {error}") from error


def _json_value(section: Section, key: str) -> Any:
    """In JSON a matrix is told by a key, which YAML has as a tag and `read_yaml` has followed."""
    value = section.values[key]
    if not isinstance(value, dict) or value.get("type_id") != _MATRIX:
        return value
    try:
        return opencv_matrix(value)
    except ValueError as error:
        raise section.fault(key, f"is {error}") from error


def _mapping(element: ElementTree.Element, depth: int) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for child in element:
        if child.tag in values:
            raise ValueError(f"{child.tag} is given twice")
        values[child.tag] = _value(child, depth + 1)
    return values


def _value(element: ElementTree.Element, depth: int) -> Any:
    if depth > _DEEPEST:
        raise ValueError(f"nested more than {_DEEPEST} deep")
    if element.get("type_id") == _MATRIX:
        values = _mapping(element, depth)
        if not isinstance(values.get("data"), list):  # a matrix of one number
            values["data"] = [values.get("data")]
        return opencv_matrix(values)
    if len(element) and all(child.tag == _ITEM for child in element):
        return [_value(child, depth + 1) for child in element]
    if len(element):
        return _mapping(element, depth)
    words = [_word(match) for match in _WORD.finditer(element.text or "")]
    return words[0] if len(words) == 1 else words


def _word(match: re.Match[str]) -> str | float:
    quoted, plain = match.groups()
    if quoted is not None or _NUMBER.fullmatch(plain) is None:
        return quoted if plain is None else plain
    return int(plain) if plain.lstrip("+-").isdecimal() else float(plain)
