"""Interlaced images: when they are noticed, what their fields are, and what pose comes of them."""

import attrs
import cv2
import numpy as np
import pytest
from drawn_scene import START_NS, bracket_target, draw_images, example_rig, frame_of, pose
from rvdnav import Navigator
from rvdnav.core import field_signs
from rvdnav.navigator.fields import comb_odds, doubled, field, noticed_fields
from rvdnav.solution import Reason

NEAR = pose(0.6, 0.01, 0.05, 4.0, -6.0, 5.0)
LATER = pose(0.6, 0.013, 0.051, 4.0, -6.0, 5.0)


@pytest.fixture(scope="module")
def drawn():
    """Both images at two times."""
    rig, target = example_rig(), bracket_target()
    return draw_images(rig, target, NEAR), draw_images(rig, target, LATER, seed=1)


def woven(top, bottom):
    """One field of each."""
    result = top.copy()
    result[1::2] = bottom[1::2]
    return result


def degraded(image):
    """The image as other faults leave it."""
    rng = np.random.default_rng(3)
    noisy = np.clip(image + rng.normal(0.0, 12.0, image.shape), 0, 255).astype(np.uint8)
    rows = np.clip(image + rng.normal(0.0, 8.0, (len(image), 1)), 0, 255).astype(np.uint8)
    jpeg = cv2.imdecode(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 20])[1], cv2.IMREAD_GRAYSCALE)
    texture = (128 + 60 * np.sin(1.9 * np.arange(image.shape[1]) + 0.7 * np.arange(len(image))[:, None])).astype(
        np.uint8
    )
    return noisy, rows, jpeg, texture


def test_a_field_that_moved_is_noticed_and_no_other_image(drawn):
    for first, second in zip(*drawn, strict=True):
        assert comb_odds(field_signs(woven(first, second))) > 3.0
        for image in (first, *degraded(first)):
            assert comb_odds(field_signs(image)) < 0.0
            assert not doubled(field_signs(image))


def test_doubled_rows_are_noticed(drawn):
    image = drawn[0][0]
    twice = np.repeat(image[::2], 2, axis=0)
    noise = np.random.default_rng(4).integers(0, 4, image.shape, np.uint8)
    assert doubled(field_signs(twice))
    assert doubled(field_signs(np.minimum(twice, 252) + noise))
    assert not doubled(field_signs(np.repeat(image[:, ::2], 2, axis=1)))
    assert not doubled(field_signs(np.full_like(image, 30)))


@pytest.mark.parametrize("camera", [0, 1])
def test_of_two_images_only_the_doubled_one_is_taken_for_a_field(drawn, camera):
    images = list(drawn[0])
    images[camera] = np.repeat(images[camera][::2], 2, axis=0)
    fields, _ = noticed_fields(tuple(images), 0.0)
    assert fields.noticed
    assert fields.second is None
    assert np.array_equal(fields.first[camera], field(images[camera], 0))
    assert np.array_equal(fields.first[1 - camera], images[1 - camera])


@pytest.mark.parametrize("first_row", [0, 1])
def test_a_field_is_the_smoothed_image_whatever_the_other_rows_show(first_row):
    rows = np.arange(41.0)
    cubic = 120.0 + 0.008 * (rows - 20.0) ** 3 - 0.1 * (rows - 20.0) ** 2
    broken = np.repeat(np.rint(cubic).astype(np.uint8)[:, None], 5, axis=1)
    broken[1 - first_row :: 2] = 7
    smoothed = np.convolve(cubic, [0.25, 0.5, 0.25], "valid")
    assert np.abs(field(broken, first_row)[4:-4] - smoothed[3:-3, None]).max() <= 1.5


def test_evidence_is_kept_over_frames(drawn):
    still = drawn[0]
    assert not noticed_fields(still, 0.0)[0].noticed
    fields, odds = noticed_fields(still, 20.0)
    assert fields.noticed
    assert odds < 20.0


def position_errors(solution):
    """Off the pose of either time, m."""
    return [np.linalg.norm(solution.T_world_target[:3, 3] - T[:3, 3]) for T in (NEAR, LATER)]


@pytest.mark.parametrize(("scan", "wanted"), [("top_field_first", 0), ("bottom_field_first", 1)])
def test_a_declared_scan_gives_the_pose_of_the_first_field(drawn, scan, wanted):
    rig = attrs.evolve(example_rig(), scan=scan, field_delay_ns=20_000_000)
    frame = frame_of([woven(a, b) for a, b in zip(*drawn, strict=True)], START_NS)
    solution = Navigator(rig, bracket_target()).process(frame)
    assert solution.published
    assert not solution.reasons
    assert position_errors(solution)[wanted] < 5e-4


def test_an_undeclared_one_gives_the_middle_and_says_so(drawn):
    frame = frame_of([woven(a, b) for a, b in zip(*drawn, strict=True)], START_NS)
    solution = Navigator(example_rig(), bracket_target()).process(frame)
    assert solution.published
    assert solution.reasons == {Reason.INTERLACED}
    half = 0.5 * np.linalg.norm(LATER[:3, 3] - NEAR[:3, 3])
    sigma = np.sqrt(np.trace(solution.covariance[:3, :3]))
    assert sigma > 0.8 * half
    assert all(abs(error - half) < 5e-4 for error in position_errors(solution))


def test_fields_too_far_apart_are_not_published(drawn):
    """Half way between them would be off by more than three of the largest standard deviations, 18 mm."""
    rig, target = example_rig(), bracket_target()
    far = draw_images(rig, target, pose(0.6, 0.053, 0.05, 4.0, -6.0, 5.0), seed=2)
    frame = frame_of([woven(a, b) for a, b in zip(drawn[0], far, strict=True)], START_NS)
    solution = Navigator(rig, target).process(frame)
    assert not solution.published
    assert solution.reasons == {Reason.INTERLACED, Reason.COVARIANCE}
