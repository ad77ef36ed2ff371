"""Points in space from two views: the paper's equations (1)-(3)."""

from __future__ import annotations

import numpy as np

from rvdnav.pose.arrays import FloatArray, float_array
from rvdnav.pose.errors import PoseError

# Smallest ratio of the triangular factor's diagonal entries; below it the two rays are parallel.
_PARALLEL = 1e-9


def triangulate(M_l: FloatArray, M_r: FloatArray, uv_l: FloatArray, uv_r: FloatArray) -> FloatArray:
    """Points (n, 3) in the frame that the projection matrices map from, by least squares of K P = U.

    M_l, M_r: projection matrices (3, 4) of the left and right camera.  uv_l, uv_r: matched image points (n, 2), in the
    pixel coordinates that these matrices give.  Each view gives two rows of K and U by eliminating its depth from
    equation (1): (u m_3 - m_1) P = m_14 - u m_34, and the same for v.  It solves (2) through a QR factorisation, which
    is (3) without squaring the condition number.  Raises PoseError if the two rays of a point are parallel.
    """
    M_l, M_r = float_array(M_l, 3, 4), float_array(M_r, 3, 4)
    uv_l = float_array(uv_l, None, 2)
    uv_r = float_array(uv_r, len(uv_l), 2)
    rows = np.concatenate([_depth_free_rows(M_l, uv_l), _depth_free_rows(M_r, uv_r)], axis=1)
    K, U = rows[:, :, :3], -rows[:, :, 3]
    q, r = np.linalg.qr(K)
    diagonal = np.abs(np.diagonal(r, axis1=1, axis2=2))
    if np.any(diagonal.min(axis=1) <= _PARALLEL * diagonal.max(axis=1)):
        raise PoseError("the two rays of a point are parallel: it has no position")
    points: FloatArray = np.linalg.solve(r, np.einsum("nij,ni->nj", q, U)[:, :, None])[:, :, 0]
    return points


def _depth_free_rows(M: FloatArray, uv: FloatArray) -> FloatArray:
    """(n, 2, 4): the two equations on the homogeneous point that each image point gives."""
    rows: FloatArray = uv[:, :, None] * M[2] - M[:2]
    return rows
