"""The satellite of the paper around a bracket: a 500 mm cube in foil, a solar panel, and what is mounted on them."""

from __future__ import annotations

import numpy as np

from rvdnav.bracket import Bracket
from rvdnav.pose.arrays import FloatArray
from rvdnav.simulation.mesh import Material, Part, box, cylinder, frame, merge, sheet
from rvdnav.simulation.rounding import rounded_frame
from rvdnav.simulation.textures import Rng, brushed, crumpled, solar_cells

BODY_M = 0.5
BRACKET_REFLECTANCE = 0.55
_STANDOFF_M = 0.055
"""From the back of the bars to the body's front."""
_RIM_M = 0.018
_FOIL_CELLS = 260
_DARK, _GREY, _BLACK = Material(0.08), Material(0.2), Material(0.04)
_FOIL = Material(0.9, roughness=0.16)


def bracket_parts(bracket: Bracket, edge_radius: float, rng: Rng) -> list[Part]:
    """The four bars with their true thickness and edges, and a screw in every corner of the front face."""
    loops = bracket.outer, bracket.inner, bracket.thickness
    bars = rounded_frame(*loops, edge_radius) if edge_radius else frame(*loops)
    parts = [Part(bars, Material(brushed(rng, BRACKET_REFLECTANCE)))]
    radius = 0.25 * float(bracket.bar_widths.min())
    heads = [cylinder(point - (0.0005, 0.0, 0.0), radius, 0.0004) for point in (bracket.outer + bracket.inner) / 2.0]
    parts.append(Part(merge(heads), Material(0.2)))
    return parts


def satellite_parts(bracket: Bracket, rng: Rng) -> list[Part]:
    """Body, panel and mountings behind the bracket; l2 stands over the body, l1 towards the panel."""
    back = float(bracket.outer[:, 0].mean()) + bracket.thickness
    height = float(bracket.heights.mean())
    z_edge = 0.45 * height
    low = np.array([back + _STANDOFF_M, -0.22 + float(rng.uniform(-0.02, 0.02)), z_edge])
    high = low + BODY_M
    return [
        *_body(low, high, rng),
        *_mountings(low, high, rng),
        *_panel(bracket, back, rng),
        *_holders(bracket, low),
    ]


def _body(low: FloatArray, high: FloatArray, rng: Rng) -> list[Part]:
    (x, y0, z0), (x1, y1, z1) = low, high
    core = box((x + 0.014, y0 + 0.002, z0 + 0.002), (x1, y1 - 0.002, z1 - 0.002))
    outer = [(x, y0, z0), (x, y1, z0), (x, y1, z1), (x, y0, z1)]
    inner = [
        (x, y0 + _RIM_M, z0 + _RIM_M),
        (x, y1 - _RIM_M, z0 + _RIM_M),
        (x, y1 - _RIM_M, z1 - _RIM_M),
        (x, y0 + _RIM_M, z1 - _RIM_M),
    ]
    foil = x + 0.008 + crumpled(rng, (_FOIL_CELLS, _FOIL_CELLS), BODY_M)
    rivets = [
        cylinder((x - 0.001, y, z), 0.003, 0.001, sides=12)
        for z in (z0 + _RIM_M / 2, z1 - _RIM_M / 2)
        for y in np.linspace(y0 + 0.03, y1 - 0.03, 9)
    ]
    return [
        Part(core, _DARK),
        Part(frame(outer, inner, 0.02), _GREY),
        Part(sheet(np.maximum(foil, x - 0.004), (y0 + 0.01, z0 + 0.01), (y1 - 0.01, z1 - 0.01)), _FOIL),
        Part(merge(rivets), _DARK),
    ]


def _mountings(low: FloatArray, high: FloatArray, rng: Rng) -> list[Part]:
    """Nozzle, antenna stub, rail, and an instrument with its tube; each instance a little elsewhere."""
    (x, y0, z0), (_, y1, z1) = low, high
    shift = rng.uniform(-0.015, 0.015, (3, 2))
    ny, nz = np.array([y1 - 0.15, z1 - 0.17]) + shift[0]
    iy, iz = np.array([y0 + 0.11, z0 + 0.27]) + shift[1]
    sy, sz = np.array([y0 + 0.16, z1 - 0.12]) + shift[2]
    return [
        Part(cylinder((x - 0.07, ny, nz), 0.062, 0.08, hole=0.05), _GREY),
        Part(cylinder((x - 0.03, ny, nz), 0.036, 0.04), Material(0.2)),
        Part(box((x - 0.045, iy - 0.04, iz - 0.045), (x + 0.01, iy + 0.04, iz + 0.045)), _BLACK),
        Part(cylinder((x - 0.075, iy, iz), 0.021, 0.04, hole=0.014), Material(0.17)),
        Part(cylinder((x - 0.06, sy, sz), 0.016, 0.07, hole=0.011), _GREY),
        Part(box((x - 0.03, y0 + 0.075, z0 + 0.02), (x - 0.02, y0 + 0.087, z1 - 0.06)), _GREY),
    ]


def _panel(bracket: Bracket, back: float, rng: Rng) -> list[Part]:
    """A panel of 360 mm by 430 mm beyond l1, a little inclined, and the struts that carry it."""
    x, y0, z1 = back - 0.002, -0.21 + float(rng.uniform(-0.02, 0.02)), -0.045
    front = np.array([(x, y0, z1 - 0.36), (x, y0, z1), (x, y0 + 0.43, z1), (x, y0 + 0.43, z1 - 0.36)])
    tilt = 0.012 * rng.uniform(-1.0, 1.0)
    front[[0, 3], 0] += tilt
    cells = sheet(np.array([[x + tilt, x + tilt], [x, x]]) - 0.0005, (y0, z1 - 0.36), (y0 + 0.43, z1))
    struts = [
        box((back - 0.6 * bracket.thickness, y - 0.007, z1), (back, y + 0.007, 0.0))
        for y in (0.3 * bracket.long_base * np.array([-1.0, 1.0])).tolist()
    ]
    rims = [
        box((x, y0 - 0.004, z1 - 0.36), (x + 0.014, y0, z1)),
        box((x, y0 + 0.43, z1 - 0.36), (x + 0.014, y0 + 0.434, z1)),
        box((x, y0, z1), (x + 0.014, y0 + 0.43, z1 + 0.006)),
    ]
    return [
        Part(cells, Material(solar_cells())),
        Part(merge([*rims, *struts]), _GREY),
    ]


def _holders(bracket: Bracket, low: FloatArray) -> list[Part]:
    """The dark plate behind the bracket, the posts that hold l2, and a bright strip below that is no bar of it."""
    x, z_edge = float(low[0]), float(low[2])
    back = float(bracket.outer[:, 0].mean()) + bracket.thickness
    half, height = 0.5 * bracket.long_base, float(bracket.heights.mean())
    width = float(bracket.bar_widths.mean())
    plate = box((x - 0.006, -1.15 * half, z_edge - 0.001), (x + 0.005, 1.2 * half, height - 0.4 * width))
    strip = box((x - 0.018, 1.08 * half, z_edge + 0.004), (x - 0.008, 1.08 * half + 0.012, height + 0.07))
    posts = [
        box((back, y - 0.3 * width, height - 0.8 * width), (x + 0.01, y + 0.3 * width, height - 0.2 * width))
        for y in (0.3 * bracket.short_base * np.array([-1.0, 1.0])).tolist()
    ]
    return [Part(plate, _BLACK), Part(strip, Material(0.42)), Part(merge(posts), _GREY)]
