"""Writing of target files."""

from __future__ import annotations

import json
import re
from pathlib import Path

import yaml

from rvdnav.files import write_text_atomically
from rvdnav.target import Target


def save_target(target: Target, path: str | Path) -> None:
    """Write a target as a `target.yaml`, in mm, so that `load_target` gives it back.

    Raises InputError naming the file when it cannot be written.
    """
    lines = [f"name: {_quoted(target.name)}", "units: mm"]
    if target.bars:
        lines.append(f"bar_thickness: {_millimetres(target.bar_thickness)}")
    if target.edge_radius:
        lines.append(f"edge_radius: {_millimetres(target.edge_radius)}")
    lines.append("points:")
    for name, point in target.points.items():
        lines.append(f"  {_quoted(name)}: [{', '.join(map(_millimetres, point.tolist()))}]")
    if target.tolerance is not None:
        lines.append("tolerance:  # standard deviation of each coordinate of a point")
        lines += [f"  {_quoted(name)}: {_millimetres(sigma)}" for name, sigma in target.tolerance.items()]
    if target.lines:
        lines.append("lines:")
        lines += [f"  {_quoted(name)}: {_names(ends)}" for name, ends in target.lines.items()]
    if target.bars:
        lines.append("bars:")
    for bar in target.bars:
        lines.append(f"- {{name: {_quoted(bar.name)}, outer: {_names(bar.outer)}, inner: {_names(bar.inner)}}}")
    for key, groups in (("edges", target.edges), ("faces", target.faces)):
        if groups:
            lines.append(f"{key}:")
            lines += [f"- {_names(group)}" for group in groups]
    if not target.dimensions_known:
        lines.append("dimensions: unknown")
    write_text_atomically(Path(path), "\n".join([*lines, ""]))


def _millimetres(value: float) -> str:
    return repr(round(1e3 * value, 9) + 0.0)


def _names(names: tuple[str, ...]) -> str:
    return f"[{', '.join(map(_quoted, names))}]"


def _quoted(text: str) -> str:
    """As it stands where YAML reads a plain word as that text, else quoted."""
    plain = re.fullmatch(r"[A-Za-z][\w-]*", text, re.ASCII) is not None and yaml.safe_load(text) == text
    return text if plain else json.dumps(text)
