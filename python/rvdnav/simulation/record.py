"""What a simulated sequence says about itself: meta.yaml, and the fingerprint that tells one run from another."""

from __future__ import annotations

import hashlib
import json
from typing import Any

import attrs
import numpy as np
import yaml

from rvdnav import __version__
from rvdnav.pose.arrays import FloatArray
from rvdnav.simulation.scenario import Background, Scenario


def fingerprint(scenario: Scenario, renderer: str) -> str:
    """The same for runs that give the same bytes: same scenario, version of this package, renderer and its variant."""
    stated = json.dumps(
        [__version__, renderer, attrs.asdict(scenario, value_serializer=_plain)], sort_keys=True, default=_plain_value
    )
    return hashlib.sha256(stated.encode()).hexdigest()[:32]


def _plain(_: Any, __: Any, value: Any) -> Any:
    return _plain_value(value) if isinstance(value, (np.ndarray, Background)) else value


def _plain_value(value: Any) -> Any:
    if isinstance(value, Background):
        return value.value
    if isinstance(value, np.ndarray):
        return value.tolist()
    raise TypeError(type(value).__name__)


def meta_text(scenario: Scenario, renderer: str) -> str:
    """The text of meta.yaml."""
    lights, sensor, target, rig = scenario.lights, scenario.sensor, scenario.target, scenario.rig
    ranges = [float(np.linalg.norm(scenario.T_world_target(frame)[:3, 3])) for frame in range(scenario.frames)]
    meta: dict[str, Any] = {
        "name": scenario.name,
        "seed": scenario.seed,
        "fps": scenario.rate,
        "frames": scenario.frames,
        "baseline_m": round(scenario.rig.baseline, 9),
        "target": target.name,
        "light": {"led": lights.led, "sun": lights.sun, "ambient": lights.ambient},
        "sun_direction_W": lights.towards_sun_W.tolist() if lights.sun else None,
        "background": scenario.background.value,
        "range_m": [round(ranges[0], 6), round(ranges[-1], 6)],
        "euler_convention": "R_WC = R_y(theta) R_x(phi) R_z(psi)",
        "points_in_image": {
            "note": f"how many of the target's {len(target.points)} points fall inside the image, per frame",
            **{f"cam{camera}": _seen(scenario, camera) for camera in range(len(scenario.rig.cameras))},
        },
        "spp": scenario.samples,
        "psf_sigma_px": sensor.psf_sigma,
        "noise": f"sigma^2 = {sensor.read_noise:g}^2 + {sensor.shot_noise:g} DN (DN^2), PRNU {100 * sensor.prnu:g} %, "
        f"black level {sensor.black_level:g} DN, vignetting {100 * sensor.vignetting:g} %",
        "response": {"gamma": sensor.gamma, "sharpening": sensor.sharpening},
        "timing": {
            "exposure_ns": rig.exposure_ns,
            "line_delay_ns": rig.line_delay_ns,
            "scan": rig.scan,
            "field_delay_ns": rig.field_delay_ns,
        },
        "edge_radius_mm": round(1e3 * target.edge_radius, 9),
        "true_points_mm": {name: np.round(1e3 * point, 9).tolist() for name, point in target.points.items()},
        "files": attrs.asdict(scenario.files, value_serializer=_listed),
        "renderer": renderer,
        "fingerprint": fingerprint(scenario, renderer),
    }
    return yaml.safe_dump(meta, sort_keys=False, width=120, default_flow_style=None)


def _listed(_: Any, __: Any, value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def _seen(scenario: Scenario, camera: int) -> list[int]:
    points = np.array(list(scenario.target.points.values()))
    return [_inside(scenario, camera, points, scenario.T_world_target(frame)) for frame in range(scenario.frames)]


def _inside(scenario: Scenario, camera: int, points: FloatArray, T_W_C: FloatArray) -> int:
    uv = scenario.rig.project(camera, points @ T_W_C[:3, :3].T + T_W_C[:3, 3])
    size = (scenario.rig.width, scenario.rig.height)
    return int(((uv >= -0.5) & (uv < np.array(size) - 0.5)).all(axis=1).sum())
