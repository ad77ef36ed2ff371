"""Point clouds as PLY files, which Open3D, CloudCompare, MeshLab and their like read."""

from __future__ import annotations

import numpy as np

from rvdnav.reconstruction.cloud import Cloud

_FLOATS = ("x", "y", "z", "sigma")
_BYTES = ("grey", "red", "green", "blue")
"""Viewers colour points by red, green and blue, which repeat the grey level."""
_VERTEX = np.dtype([(name, "<f4") for name in _FLOATS] + [(name, "u1") for name in _BYTES])


def ply_bytes(cloud: Cloud) -> bytes:
    """A binary little-endian PLY: x, y, z (W, m), sigma (along the left camera's ray, m), grey, and grey as colour."""
    vertices = np.empty(len(cloud), _VERTEX)
    for axis, name in enumerate("xyz"):
        vertices[name] = cloud.points_W[:, axis]
    vertices["sigma"] = cloud.sigma
    for name in _BYTES:
        vertices[name] = cloud.grey
    header = [
        "ply",
        "format binary_little_endian 1.0",
        "comment rvdnav: world frame W, metres; sigma along the left camera's ray",
        f"element vertex {len(cloud)}",
        *(f"property float {name}" for name in _FLOATS),
        *(f"property uchar {name}" for name in _BYTES),
        "end_header",
        "",
    ]
    return "\n".join(header).encode("ascii") + vertices.tobytes()
