"""The exact ray of every point of every pixel."""

from __future__ import annotations

import numpy as np

from rvdnav.camera import CameraModel
from rvdnav.pose.arrays import FloatArray


class RayTable:
    """Rays of a camera by pixel and place inside the pixel.

    `CameraModel.unproject` is evaluated on the lattice of pixel centres, edges and corners; inside a pixel the rays
    are the biquadratic through its nine lattice points, which a test holds to the model within 1e-5 px.
    """

    def __init__(self, camera: CameraModel, columns: slice, rows: slice) -> None:
        """columns, rows: the part of the image that is wanted, px."""
        width, height = columns.stop - columns.start, rows.stop - rows.start
        u = columns.start + 0.5 * np.arange(-1, 2 * width)
        v = rows.start + 0.5 * np.arange(-1, 2 * height)
        lattice = camera.unproject(np.stack(np.meshgrid(u, v), axis=-1))[..., :2]
        self.shape = (height, width)
        self._nodes = [
            [lattice[j : j + 2 * height - 1 : 2, i : i + 2 * width - 1 : 2] for i in range(3)] for j in range(3)
        ]

    def rays(self, rows: slice, du: FloatArray, dv: FloatArray) -> FloatArray:
        """Rays (h, w, n, 3) with z = 1 in the camera frame of n points in each pixel of some rows of the part.

        du, dv (h, w, n): where, off the pixel's centre, px in [-0.5, 0.5].
        """
        across, down = _weights(du), _weights(dv)
        rays = np.zeros((*du.shape, 3))
        for axis in range(2):
            for j in range(3):
                row = sum(across[i] * self._nodes[j][i][rows, :, None, axis] for i in range(3))
                rays[..., axis] += down[j] * row
        rays[..., 2] = 1.0
        return rays


def _weights(offset: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Of the values at -0.5, 0 and 0.5 in the quadratic through them."""
    return offset * (2.0 * offset - 1.0), 1.0 - 4.0 * offset * offset, offset * (2.0 * offset + 1.0)
