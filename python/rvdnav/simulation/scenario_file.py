"""Reading of scenario files; docs/simulation.md lists the keys."""

from __future__ import annotations

import math
import os
from collections.abc import Collection
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from rvdnav.errors import InputError
from rvdnav.rig import load_rig
from rvdnav.simulation.course import Course, Motion
from rvdnav.simulation.scenario import LEAST_GAMMA, OMISSIONS, Background, Files, Lights, Scenario, Sensor
from rvdnav.simulation.solids import box_target, bracket_target
from rvdnav.target import Target, load_target
from rvdnav.yamlio import Section, read_yaml

_KEYS = (
    *("name", "seed", "frames", "rate_hz", "rig", "target", "motion"),
    *("lights", "background", "sensor", "samples_per_pixel", "files"),
)
_MOST_FRAMES = 10_000
_MOST_SAMPLES = 1 << 16
_BRACKET_MM = ("long_base_mm", "short_base_mm", "height_mm", "bar_width_mm", "bar_thickness_mm")
_EDGE_RADIUS_MM = "edge_radius_mm"
_COURSES = {"x_m": 1.0, "y_m": 1.0, "z_m": 1.0} | {f"{angle}_deg": math.pi / 180 for angle in ("phi", "theta", "psi")}
_SENSOR = {
    "psf_sigma_px": "psf_sigma",
    "level_dn": "level",
    "black_level_dn": "black_level",
    "read_noise_dn": "read_noise",
    "shot_noise_dn": "shot_noise",
    "prnu": "prnu",
    "vignetting": "vignetting",
    "gamma": "gamma",
    "sharpening": "sharpening",
}


def load_scenario(path: str | Path) -> Scenario:
    """The scenario that a YAML file describes; paths in it are relative to its folder.

    Raises InputError naming the file and the key for anything missing, unknown, of another kind or senseless, and for
    faults of the rig's and the target's files.
    """
    file = read_yaml(Path(path))
    file.only(*_KEYS)
    settings: dict[str, Any] = {}
    if "lights" in file:
        settings["lights"] = _lights(file.section("lights"))
    if "background" in file:
        settings |= _background(file.section("background"))
    if "sensor" in file:
        settings["sensor"] = _sensor(file.section("sensor"))
    if "samples_per_pixel" in file:
        settings["samples"] = file.whole("samples_per_pixel", 1, _MOST_SAMPLES)
    if "files" in file:
        settings["files"] = _files(file.section("files"))
    rate = file.number("rate_hz")
    if rate < 1e-3:
        raise file.fault("rate_hz", "is less than 0.001")
    rig, target, motion = _rig(file), _target(file), _motion(file.section("motion"))
    try:
        return Scenario(
            name=file.text("name"),
            seed=file.whole("seed", 0, 2**63 - 1),
            frames=file.whole("frames", 1, _MOST_FRAMES),
            rate=rate,
            rig=rig,
            target=target,
            motion=motion,
            **settings,
        )
    except ValueError as error:
        raise InputError(f"{path}: {error}") from error


def _one_of(section: Section, keys: Collection[str]) -> str:
    section.only(*keys)
    given = [key for key in keys if key in section]
    if len(given) != 1:
        raise InputError(f"{section.path}: {section.prefix[:-1]} needs exactly one of {', '.join(keys)}")
    return given[0]


def _rig(file: Section) -> Any:
    folder = file.path.parent / file.text("rig")
    if not os.path.isdir(folder):
        raise file.fault("rig", f"{str(folder)!r} is not a folder with a camchain.yaml")
    return load_rig(folder)


def _target(file: Section) -> Target:
    section = file.section("target")
    kind = _one_of(section, ("file", "bracket", "box"))
    if kind == "file":
        return load_target(file.path.parent / section.text("file"))
    sizes = section.section(kind)
    name = file.text("name")
    try:
        if kind == "bracket":
            sizes.only(*_BRACKET_MM, _EDGE_RADIUS_MM)
            target = bracket_target(name, *(1e-3 * sizes.number(key) for key in _BRACKET_MM))
        else:
            sizes.only("size_mm", _EDGE_RADIUS_MM)
            target = box_target(name, 1e-3 * sizes.numbers("size_mm", 3))
        if _EDGE_RADIUS_MM in sizes:
            target = attrs.evolve(target, edge_radius=1e-3 * sizes.number(_EDGE_RADIUS_MM))
        return target
    except ValueError as error:
        raise section.fault(kind, f"is impossible: {error}") from error


def _motion(section: Section) -> Motion:
    section.only(*_COURSES)
    if "x_m" not in section:
        raise section.fault("x_m", "is missing")
    courses = {key.rsplit("_", 1)[0]: _course(section, key, unit) for key, unit in _COURSES.items() if key in section}
    return Motion(**courses)


def _course(section: Section, key: str, unit: float) -> Course:
    if not isinstance(section.values[key], dict):
        value = unit * section.number(key)
        return Course(value, value)
    course = section.section(key)
    course.only("start", "end", "ease", "amplitude", "period_s", "phase_deg")
    start = course.number("start")
    values = {name: course.number(name) for name in course}
    if not 0.0 <= values.get("ease", 0.0) <= 1.0:
        raise course.fault("ease", "is not between 0 and 1")
    if not values.get("period_s", 1.0) > 0.0:
        raise course.fault("period_s", "is not positive")
    if "amplitude" in course and "period_s" not in course:
        raise course.fault("period_s", "is missing")
    return Course(
        start=unit * start,
        end=unit * values.get("end", start),
        ease=values.get("ease", 0.0),
        amplitude=unit * values.get("amplitude", 0.0),
        period=values.get("period_s", math.inf),
        phase=math.radians(values.get("phase_deg", 0.0)),
    )


def _lights(section: Section) -> Lights:
    section.only("led", "sun", "ambient", "towards_sun_W")
    values: dict[str, Any] = {key: _not_negative(section, key) for key in ("led", "sun", "ambient") if key in section}
    if "towards_sun_W" in section:
        values["towards_sun_W"] = _direction(section, "towards_sun_W")
    elif values.get("sun"):
        raise section.fault("towards_sun_W", "is missing")
    try:
        return Lights(**values)
    except ValueError as error:
        raise InputError(f"{section.path}: {section.prefix[:-1]}: {error}") from error


def _background(section: Section) -> dict[str, Any]:
    section.only("kind", "nadir_W", "distance_m")
    kinds = [kind.value for kind in Background]
    if section.text("kind") not in kinds:
        raise section.fault("kind", f"{section.text('kind')!r} is none of {', '.join(kinds)}")
    settings: dict[str, Any] = {"background": Background(section.text("kind"))}
    for key, owner in (("nadir_W", Background.EARTH), ("distance_m", Background.WALL)):
        if key in section and settings["background"] is not owner:
            raise section.fault(key, f"belongs to the background {owner.value!r}")
    if "nadir_W" in section:
        settings["nadir_W"] = _direction(section, "nadir_W")
    if "distance_m" in section:
        settings["wall_distance"] = section.number("distance_m")
        if settings["wall_distance"] < 0.1:
            raise section.fault("distance_m", "is less than 0.1")
    return settings


def _sensor(section: Section) -> Sensor:
    section.only(*_SENSOR)
    values = {_SENSOR[key]: _not_negative(section, key) for key in section}
    for key, least in (("level_dn", 1.0), ("gamma", LEAST_GAMMA)):
        if values.get(_SENSOR[key], least) < least:
            raise section.fault(key, f"is less than {least:g}")
    return attrs.evolve(Sensor(), **values)


def _files(section: Section) -> Files:
    lengths = ("target_sizes_mm", "target_points_mm", "tolerance_mm")
    section.only("calibration", *lengths, "omit")
    values: dict[str, Any] = {key: _not_negative(section, key) for key in lengths if key in section}
    if "calibration" in section:
        values["calibration"] = tuple(section.numbers("calibration", 3).tolist())
        if min(values["calibration"]) < 0.0:
            raise section.fault("calibration", "is negative")
    if "omit" in section:
        values["omit"] = section.texts("omit")
        for name in values["omit"]:
            if name not in OMISSIONS:
                raise section.fault("omit", f"{name!r} is none of {', '.join(OMISSIONS)}")
    return Files(**values)


def _not_negative(section: Section, key: str) -> float:
    value = section.number(key)
    if value < 0.0:
        raise section.fault(key, "is negative")
    return value


def _direction(section: Section, key: str) -> Any:
    direction = section.numbers(key, 3)
    if not np.any(direction):
        raise section.fault(key, "has no length")
    return direction
