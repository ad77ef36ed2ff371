"""The core's pose estimation: the same functions as `rvdnav.pose` has, with the same results, in native code.

`rvdnav.pose` is where they can be read.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from rvdnav.core import layout
from rvdnav.core.arrays import aligned_block, pointer
from rvdnav.core.library import ffi, lib
from rvdnav.core.status import check
from rvdnav.pose import EdgeLines, LineMeasurements, PoseError, RectifiedCameras, RefinedPose
from rvdnav.pose.arrays import FloatArray, IntArray, float_array
from rvdnav.pose.loss import Loss
from rvdnav.pose.refine_lines import ENDPOINT_SIGMA
from rvdnav.pose.so3 import make_T
from rvdnav.pose.systematics import JointInformation, Systematics

_LOSSES = {"tukey": lib.RVDNAV_LOSS_TUKEY, "huber": lib.RVDNAV_LOSS_HUBER}
_POSE_ERRORS = (lib.RVDNAV_ERROR_UNDETERMINED, lib.RVDNAV_ERROR_BEHIND, lib.RVDNAV_ERROR_NO_AGREEMENT)


def check_pose(status: int) -> None:
    """Raises PoseError where the measured geometry gives no pose, CoreError where the core refuses the call."""
    if status in _POSE_ERRORS:
        raise PoseError(ffi.string(lib.rvdnav_status_text(status)).decode())
    check(status)


def set_cameras(in_c: Any, cameras: RectifiedCameras) -> None:
    """Fills an rvdnav_pose_cameras."""
    in_c.focal = cameras.focal
    in_c.centre[0 : len(cameras.centers)] = cameras.centers.tolist()
    in_c.R_rect_W = cameras.R_rect_world.ravel().tolist()


def refined_pose(in_c: Any, n: int, groups: int, arrays: dict[str, FloatArray]) -> RefinedPose:
    """From an rvdnav_refined_pose over n lines, with its arrays by name, each at least as long as it must be."""
    return RefinedPose(
        T_world_target=make_T(np.array(list(in_c.R_W_C)).reshape(3, 3), np.array(list(in_c.p_W))),
        covariance=np.array(list(in_c.covariance)).reshape(6, 6),
        residuals=arrays["residuals"].ravel()[: 2 * n].reshape(n, 2),
        gain=arrays["gain"].ravel()[: 12 * n].reshape(6, n, 2),
        weights=arrays["weights"][:n],
        sigma0=in_c.sigma0,
        iterations=in_c.iterations,
        converged=bool(in_c.converged),
        z=arrays["z"],
        joint_covariance=arrays["joint_covariance"],
        scales=np.array(list(in_c.scales)[:groups]),
        told=JointInformation(arrays["told_information"], arrays["told_gradient"], arrays["z"]),
        displacement_px=in_c.displacement,
    )


def refined_pose_arrays(in_c: Any, lines: int, p: int) -> dict[str, FloatArray]:
    """Room for an rvdnav_refined_pose over so many lines with p parameters, given to it."""
    shapes = {
        "residuals": (lines, 2),
        "weights": (lines,),
        "gain": (6, lines, 2),
        "z": (p,),
        "joint_covariance": (6 + p, 6 + p),
        "told_information": (6 + p, 6 + p),
        "told_gradient": (6 + p,),
    }
    arrays = {name: np.empty(shape) for name, shape in shapes.items()}
    in_c.struct_size = ffi.sizeof("rvdnav_refined_pose")
    for name, array in arrays.items():
        setattr(in_c, name, pointer(array, "double *"))
    return arrays


def fit_edge_lines(camera: IntArray, edge: IntArray, q: FloatArray, n: FloatArray, sigma: FloatArray) -> EdgeLines:
    """As `rvdnav.pose.fit_edge_lines`."""
    points = np.empty(len(camera), layout.EDGE_POINT)
    points["camera"], points["edge"], points["sigma"] = camera, edge, sigma
    points["x"], points["y"] = q.T
    points["nx"], points["ny"] = n.T
    size = ffi.new("size_t *")
    check(lib.rvdnav_fit_edge_lines_size(len(points), size))
    memory, _keep = aligned_block(size[0])
    lines = np.empty(2 * lib.RVDNAV_MAX_POSE_EDGES, layout.EDGE_LINE)
    weights = np.empty(len(points))
    count = ffi.new("uint32_t *")
    out = pointer(lines, "rvdnav_edge_line *"), len(lines), count, pointer(weights, "double *")
    check(lib.rvdnav_fit_edge_lines(pointer(points, "rvdnav_edge_point *"), len(points), memory, size[0], *out))
    found = lines[: count[0]]
    return EdgeLines(
        camera=found["camera"].astype(np.int64),
        edge=found["edge"].astype(np.int64),
        rho=found["rho"].copy(),
        theta=found["theta"].copy(),
        cov=found["covariance"].reshape(-1, 2, 2),
        rms=found["rms"].copy(),
        weights=weights,
    )


def refine_pose_lines(
    T_world_target: FloatArray,
    lines: LineMeasurements,
    cameras: RectifiedCameras,
    *,
    loss: Loss = "tukey",
    k: float | None = None,
    endpoint_sigma: float = ENDPOINT_SIGMA,
    near: bool = False,
    systematics: Systematics | None = None,
) -> RefinedPose:
    """As `rvdnav.pose.refine_pose_lines`."""
    systematics = Systematics.none(len(lines)) if systematics is None else systematics
    problem = ffi.new("rvdnav_pose_problem *")
    problem.loss = _LOSSES[loss]
    problem.k = 0.0 if k is None else k
    problem.near_minimum = near
    problem.endpoint_sigma = endpoint_sigma
    return _refine(problem, T_world_target, lines, cameras, systematics)


def refine_pose_edges(
    T_world_target: FloatArray,
    lines: LineMeasurements,
    cameras: RectifiedCameras,
    systematics: Systematics | None = None,
) -> RefinedPose:
    """As `rvdnav.pose.refine_pose_edges`."""
    systematics = Systematics.none(len(lines)) if systematics is None else systematics
    problem = ffi.new("rvdnav_pose_problem *")
    problem.loss = lib.RVDNAV_LOSS_TUKEY
    problem.shown = True
    return _refine(problem, T_world_target, lines, cameras, systematics)


def _refine(
    problem: Any,
    T_world_target: FloatArray,
    lines: LineMeasurements,
    cameras: RectifiedCameras,
    systematics: Systematics,
) -> RefinedPose:
    n, p = len(lines), len(systematics)
    records = _line_records(lines)
    arrays = [np.ascontiguousarray(a) for a in (systematics.derivative, systematics.information, systematics.vector)]
    problem.struct_size = ffi.sizeof("rvdnav_pose_problem")
    problem.line_count, problem.lines = n, pointer(records, "rvdnav_pose_line *")
    set_cameras(problem.cameras, cameras)
    T = float_array(T_world_target, 4, 4)
    problem.R_W_C, problem.p_W = T[:3, :3].ravel().tolist(), T[:3, 3].tolist()
    problem.parameter_count, problem.group_count = p, len(systematics.groups)
    for number, (group, scale) in enumerate(zip(systematics.groups, systematics.scales.tolist(), strict=True)):
        problem.groups[number] = (group.size, group.doubtful, scale, group.weight, group.largest)
    problem.derivative, problem.information, problem.vector = (pointer(array, "double *") for array in arrays)
    size = ffi.new("size_t *")
    check(lib.rvdnav_refine_pose_size(n, p, size))
    memory, _keep = aligned_block(size[0])
    result = ffi.new("rvdnav_refined_pose *")
    out = refined_pose_arrays(result, n, p)
    check_pose(lib.rvdnav_refine_pose(problem, memory, size[0], result))
    return refined_pose(result, n, len(systematics.groups), out)


def _line_records(lines: LineMeasurements) -> Any:
    records = np.zeros(len(lines), layout.POSE_LINE)
    records["camera"] = lines.camera
    records["from_C"], records["to_C"] = lines.endpoints_C[:, 0], lines.endpoints_C[:, 1]
    records["rho"], records["theta"], records["shift_sigma"] = lines.rho, lines.theta, lines.shift_sigma
    records["covariance"] = lines.cov.reshape(-1, 4)
    return records
