"""All settings of the navigator and its core as a user gives them: by name, with unit, default, range and meaning."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any, cast

import attrs

from rvdnav.core.config import ISA_NAMES, core_range, make_config
from rvdnav.core.options import MEANINGS
from rvdnav.errors import InputError
from rvdnav.navigator.options import NavigatorOptions
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.yamlio import read_yaml


@attrs.frozen
class Setting:
    """What a setting may be.  A number from low to high, whole if these are, or one of some names."""

    name: str
    default: float | str
    unit: str
    """Empty for a count, a ratio or a name."""
    meaning: str
    low: float = math.nan
    high: float = math.nan
    names: tuple[str, ...] = ()

    @property
    def whole(self) -> bool:
        """Whether it is a whole number."""
        return isinstance(self.default, int)

    @property
    def range_text(self) -> str:
        """What it may be, in words."""
        if self.names:
            return ", ".join(self.names)
        return f"{self.low} to {self.high}" if self.whole else f"{self.low:g} to {self.high:g}"

    def read(self, value: Any) -> Any:
        """The value if it is allowed; a whole number may be written as 5.0.  Raises ValueError."""
        if self.names:
            if value in self.names:
                return value
        elif isinstance(value, (int, float)) and not isinstance(value, bool) and self.low <= value <= self.high:
            if not self.whole:
                return float(value)
            if value == int(value):
                return int(value)
        kind = "one of" if self.names else "a whole number from" if self.whole else "a number from"
        raise ValueError(f"{self.name} = {value} is not {kind} {self.range_text}")


@cache
def all_settings() -> dict[str, Setting]:
    """By name: the navigator's, then the core's."""
    defaults = NavigatorSettings()
    own = {
        field.name: Setting(field.name, getattr(defaults, field.name), **field.metadata)
        for field in attrs.fields(NavigatorSettings)
    }
    config = make_config()
    core = {"isa": Setting("isa", "auto", *MEANINGS["isa"], names=ISA_NAMES)}
    for name in MEANINGS.keys() - core.keys():
        low, high = core_range(name)
        core[name] = Setting(name, getattr(config, name), *MEANINGS[name], low, high)
    return own | {name: core[name] for name in MEANINGS}


def read_settings(path: Path) -> NavigatorOptions:
    """The settings of a YAML file, a mapping of names to values.  Raises InputError with the file and the setting."""
    section = read_yaml(path)
    settings = all_settings()
    section.only(*settings)
    options: dict[str, Any] = {}
    for name in section:
        try:
            options[name] = settings[name].read(section.values[name])
        except ValueError as error:
            raise InputError(f"{path}: {error}") from error
    return cast("NavigatorOptions", options)


def parse_settings(texts: Iterable[str]) -> NavigatorOptions:
    """Settings written as name=value.  Raises InputError for a name that there isn't, twice, or a value not allowed."""
    settings = all_settings()
    options: dict[str, Any] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        if not equals:
            raise InputError(f"setting {text!r}: not of the form name=value")
        if name not in settings:
            near = difflib.get_close_matches(name, settings, 1)
            hint = f"did you mean {near[0]}?" if near else "`rvdnav settings` prints all"
            raise InputError(f"setting {name!r} is not known; {hint}")
        if name in options:
            raise InputError(f"setting {name} is given twice")
        try:
            options[name] = settings[name].read(_plain(value))
        except ValueError as error:
            raise InputError(f"setting {error}") from error
    return cast("NavigatorOptions", options)


def _plain(text: str) -> float | str:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
