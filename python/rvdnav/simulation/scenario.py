"""What a simulation is made from: target, rig, motion, light, background, sensor; and what its files say of them."""

from __future__ import annotations

import enum
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike

from rvdnav.faults import knowledge
from rvdnav.pose.arrays import FloatArray, float_array
from rvdnav.rig import Rig
from rvdnav.simulation.course import Motion
from rvdnav.simulation.solids import solid
from rvdnav.target import Target

START_NS = 1_700_000_000_000_000_000
"""Timestamp of the first frame."""
LEAST_GAMMA = 0.05
OMISSIONS = ("timing", "edge_radius")
"""What a sequence's files may leave out."""


class Background(enum.Enum):
    """What is behind the target."""

    STARS = "stars"
    EARTH = "earth"
    WALL = "wall"


def _unit(values: ArrayLike) -> FloatArray:
    vector = float_array(values, 3)
    length = float(np.linalg.norm(vector))
    if length == 0.0:
        raise ValueError("a direction has no length")
    unit: FloatArray = vector / length
    unit.setflags(write=False)
    return unit


def _at_least(least: float) -> Any:
    def check(_: Any, attribute: attrs.Attribute[Any], value: float) -> None:
        if not least <= value < np.inf:
            raise ValueError(f"{attribute.name} is less than {least:g}")

    return check


_SAME = attrs.cmp_using(eq=np.array_equal)


@attrs.frozen
class Lights:
    """Irradiances, in one arbitrary unit; only their ratios matter, for the exposure follows the light.

    led: of both LED strips beside the cameras together, 1 m ahead.  sun: across its rays.  ambient: from the chaser's
    side, evenly; with a wall behind the target, from all around.  towards_sun_W (3,): direction in W.
    """

    led: float = attrs.field(default=1.0, validator=_at_least(0.0))
    sun: float = attrs.field(default=0.0, validator=_at_least(0.0))
    ambient: float = attrs.field(default=0.01, validator=_at_least(0.0))
    towards_sun_W: FloatArray = attrs.field(default=(-1.0, 0.0, 0.0), converter=_unit, eq=_SAME)

    def __attrs_post_init__(self) -> None:
        if self.led + self.sun + self.ambient == 0.0:
            raise ValueError("there is no light at all")


@attrs.frozen
class Sensor:
    """The way from light to digital numbers (DN), 8 bits.

    psf_sigma: of the lens's Gaussian blur, px.  level: DN above black of a surface like the bracket's.  black_level:
    DN.  read_noise: sigma, DN.  shot_noise: variance per DN of signal, DN.  prnu: relative sigma of the pixels' gains.
    vignetting: part of the light that is lost in the image's corner.  gamma: exponent of the response, a part of 255
    DN made another part.  sharpening: how often an unsharp mask of 1.5 px is added to what comes of that.
    """

    psf_sigma: float = attrs.field(default=0.6, validator=_at_least(0.0))
    level: float = attrs.field(default=150.0, validator=_at_least(1.0))
    black_level: float = attrs.field(default=6.0, validator=_at_least(0.0))
    read_noise: float = attrs.field(default=1.0, validator=_at_least(0.0))
    shot_noise: float = attrs.field(default=0.025, validator=_at_least(0.0))
    prnu: float = attrs.field(default=0.006, validator=_at_least(0.0))
    vignetting: float = attrs.field(default=0.15, validator=_at_least(0.0))
    gamma: float = attrs.field(default=1.0, validator=_at_least(LEAST_GAMMA))
    sharpening: float = attrs.field(default=0.0, validator=_at_least(0.0))


@attrs.frozen
class Files:
    """How far the sequence's files are from what its images were made of.

    calibration: standard deviations of each camera's focal length, %, and principal point, px, and of the rotation
    between the cameras, degrees.  target_sizes_mm, target_points_mm: of the target's sizes, and of each of its points.
    tolerance_mm: of each point, as the files state it, or None for what the target states.
    omit: which of `OMISSIONS` the files don't mention: the rows' times, rounded edges.
    """

    calibration: tuple[float, float, float] = (0.0, 0.0, 0.0)
    target_sizes_mm: float = attrs.field(default=0.0, validator=_at_least(0.0))
    target_points_mm: float = attrs.field(default=0.0, validator=_at_least(0.0))
    tolerance_mm: float | None = attrs.field(default=None, validator=attrs.validators.optional(_at_least(0.0)))
    omit: tuple[str, ...] = ()


@attrs.frozen
class Scenario:
    """One run: everything that its images follow from.

    samples: rays a pixel.  nadir_W (3,): direction in W of the Earth's centre.  wall_distance: along the rig's optical
    axis, m.  frames at `rate`, Hz, from `START_NS` on.

    Raises ValueError for numbers that make no sense.
    """

    name: str
    seed: int = attrs.field(validator=_at_least(0))
    frames: int = attrs.field(validator=_at_least(1))
    rate: float = attrs.field(validator=_at_least(1e-3))
    rig: Rig
    target: Target
    motion: Motion
    lights: Lights = Lights()
    background: Background = Background.STARS
    nadir_W: FloatArray = attrs.field(default=(0.2, 1.0, 0.0), converter=_unit, eq=_SAME)
    wall_distance: float = attrs.field(default=2.5, validator=_at_least(0.1))
    sensor: Sensor = Sensor()
    samples: int = attrs.field(default=36, validator=_at_least(1))
    files: Files = Files()

    def __attrs_post_init__(self) -> None:
        self.told_rig()
        self.told_target()
        if self.target.bracket is None and not self.target.faces:
            raise ValueError("the target has neither a four-bar bracket nor faces")
        self._check_edges()
        for frame in range(self.frames):
            self._check_place(frame)

    def _check_edges(self) -> None:
        bracket = self.target.bracket
        if bracket is None:
            solid(self.target)
        elif self.target.edge_radius > 0.49 * min(bracket.thickness, float(bracket.bar_widths.min())):
            raise ValueError("edge_radius is half of a bar's width or thickness")

    def _check_place(self, frame: int) -> None:
        T = self.T_world_target(frame)
        points = np.array(list(self.target.points.values())) @ T[:3, :3].T + T[:3, 3]
        depths = [(points - T_cam[:3, 3]) @ T_cam[:3, 2] for T_cam in self.rig.T_world_cam]
        if min(depth.max() for depth in depths) <= 0.0:
            raise ValueError(f"the target is behind a camera in frame {frame}")

    def told_rig(self) -> Rig:
        """The rig that the sequence's files describe."""
        rng = np.random.default_rng([self.seed, 5])
        rig = knowledge.calibration(self.rig, rng, *self.files.calibration) if any(self.files.calibration) else self.rig
        if "timing" in self.files.omit:
            rig = attrs.evolve(rig, exposure_ns=0, line_delay_ns=0, field_delay_ns=0, scan="progressive")
        return rig

    def told_target(self) -> Target:
        """The target that the sequence's files describe."""
        rng = np.random.default_rng([self.seed, 6])
        target = self.target
        if self.files.target_sizes_mm:
            target = knowledge.target_sizes(target, rng, self.files.target_sizes_mm)
        if self.files.target_points_mm:
            target = knowledge.target_points(target, rng, self.files.target_points_mm)
        if self.files.tolerance_mm is not None:
            target = attrs.evolve(target, tolerance=dict.fromkeys(target.points, 1e-3 * self.files.tolerance_mm))
        return attrs.evolve(target, edge_radius=0.0) if "edge_radius" in self.files.omit else target

    def timestamp_ns(self, frame: int) -> int:
        """Of a frame, counted from 0."""
        return START_NS + round(frame * 1e9 / self.rate)

    def T_world_target(self, frame: int, delay: float = 0.0) -> FloatArray:
        """The true pose (4, 4) in a frame, or at another time, s, after its stamp."""
        return self.motion.T_world_target(frame / self.rate + delay, (self.frames - 1) / self.rate)

    def target_middle(self, frame: int) -> FloatArray:
        """The mean (3,) of the target's points, m in W."""
        T = self.T_world_target(frame)
        middle: FloatArray = T[:3, :3] @ np.mean(list(self.target.points.values()), axis=0) + T[:3, 3]
        return middle
