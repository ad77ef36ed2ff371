"""Whether a rig is still true, from a flown sequence: what the bracket's known shape says in both views.

Each view by itself gives the bracket's pose from its known dimensions; where the two disagree the rig has changed.
From the lines of all frames the turn d of the cameras against each other (R_cam1_cam0 = exp([d]x) R_hat) is estimated
together with every frame's pose, and compared with what its errors and the calibration's own covariance allow.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from rvdnav.bracket import EDGE_APEXES, Bracket
from rvdnav.core import Core
from rvdnav.errors import InputError
from rvdnav.navigator.calibration import CalibrationEffect
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.navigator.knowledge import Knowledge, Learned
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.navigator.surveyor import Surveyor
from rvdnav.pose import LineMeasurements, PoseError, line_residuals, refine_pose_lines, triangulate
from rvdnav.pose.arrays import BoolArray, FloatArray
from rvdnav.rig import Rig
from rvdnav.sequence import Sequence
from rvdnav.solution import Reason
from rvdnav.summary import counted

MAX_FRAMES = 24
_ROTATION = slice(16, 19)
"""Of the calibration's parameters: rx, ry, rz of cam1_cam0."""
_MIN_FRAMES = 3
_TRUSTED = 0.2
_MISSING = (Reason.LEFT_MISSING, Reason.RIGHT_MISSING)
_MIN_LINES = 4
"""Of a view, so that it determines a pose."""
_ENDPOINT_SIGMA_PX = 0.08
_FLOOR_PX = 0.05
"""What shifts one view's lines against the other's alike in all frames: light, blur, the bracket's tolerances."""
_CHI2 = 11.34
"""Of three degrees of freedom, exceeded by chance once in a hundred times."""
_BARS_AT_APEX = tuple(
    tuple(bar for bar, apexes in enumerate(EDGE_APEXES) if apex in apexes) for apex in range(len(EDGE_APEXES))
)


@attrs.frozen(eq=False)
class FrameEvidence:
    """What one frame says.

    epipolar_px (k,): rectified row of the bracket's corners, left minus right.  length_errors (m,): of the distances
    between neighbouring corners as triangulated, relative to the target's.  information (3, 3), rad^-2, and right_side
    (3,): of the turn.
    """

    epipolar_px: FloatArray
    length_errors: FloatArray
    information: FloatArray
    right_side: FloatArray


@attrs.frozen(eq=False)
class RigCheck:
    """What a sequence says of its rig.

    frames: those measured, of `looked_at`, which are spread over `sequence_frames`.  refused: why the others were not,
    and how many for each reason; a frame may have several.  turn (3,), rad, about the right camera's axes: by how much
    R_cam1_cam0 differs from the calibration; covariance (3, 3), in which the calibration's own is.  epipolar_px,
    length_errors: of all frames together, see `FrameEvidence`.
    """

    frames: int
    looked_at: int
    sequence_frames: int
    refused: tuple[tuple[Reason, int], ...]
    turn: FloatArray
    covariance: FloatArray
    epipolar_px: FloatArray
    length_errors: FloatArray

    @property
    def chi2(self) -> float:
        """Of the turn, with three degrees of freedom where the rig is true."""
        return float(self.turn @ np.linalg.solve(self.covariance, self.turn))

    @property
    def limit(self) -> float:
        """Of `chi2`: what chance exceeds once in a hundred true rigs."""
        return _CHI2

    @property
    def due(self) -> bool:
        """Whether the rig should be calibrated again."""
        return self.chi2 > _CHI2


def check_rig(sequence: Sequence) -> RigCheck:
    """Check the rig of a sequence by at most `MAX_FRAMES` of its frames, spread evenly.

    Raises InputError where the sequence has no two cameras, no bracket of known dimensions, or too few frames in which
    both cameras show it.
    """
    rig, target = sequence.rig, sequence.target
    bracket = target.bracket
    if not rig.is_stereo:
        raise InputError(f"{sequence.path}: has one camera; a check needs two")
    if bracket is None or not target.dimensions_known:
        raise InputError(f"{sequence.path / 'target.yaml'}: a check needs a four-bar bracket of known dimensions")
    model = EdgeModel.of_bracket(bracket)
    knowledge = Knowledge(rig, model)
    surveyor = Surveyor(Core(rig, target), rig, model, knowledge, NavigatorSettings())
    learned = Learned.nothing(knowledge.lasting)
    effect = CalibrationEffect.of(rig)
    indices = sorted({int(i) for i in np.linspace(0, len(sequence) - 1, min(MAX_FRAMES, len(sequence))).round()})
    found: list[FrameEvidence] = []
    refused: list[Reason] = []
    for index in indices:
        frame = sequence[index]
        if frame.left is None or frame.right is None:
            refused += [
                reason for reason, image in zip(_MISSING, (frame.left, frame.right), strict=True) if image is None
            ]
            continue
        attempt = surveyor.acquire((frame.left.pixels, frame.right.pixels), None, learned, {})
        if attempt.measurement is None:
            refused += attempt.reasons
            continue
        # What a run would refuse counts too: it may be the rig that is wrong about it.
        evidence = _evidence(attempt.measurement.pose.T_world_target, attempt.measurement.lines, effect, bracket)
        if evidence is None:
            refused.append(Reason.TOO_FEW_LINES)
        else:
            found.append(evidence)
    why = counted(refused)
    if len(found) < _MIN_FRAMES:
        told = ", ".join(f"{reason.name} {count}" for reason, count in why)
        raise InputError(
            f"{sequence.path}: both cameras show the bracket in {len(found)} of {len(indices)} frames, where "
            f"{_MIN_FRAMES} are needed" + (f" ({told})" if told else "")
        )
    return _judge(found, rig, looked_at=len(indices), sequence_frames=len(sequence), refused=tuple(why))


def _evidence(
    T_world_target: FloatArray, lines: LineMeasurements, effect: CalibrationEffect, bracket: Bracket
) -> FrameEvidence | None:
    """None where a view by itself does not determine a pose."""
    cameras = rectified_cameras(effect.rig)
    trusted = np.zeros(len(lines), dtype=np.bool_)
    try:
        for camera in range(2):
            own = np.flatnonzero(lines.camera == camera)
            if len(own) < _MIN_LINES:
                return None
            alone = refine_pose_lines(
                T_world_target, _chosen(lines, own), cameras, endpoint_sigma=_ENDPOINT_SIGMA_PX, near=True
            )
            trusted[own] = alone.weights > _TRUSTED
        if min(np.count_nonzero(trusted & (lines.camera == camera)) for camera in range(2)) < _MIN_LINES:
            return None
        lines = _chosen(lines, np.flatnonzero(trusted))
        distances, J = line_residuals(T_world_target, lines, cameras)
        turns = effect.residual_derivatives(T_world_target, lines)[:, :, _ROTATION]
        left, right = (_corners(lines, camera) for camera in range(2))
        both: BoolArray = np.isfinite(left[:, 0]) & np.isfinite(right[:, 0])
        lengths = _length_errors(left, right, both, effect.rig, bracket)
    except PoseError:
        return None
    whitening = 1.0 / np.sqrt(_ENDPOINT_SIGMA_PX**2 + lines.shift_sigma**2 + lines.cov[:, 0, 0])[:, None]
    r = (distances * whitening).ravel()
    A = (J * whitening[:, :, None]).reshape(len(r), -1)
    B = (turns * whitening[:, :, None]).reshape(len(r), -1)
    q, _ = np.linalg.qr(A)
    B, r = B - q @ (q.T @ B), r - q @ (q.T @ r)  # the frame's pose eliminated
    return FrameEvidence((left - right)[both, 1], lengths, B.T @ B, -B.T @ r)


def _chosen(lines: LineMeasurements, index: NDArray[np.intp]) -> LineMeasurements:
    return LineMeasurements(*(getattr(lines, field.name)[index] for field in attrs.fields(LineMeasurements)))


def _corners(lines: LineMeasurements, camera: int) -> FloatArray:
    """Where a view's lines meet: the outer apexes P1..P4, then the inner ones (8, 2), rectified px; NaN without."""
    own = {int(edge): k for k, edge in enumerate(lines.edge) if lines.camera[k] == camera}
    corners = np.full((8, 2), np.nan)
    for inner in range(2):
        for apex, bars in enumerate(_BARS_AT_APEX):
            edges = [own.get(2 * bar + inner) for bar in bars]
            if None not in edges:
                k = np.array(edges)
                normals = np.column_stack([np.cos(lines.theta[k]), np.sin(lines.theta[k])])
                corners[4 * inner + apex] = np.linalg.solve(normals, lines.rho[k])
    return corners


def _length_errors(left: FloatArray, right: FloatArray, both: BoolArray, rig: Rig, bracket: Bracket) -> FloatArray:
    """Relative errors (m,) of the distances between neighbouring corners, triangulated, from the target's."""
    points = np.full((8, 3), np.nan)
    points[both] = triangulate(rig.projection_matrix(0), rig.projection_matrix(1), left[both], right[both])
    true = np.concatenate([bracket.outer, bracket.inner])
    pairs = np.array([(a + 4 * inner, b + 4 * inner) for inner in range(2) for a, b in EDGE_APEXES])
    lengths = np.linalg.norm(points[pairs[:, 0]] - points[pairs[:, 1]], axis=1)
    errors: FloatArray = lengths / np.linalg.norm(true[pairs[:, 0]] - true[pairs[:, 1]], axis=1) - 1.0
    return errors[np.isfinite(errors)]


def _judge(
    found: list[FrameEvidence],
    rig: Rig,
    *,
    looked_at: int,
    sequence_frames: int,
    refused: tuple[tuple[Reason, int], ...],
) -> RigCheck:
    """The turn over all frames; its covariance follows the frames' scatter where that is more than they state."""
    total = np.sum([evidence.information for evidence in found], axis=0)
    inverse = np.linalg.inv(total)
    turn = inverse @ np.sum([evidence.right_side for evidence in found], axis=0)
    gradients = [evidence.right_side - evidence.information @ turn for evidence in found]
    scatter = float(np.sum([g @ inverse @ g for g in gradients]))
    expected = float(np.sum([np.trace(inverse @ e.information @ (np.eye(3) - inverse @ e.information)) for e in found]))
    covariance = inverse * max(1.0, scatter / expected) + np.eye(3) * (_FLOOR_PX / rig.focal_rect) ** 2
    if rig.calibration_covariance is not None:
        covariance = covariance + rig.calibration_covariance[_ROTATION, _ROTATION]
    return RigCheck(
        frames=len(found),
        looked_at=looked_at,
        sequence_frames=sequence_frames,
        refused=refused,
        turn=turn,
        covariance=covariance,
        epipolar_px=np.concatenate([evidence.epipolar_px for evidence in found]),
        length_errors=np.concatenate([evidence.length_errors for evidence in found]),
    )
