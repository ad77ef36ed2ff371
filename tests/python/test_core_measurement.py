"""The core's measurement beside the one that can be read: the same evidence and the same pose, whatever is measured.

Both take the steps of profiles from the core; from there on they share nothing but the frame.
"""

from __future__ import annotations

from collections.abc import Callable

import attrs
import cv2
import numpy as np
import pytest
import readable_navigator.measurement as readable
from drawn_scene import START_NS, Look, bracket_target, draw_images, example_rig, pose, wide_rig
from drawn_solid import box_target, draw_solid, frame_surfaces, frame_target, panel_surfaces, panel_target, surfaces
from rvdnav import Rig
from rvdnav.core import Core
from rvdnav.errors import CoreError
from rvdnav.navigator.edge_model import EdgeModel, edge_model
from rvdnav.navigator.knowledge import Knowledge, Learned
from rvdnav.navigator.measurement import Measurement, measure
from rvdnav.navigator.shutter import Motion
from rvdnav.navigator.views import Images
from rvdnav.pose import PoseError, difference, perturb
from rvdnav.target import Target

POSE = pose(0.7, -0.02, 0.05, 8.0, -11.0, 4.0)


@attrs.frozen
class Scene:
    """Images, where the target is, and what is known of it."""

    rig: Rig
    target: Target
    images: Images
    T: np.ndarray
    learned: Callable[[Learned], Learned] = lambda learned: learned

    def measured(self, by: Callable[..., Measurement], off: float = 0.0015) -> Measurement:
        """From a coarse pose that is off by so many metres, and twice as many radians."""
        model = edge_model(self.target)
        knowledge = Knowledge(self.rig, model)
        learned = self.learned(Learned.nothing(knowledge.lasting))
        T = perturb(self.T, off * np.array([1.0, -0.5, 0.4, 1.0, 2.0, -1.5]))
        unknown = np.zeros((len(self.rig.cameras), len(model)), np.int64)
        return by(Core(self.rig, self.target), self.rig, model, knowledge, learned, self.images, T, unknown)


def bracket_scene(rig: Rig, T: np.ndarray = POSE, look: Look | None = None) -> Scene:
    target = bracket_target()
    return Scene(rig, target, draw_images(rig, target, T, seed=1, look=look), T)


def taught(learned: Learned) -> Learned:
    """As if frames before had told something of every lasting parameter."""
    rng = np.random.default_rng(4)
    root = rng.standard_normal((len(learned.vector),) * 2)
    information = 0.2 * root @ root.T
    mean = 0.3 * rng.standard_normal(len(learned.vector))
    return Learned(information, information @ mean, np.array([1.5, 0.8, 1.0, 2.0, 1.0]), 3)


def blurred(scene: Scene, sigma: float) -> Scene:
    return attrs.evolve(scene, images=tuple(cv2.GaussianBlur(image, (0, 0), sigma) for image in scene.images))


def moving(scene: Scene) -> Scene:
    """Before a rolling shutter, at a speed that the filter knows to some extent."""
    motion = Motion(np.array([-0.05, 0.04, 0.02, 0.05, -0.08, 0.03]), 1e-3 * np.eye(6))
    rig = attrs.evolve(scene.rig, line_delay_ns=20_000)
    return attrs.evolve(scene, rig=rig, learned=lambda learned: attrs.evolve(learned, motion=motion))


def blind(scene: Scene, camera: int) -> Scene:
    images = tuple(None if index == camera else image for index, image in enumerate(scene.images))
    return attrs.evolve(scene, images=images)


def solid_scene(target: Target, faces: list[object], T: np.ndarray) -> Scene:
    frame = draw_solid(example_rig(), faces, T, timestamp_ns=START_NS)
    return Scene(example_rig(), target, (frame.left.pixels, frame.right.pixels), T)


def scenes() -> dict[str, Scene]:
    stereo = bracket_scene(example_rig())
    box, panel, frame = box_target(), panel_target(), frame_target()
    tolerance = {name: 1e-4 * number for number, name in enumerate(stereo.target.points)}
    left = Rig(stereo.rig.cameras[:1], stereo.rig.T_world_cam[:1])
    return {
        "stereo": stereo,
        "taught": attrs.evolve(stereo, learned=taught),
        "near, beyond the images' borders": bracket_scene(example_rig(), pose(0.33, 0.02, 0.05, -9.0, 14.0, 3.0)),
        "sides as light as the front": bracket_scene(example_rig(), look=Look(side=150.0)),
        "exact calibration": bracket_scene(wide_rig()),
        "points of different tolerance": attrs.evolve(stereo, target=attrs.evolve(stereo.target, tolerance=tolerance)),
        "out of focus": blurred(stereo, 1.6),
        "far out of focus": blurred(stereo, 3.5),
        "rolling shutter": moving(stereo),
        "left image missing": blind(stereo, 0),
        "one camera": attrs.evolve(stereo, rig=left, images=stereo.images[:1]),
        "box": solid_scene(box, surfaces(box), pose(0.75, 0.0, 0.04, 0.0, 25.0, 30.0)),
        "box, rolling shutter": moving(solid_scene(box, surfaces(box), pose(0.6, 0.0, 0.04, 5.0, -35.0, 20.0))),
        "panel": solid_scene(panel, panel_surfaces(panel), pose(0.7, 0.0, 0.04, 10.0, -20.0, 10.0)),
        "frame": solid_scene(frame, frame_surfaces(frame), pose(0.7, 0.0, 0.04, -10.0, 15.0, 8.0)),
    }


SCENES = scenes()


@pytest.mark.parametrize("name", SCENES)
def test_the_same_measurement(name: str) -> None:
    scene = SCENES[name]
    found, expected = scene.measured(measure), scene.measured(readable.measure)
    for field in ("attempted", "agreed", "polarity", "settled", "back_coverage", "seen"):
        np.testing.assert_array_equal(getattr(found, field), getattr(expected, field), err_msg=field)
    assert expected.total_coverage > 0.5
    np.testing.assert_allclose(found.blur, expected.blur, rtol=1e-7)
    for field in ("camera", "edge"):
        np.testing.assert_array_equal(getattr(found.lines, field), getattr(expected.lines, field))
    for field in ("endpoints_C", "rho", "theta", "shift_sigma"):
        values, wanted = getattr(found.lines, field), getattr(expected.lines, field)
        np.testing.assert_allclose(values, wanted, rtol=0.0, atol=1e-6, err_msg=field)
    # Rounding in units of the standard deviations, of which even a thousandth would not matter.
    sigma = np.sqrt(np.diagonal(expected.pose.joint_covariance))
    error = difference(found.pose.T_world_target, expected.pose.T_world_target)
    assert np.abs(np.concatenate([error, found.pose.z - expected.pose.z]) / sigma).max() < 1e-5
    units = np.outer(sigma, sigma)
    covariances = ((found.pose.covariance, expected.pose.covariance), (found.own_covariance, expected.own_covariance))
    for covariance, wanted in covariances:
        assert np.abs((covariance - wanted) / units[:6, :6]).max() < 1e-5
    derivative = found.systematics.derivative
    np.testing.assert_allclose(derivative, expected.systematics.derivative, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(found.systematics.scales, expected.systematics.scales, rtol=1e-5)
    np.testing.assert_array_equal(found.systematics.information, expected.systematics.information)
    told = np.sqrt(np.maximum(np.diagonal(expected.learned.information), 1e-12))
    taught_more = (found.learned.information - expected.learned.information) / np.outer(told, told)
    assert np.abs(taught_more).max(initial=0.0) < 1e-5
    assert np.abs((found.learned.vector - expected.learned.vector) / told).max(initial=0.0) < 1e-5
    assert found.learned.frames == expected.learned.frames


def test_the_scenes_take_every_way() -> None:
    """Else their agreement would show little."""
    measured = {name: scene.measured(measure) for name, scene in SCENES.items()}
    assert np.median(measured["out of focus"].blur) > 1.5
    assert np.median(measured["far out of focus"].blur) > 3.0
    assert (measured["sides as light as the front"].back_coverage > 0.0).any()
    assert measured["rolling shutter"].pose.z.shape[0] == measured["stereo"].pose.z.shape[0] + 6
    assert (measured["box"].attempted == 0).any()
    assert not measured["left image missing"].attempted[0].any()
    assert measured["one camera"].attempted.shape == (1, 8)


def test_what_gives_no_pose_is_refused() -> None:
    stereo = SCENES["stereo"]
    blank = attrs.evolve(stereo, images=tuple(np.full_like(image, 90) for image in stereo.images))
    behind = attrs.evolve(stereo, T=pose(-0.7, 0.0, 0.05, 0.0, 0.0, 0.0))
    for scene, fault in ((blank, "do not determine"), (behind, "not in front")):
        for by in (measure, readable.measure):
            with pytest.raises(PoseError, match=fault):
                scene.measured(by)


def test_a_model_that_is_none_is_refused() -> None:
    stereo = SCENES["stereo"]
    model = EdgeModel.of_bracket(stereo.target.bracket)
    knowledge = Knowledge(stereo.rig, model)
    nowhere = attrs.evolve(model, ends=model.ends + 1)
    unknown, learned = np.zeros((2, 8), np.int64), Learned.nothing(knowledge.lasting)
    with pytest.raises(CoreError, match="degenerate"):
        measure(Core(stereo.rig), stereo.rig, nowhere, knowledge, learned, stereo.images, stereo.T, unknown)
