"""Settings by name: what there are, texts and files of them, and that the navigator takes them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import get_type_hints

import attrs
import pytest
from drawn_scene import bracket_target, example_rig
from rvdnav import InputError, Navigator
from rvdnav.cli.app import execute
from rvdnav.core import Core
from rvdnav.core.library import ffi
from rvdnav.navigator import NavigatorSettings
from rvdnav.navigator.options import NavigatorOptions
from rvdnav.settings import all_settings, parse_settings, read_settings

RIG, TARGET = example_rig(), bracket_target()
NUMBERS = [name for name in all_settings() if name != "isa"]


def test_the_typed_options_are_all_settings() -> None:
    config = {name for name, _ in ffi.typeof("rvdnav_config").fields} - {"struct_size", "clock", "clock_user"}
    assert set(all_settings()) == {field.name for field in attrs.fields(NavigatorSettings)} | config
    hints = get_type_hints(NavigatorOptions)
    kinds = {name: int if setting.whole else float for name, setting in all_settings().items()}
    assert hints == kinds | {"isa": str | int}


@pytest.mark.parametrize("name", NUMBERS)
def test_a_range_holds_its_default_and_ends(name: str) -> None:
    setting = all_settings()[name]
    assert setting.low <= setting.default <= setting.high
    assert setting.meaning
    for value in (setting.low, setting.high):
        assert parse_settings([f"{name}={value!r}"]) == {name: value}
    for value in (setting.low - 1, setting.high + 1, math.nan, "much"):
        with pytest.raises(InputError, match=f"^setting {name} = .* is not a .*number from"):
            parse_settings([f"{name}={value}"])


@pytest.mark.parametrize("value", [-1, math.nan, math.inf, True, None, "5"])
def test_the_navigator_refuses_the_same_values(value: object) -> None:
    for name in ("max_rms_px", "min_edges"):
        with pytest.raises(ValueError, match=f"^{name} = "):
            Navigator(RIG, TARGET, **{name: value})


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("min_edges", "setting 'min_edges': not of the form name=value"),
        ("min_edge=4", "setting 'min_edge' is not known; did you mean min_edges?"),
        ("zzz=4", "setting 'zzz' is not known; `rvdnav settings` prints all"),
        ("min_edges=4.5", "setting min_edges = 4.5 is not a whole number from 1 to 1000"),
        ("isa=mmx", "setting isa = mmx is not one of auto, avx2, neon, scalar, sse2"),
    ],
)
def test_one_line_says_what_is_wrong(text: str, fault: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert execute(["settings", "--set", text]) == 2
    assert capsys.readouterr().err == f"rvdnav: {fault}\n"


def test_a_setting_given_twice_is_refused() -> None:
    with pytest.raises(InputError, match="max_speed is given twice"):
        parse_settings(["max_speed=1", "max_speed=2"])


def test_what_is_printed_is_a_file_of_settings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert execute(["settings", "--set", "max_speed=0.25", "--set", "isa=scalar", "--set", "min_edges=6.0"]) == 0
    printed = capsys.readouterr().out
    path = tmp_path / "settings.yaml"
    path.write_text(printed)
    options = read_settings(path)
    defaults = {name: setting.default for name, setting in all_settings().items()}
    assert options == defaults | {"max_speed": 0.25, "isa": "scalar", "min_edges": 6}
    assert "m/s, 0.001 to 1000; default 1.0\n" in printed
    assert execute(["settings", "--settings", str(path), "--set", "max_speed=1"]) == 0
    assert "max_speed: 1.0\n" in capsys.readouterr().out
    assert Core(RIG, TARGET, **{name: options[name] for name in ("isa", "range_max")}).isa == "scalar"


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("max_sped: 2\n", "max_sped is not known; did you mean max_speed?"),
        ("max_speed: fast\n", "max_speed = fast is not a number from 0.001 to 1000"),
        ("min_edges: true\n", "min_edges = True is not a whole number from 1 to 1000"),
        ("- 1\n", "not a mapping of keys to values"),
    ],
)
def test_a_file_of_settings_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, fault: str
) -> None:
    path = tmp_path / "settings.yaml"
    path.write_text(text)
    assert execute(["run", str(tmp_path), "--out", str(tmp_path / "out"), "--settings", str(path)]) == 2
    assert capsys.readouterr().err == f"rvdnav: {path}: {fault}\n"
    assert not (tmp_path / "out").exists()
