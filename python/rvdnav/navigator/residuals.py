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
    lines, pose = measurement.lines, measurement.pose
    agreed = measurement.sampled.count(measurement.inlier)
    measured = {key: i for i, key in enumerate(zip(lines.camera.tolist(), lines.edge.tolist(), strict=True))}
    residuals = []
    for camera in range(agreed.shape[0]):
        for edge, name in enumerate(model.names):
            i = measured.get((camera, edge))
            ends = np.zeros(2) if i is None else pose.residuals[i]
            samples = int(agreed[camera, edge])
            rms, mean = reduction * float(np.sqrt(np.mean(ends**2))), reduction * float(np.mean(ends))
            residuals.append(LineResidual(camera, name, samples > 0, samples, rms, mean))
    return tuple(residuals)
