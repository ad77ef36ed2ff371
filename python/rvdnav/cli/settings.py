"""``rvdnav settings``, and the settings that other commands are given."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rvdnav.navigator.options import NavigatorOptions
from rvdnav.settings import all_settings, parse_settings, read_settings


def chosen_settings(path: Path | None, texts: Sequence[str]) -> NavigatorOptions:
    """Of a file, if there is one, and those given as name=value, which override it.  Raises InputError."""
    chosen: NavigatorOptions = {} if path is None else read_settings(path)
    chosen.update(parse_settings(texts))
    return chosen


def print_settings(chosen: NavigatorOptions) -> None:
    """Every setting as a file for --settings, with what was chosen in the place of the default."""
    values = dict(chosen)
    for setting in all_settings().values():
        value = values.get(setting.name, setting.default)
        unit = f"{setting.unit}, " if setting.unit else ""
        default = "" if value == setting.default else f"; default {setting.default}"
        print(f"# {setting.meaning}; {unit}{setting.range_text}{default}")
        print(f"{setting.name}: {value}")
