"""One frame's measurement: from a coarse pose to a refined one with its evidence."""

from __future__ import annotations

from collections.abc import Sequence

import attrs
import numpy as np

from rvdnav.core import Core, measure_pose
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import rectified_cameras
from rvdnav.navigator.knowledge import Knowledge, Learned
from rvdnav.navigator.views import Images
from rvdnav.pose import LineMeasurements, RefinedPose, difference, perturb
from rvdnav.pose.arrays import BoolArray, FloatArray, IntArray
from rvdnav.pose.systematics import Systematics
from rvdnav.rig import Rig


@attrs.frozen(eq=False)
class Measurement:
    """A pose refined on a frame's own images, with what speaks for it."""

    pose: RefinedPose
    """Refined over ``lines``; its residuals and weights are theirs."""
    lines: LineMeasurements
    attempted: IntArray
    """(cameras, edges) profiles on the image across what is seen of an edge."""
    agreed: IntArray
    """(cameras, edges) of them: with the pose."""
    polarity: IntArray
    """(cameras, edges) +1 where those are brighter towards the normal (-dy, dx) of the edge's projection, -1 where
    darker, 0 where there are none or they differ."""
    settled: bool
    """The last round of sampling and refining changed the pose by less than its standard deviation."""
    back_coverage: FloatArray
    """(cameras, edges) the same as ``coverage`` for the back edges of side faces in sight, where the front edge agrees
    less than all along."""

    own_covariance: FloatArray
    """(6, 6) of what errs in this frame alone, and what it changed of the lasting errors; that of ``pose`` has all."""
    blur: FloatArray
    """(cameras, edges) standard deviation of the steps' blur, px."""
    systematics: Systematics
    """Of ``lines``: what was known of their common errors before this frame, at the scales that it shows."""
    learned: Learned
    """Of the lasting errors, with this frame."""
    seen: BoolArray
    """(cameras,) which of them had an image."""
    rival: FloatArray | None = None
    """(4, 4) the other one of two poses that a single view leaves, where it cannot be ruled out."""
    log_odds: float = np.inf
    """Logarithm of the odds for the pose against its rival."""

    @property
    def cameras(self) -> IntArray:
        """(k,) those whose views the lines are of; a camera with an image may see nothing of the target."""
        return np.unique(self.lines.camera)

    @property
    def coverage(self) -> FloatArray:
        """(cameras, edges) part of the profiles on the image that agree with the pose; 0 where none was possible."""
        part: FloatArray = self.agreed / np.maximum(self.attempted, 1)
        return part

    def among(self, others: Sequence[Measurement]) -> Measurement:
        """What lies in the middle of this and the other ones, where the truth may be at any; that errs alike in all
        frames."""
        T = self.pose.T_world_target
        apart = np.array([np.zeros(6)] + [difference(other.pose.T_world_target, T) for other in others])
        middle = apart.mean(axis=0)
        spread = (apart - middle).T @ (apart - middle) / len(apart)
        pose = attrs.evolve(self.pose, T_world_target=perturb(T, middle), covariance=self.pose.covariance + spread)
        return attrs.evolve(self, pose=pose)

    @property
    def total_coverage(self) -> float:
        """Part of all profiles on the images that agree with the pose."""
        return float(self.agreed.sum() / max(int(self.attempted.sum()), 1))


def measure(
    core: Core,
    rig: Rig,
    model: EdgeModel,
    knowledge: Knowledge,
    learned: Learned,
    images: Images,
    T_world_target: FloatArray,
    polarity: IntArray,
    z: FloatArray | None = None,
) -> Measurement:
    """The pose that this frame's grey values give around a coarse one.

    images: of each camera, None where it has none.  T_world_target (4, 4): good to two or three pixels.
    polarity (cameras, edges): of the edges as last seen, 0 where unknown; only the first round holds to it, so that it
    can change with the light.  learned: of the lasting errors by the frames before.  z (p,): those that the coarse
    pose was found with; what is expected of them if not given.
    Raises PoseError where the measured geometry does not determine a pose.
    """
    start = knowledge.expected(learned) if z is None else z[: knowledge.lasting]
    errors = knowledge.errors(learned, rig)
    measured = measure_pose(
        core, images, model.in_core, rectified_cameras(rig), T_world_target, polarity, errors, start
    )
    evidence, pose = measured.evidence, measured.pose
    known = knowledge.systematics(measured.derivative, learned)
    return Measurement(
        pose=pose,
        lines=measured.lines,
        attempted=evidence["attempted"].astype(np.int64),
        agreed=evidence["agreed"].astype(np.int64),
        polarity=evidence["polarity"].astype(np.int64),
        settled=measured.settled,
        back_coverage=evidence["back_coverage"],
        own_covariance=measured.own_covariance,
        blur=evidence["blur"],
        systematics=attrs.evolve(known, scales=pose.scales),
        learned=learned.with_frame(measured.information, measured.vector, pose.scales),
        seen=np.array([image is not None for image in images]),
    )
