"""The core's measurement of a pose: edges sampled, lines fitted, pose refined, until it stays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.core import layout
from rvdnav.core.arrays import image_argument, pointer
from rvdnav.core.calibration import LineEffect
from rvdnav.core.context import Context
from rvdnav.core.library import ffi, lib
from rvdnav.core.pose import check_pose, refined_pose, refined_pose_arrays, set_cameras
from rvdnav.core.status import check
from rvdnav.pose import LineMeasurements, RectifiedCameras, RefinedPose
from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray, float_array

UInt8Array = NDArray[np.uint8]


class PlanarFaces(Protocol):
    """Faces of a target in C, as `rvdnav_edge_model` has them; of f faces with v corners."""

    @property
    def normals(self) -> FloatArray:
        """(f, 3) unit, outward."""
        ...

    @property
    def origins(self) -> FloatArray:
        """(f, 3) a corner, m."""
        ...

    @property
    def axes(self) -> FloatArray:
        """(f, 2, 3) of the planes."""
        ...

    @property
    def corners(self) -> FloatArray:
        """(f, v, 2) along these from the origins, m."""
        ...

    @property
    def adjoining(self) -> BoolArray:
        """(edges, f) which edges lie on which faces."""
        ...

    @property
    def touch(self) -> float:
        """Distance below which a place lies on a face, m."""
        ...


class TargetEdges:
    """A target's straight edges as the core takes them.

    points (k, 3): their ends in C, m; point_sigmas (k,): to which each coordinate is known, m; ends (m, 2): the points
    of each edge.  thickness, m, and side_normals (8, 3): of a bracket, whose front edges they are, None for any other
    target.  faces: what may hide them, None if nothing does.
    """

    def __init__(
        self,
        points: FloatArray,
        point_sigmas: FloatArray,
        ends: IntArray,
        *,
        thickness: float | None = None,
        side_normals: FloatArray | None = None,
        faces: PlanarFaces | None = None,
    ) -> None:
        self.in_c = ffi.new("rvdnav_edge_model *")
        self._kept: list[NDArray[Any]] = []
        self.in_c.struct_size = ffi.sizeof("rvdnav_edge_model")
        self.in_c.point_count, self.in_c.edge_count = len(points), len(ends)
        self._give("points", points, np.float64)
        self._give("point_sigmas", point_sigmas, np.float64)
        self._give("ends", ends, np.int32)
        if thickness is not None and side_normals is not None:
            self.in_c.bracket, self.in_c.thickness = True, thickness
            self._give("side_normals", side_normals, np.float64)
        if faces is not None:
            self.in_c.face_count, self.in_c.corner_count = faces.corners.shape[:2]
            self.in_c.touch = faces.touch
            for name in ("normals", "origins", "axes", "corners"):
                self._give(f"face_{name}", getattr(faces, name), np.float64)
            self._give("adjoining", faces.adjoining, np.uint8)

    def _give(self, name: str, values: NDArray[Any], kind: Any) -> None:
        array = np.ascontiguousarray(values, kind)
        self._kept.append(array)
        ctype = {np.float64: "double *", np.int32: "int32_t *", np.uint8: "uint8_t *"}[kind]
        setattr(self.in_c, name, pointer(array, ctype))


@attrs.frozen(eq=False)
class RowMotion:
    """How fast a target moves while a rolling shutter exposes the rows, row_seconds one after the other; velocity (6,)
    of its origin, m/s, and angular, rad/s, in W, with covariance (6, 6)."""

    row_seconds: float
    velocity: FloatArray
    covariance: FloatArray


@attrs.frozen(eq=False)
class Errors:
    """What is known of the errors that lines share; q lasting ones, see `rvdnav_measurement_problem`.

    effect: of the calibration, None where it is exact.  scales (5,): of points, calibration, steps, edges, motion.
    information (q, q), vector (q,): what earlier frames told of the lasting ones.  motion: while a rolling shutter
    exposes the rows, None where they are exposed at once.
    """

    effect: LineEffect | None
    scales: FloatArray
    information: FloatArray
    vector: FloatArray
    motion: RowMotion | None = None


@attrs.frozen(eq=False)
class Measured:
    """What the core measures: the pose over n lines, with derivative (n, 2, p), px, of their residuals by the
    parameters; evidence (cameras, edges) as EDGE_EVIDENCE records; own_covariance (6, 6); information (q, q) and vector
    (q,): what the frame by itself tells of the lasting parameters."""

    pose: RefinedPose
    lines: LineMeasurements
    derivative: FloatArray
    evidence: NDArray[np.void]
    own_covariance: FloatArray
    information: FloatArray
    vector: FloatArray
    settled: bool


def measure_pose(
    context: Context,
    images: Sequence[UInt8Array | None],
    target: TargetEdges,
    cameras: RectifiedCameras,
    T_world_target: FloatArray,
    polarity: IntArray,
    errors: Errors,
    start: FloatArray,
) -> Measured:
    """The pose that the images' grey values give around a coarse one (4, 4), good to two or three pixels.

    polarity (cameras, edges): of the edges as last seen, +1 brighter towards the normal (-dy, dx) of their projection,
    -1 darker, 0 unknown.  start (q,): the lasting errors that the coarse pose was found with.
    Raises PoseError where the measured geometry does not determine a pose.
    """
    problem = ffi.new("rvdnav_measurement_problem *")
    problem.struct_size = ffi.sizeof("rvdnav_measurement_problem")
    problem.model = target.in_c
    set_cameras(problem.cameras, cameras)
    T = float_array(T_world_target, 4, 4)
    problem.R_W_C, problem.p_W = T[:3, :3].ravel().tolist(), T[:3, 3].tolist()
    arrays = [np.ascontiguousarray(values, np.float64) for values in (errors.information, errors.vector, start)]
    seen_polarity = np.ascontiguousarray(polarity, np.int32)
    q = problem.lasting_count = len(arrays[1])
    problem.polarity = pointer(seen_polarity, "int32_t *")
    problem.effect = ffi.NULL if errors.effect is None else errors.effect.in_c
    problem.scales = errors.scales.tolist()
    for name, array in zip(("information", "vector", "start"), arrays, strict=True):
        setattr(problem, name, pointer(array, "double *"))
    if errors.motion is not None:
        problem.motion.row_seconds = errors.motion.row_seconds
        problem.motion.velocity = errors.motion.velocity.tolist()
        problem.motion.covariance = errors.motion.covariance.ravel().tolist()
    given = [(ffi.NULL, None) if image is None else image_argument(image) for image in images]
    left, right = ([c_image for c_image, _ in given] + [ffi.NULL])[:2]
    size, parameters = ffi.new("size_t *"), ffi.new("uint32_t *")
    check(lib.rvdnav_measure_size(context.handle, problem, size, parameters))
    p, most = parameters[0], polarity.size
    out = ffi.new("rvdnav_measurement *")
    out.struct_size = ffi.sizeof("rvdnav_measurement")
    of_pose = refined_pose_arrays(out.pose, most, p)
    evidence = np.empty(polarity.shape, layout.EDGE_EVIDENCE)
    lines, edges = np.empty(most, layout.POSE_LINE), np.empty(most, np.int32)
    derivative, information, vector = np.empty(2 * most * p), np.empty((q, q)), np.empty(q)
    out.evidence = pointer(evidence, "rvdnav_edge_evidence *")
    out.lines, out.line_edges = pointer(lines, "rvdnav_pose_line *"), pointer(edges, "int32_t *")
    out.derivative = pointer(derivative, "double *")
    out.taught_information, out.taught_vector = pointer(information, "double *"), pointer(vector, "double *")
    memory = context.lend(size[0])
    check_pose(lib.rvdnav_measure(context.handle, left, right, problem, memory, size[0], out))
    n = out.line_count
    found = lines[:n]
    return Measured(
        pose=refined_pose(out.pose, n, len(errors.scales), of_pose),
        lines=LineMeasurements(
            camera=found["camera"],
            edge=edges[:n],
            endpoints_C=np.stack([found["from_C"], found["to_C"]], axis=1),
            rho=found["rho"],
            theta=found["theta"],
            cov=found["covariance"].reshape(-1, 2, 2),
            shift_sigma=found["shift_sigma"],
        ),
        derivative=derivative[: 2 * n * p].reshape(n, 2, p),
        evidence=evidence,
        own_covariance=np.array(list(out.own_covariance)).reshape(6, 6),
        information=information,
        vector=vector,
        settled=bool(out.settled),
    )
