"""How the edges of a measurement agree with its pose, edge by edge."""

from __future__ import annotations

import numpy as np

from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.measurement import Measurement
from rvdnav.solution import LineResidual


def edge_residuals(measurement: Measurement, model: EdgeModel, reduction: int) -> tuple[LineResidual, ...]:
    """Residuals of every edge in every view: of its line's two endpoints against the pose.

    reduction: by which the measured images were reduced.
    """
    lines = measurement.lines
    agreed = measurement.agreed
    # Of edges that were not measured, zero.
    ends = np.zeros((*agreed.shape, 2))
    ends[lines.camera, lines.edge] = reduction * measurement.pose.residuals
    rms, mean = np.sqrt(np.mean(ends**2, axis=2)), np.mean(ends, axis=2)
    rows = zip(agreed.tolist(), rms.tolist(), mean.tolist(), strict=True)
    return tuple(
        LineResidual(camera, name, samples > 0, samples, *of_ends)
        for camera, of_view in enumerate(rows)
        for name, samples, *of_ends in zip(model.names, *of_view, strict=True)
    )
