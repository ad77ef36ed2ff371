"""Whatever the images show, a frame has a solution; only misuse raises, and leaves the navigator as it was."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np
import pytest
from drawn_scene import START_NS, STEP_NS, bracket_target, draw_images, example_rig, frame_of, pose
from readable_navigator.sampling import Surroundings, sample_edges
from rvdnav import Navigator, open_sequence
from rvdnav.core import Core
from rvdnav.navigator.edge_model import edge_model
from rvdnav.navigator.geometry import FAR_PX, project_edges, rectified_cameras
from rvdnav.navigator.settings import NavigatorSettings
from rvdnav.navigator.windows import predicted_windows
from rvdnav.pose import PredictedPose
from soak import soak

RIG, TARGET = example_rig(), bracket_target()
APPROACH = Path(__file__).resolve().parents[2] / "examples" / "approach"


def test_spoilt_frames_raise_nothing_and_publish_nothing_wrong() -> None:
    outcome = soak(open_sequence(APPROACH), 48, seed=5)
    assert outcome.frames == 48
    assert outcome.judged >= 12  # else there was nothing to be wrong
    assert (outcome.wrong, outcome.beyond) == (0, 0)


def nearly_touching() -> np.ndarray:
    """A pose that puts one end of the long base 1 mm before the cameras: it is seen beyond every image."""
    T = pose(1e-3 - TARGET.bracket.outer[:, 1].min(), 0.0, 0.06, 0.0, 0.0, 0.0)
    T[:3, :3] = T[:3, :3] @ np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    return T


def test_edges_beyond_every_image_are_left_out() -> None:
    model, cameras, T = edge_model(TARGET), rectified_cameras(RIG), nearly_touching()
    beyond = (np.abs(project_edges(cameras, 0, T, model.edge_points)[0]) > FAR_PX).any(axis=(1, 2))
    assert 0 < beyond.sum() < len(model)
    images = draw_images(RIG, TARGET, pose(0.8, 0.0, 0.06, 0.0, 0.0, 0.0))
    unknown = np.zeros((2, len(model)), np.int64)
    beside = Surroundings(np.full((2, len(model)), 1e9), np.full((2, len(model)), 1e9))
    sampled = sample_edges(Core(RIG, TARGET), RIG, images, T, model, 2.5, unknown, beside)
    assert not sampled.attempted[0, beyond].any()
    settings = NavigatorSettings(window_max_rho_px=1e5)
    prediction = PredictedPose(T, np.diag([1e-10] * 6))
    windows = predicted_windows(prediction, model, cameras, 0, unknown[0], np.zeros((len(model), 2)), settings)
    assert windows is not None
    assert set(windows["edge"]) <= set(np.flatnonzero(~beyond))
    assert Core(RIG, TARGET).process(*images, windows, windows).bracket is None


@pytest.mark.parametrize("fault", ["size", "type"])
def test_misuse_leaves_the_memory_as_it_was(fault: str) -> None:
    navigator, undisturbed = Navigator(RIG, TARGET), Navigator(RIG, TARGET)
    frames = []
    for number in range(3):
        images = draw_images(RIG, TARGET, pose(0.8, 0.01, 0.06, 2.0, -3.0, 2.0), seed=number)
        frames.append(frame_of(images, START_NS + number * STEP_NS))
    for each in (navigator, undisturbed):
        assert each.process(frames[0]).published
    before = navigator.memory
    right = frames[1].right
    assert right is not None
    spoilt = attrs.evolve(right, pixels=right.pixels[:-1]) if fault == "size" else right.pixels
    with pytest.raises((ValueError, AttributeError), match="704x575 px" if fault == "size" else "pixels"):
        navigator.process(attrs.evolve(frames[1], right=spoilt))
    after = navigator.memory
    for field in attrs.fields(type(before)):
        old, new = getattr(before, field.name), getattr(after, field.name)
        assert old is new or np.array_equal(old, new), field.name
    for frame in frames[1:]:
        given, expected = navigator.process(frame), undisturbed.process(frame)
        assert given.published
        np.testing.assert_array_equal(given.T_world_target, expected.T_world_target)
