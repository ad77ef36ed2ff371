"""What the core tells of single images, beside plain reference computations."""

import cv2
import numpy as np
import pytest
from drawn_scene import bracket_target, draw_images, example_rig, pose
from rvdnav.core import FieldSigns, digest, field_signs, noise_median


def reference_signs(image):
    """By OpenCV's filters, in floating point; exact for what comes out of 8-bit images."""
    grey = image[: len(image) // 2 * 2].astype(np.float64)
    even, odd = grey[::2], grey[1::2]
    cubic = np.array([-1.0, 9.0, 9.0, -1.0])[:, None] / 16.0
    between = cv2.filter2D(even, -1, cubic, anchor=(0, 1), borderType=cv2.BORDER_REPLICATE)
    slope = cv2.filter2D(between, -1, np.array([[-0.5, 0.0, 0.5]]), borderType=cv2.BORDER_REFLECT_101)
    slope[np.abs(slope) < 8.0] = 0.0
    tiles = combed = 0
    for y in range(0, len(even) - 15, 16):
        for x in range(0, image.shape[1] - 31, 32):
            part = slice(y, y + 16), slice(x, x + 32)
            rows = (slope[part] * (between - odd)[part]).sum(axis=1)
            if np.count_nonzero(slope[part]) >= 16:
                tiles += 1
                agreed = rows.sum() ** 2 > 9.0 * np.sum(rows**2)
                combed += bool(agreed and abs(rows.sum()) > 0.08 * np.sum(slope[part] ** 2))
    change = np.abs(np.diff(grey, axis=0))
    seen = change[1::2] >= 8.0
    within, across = ((part * seen).sum(axis=1) for part in (change[:-1:2], change[1::2]))
    return FieldSigns(
        tiles,
        combed,
        len(across),
        np.count_nonzero(across),
        np.count_nonzero(4.0 * within[across > 0] < across[across > 0]),
    )


def pictures():
    """A scene at two times, as one image and woven of both, one with doubled rows, and noise of several sizes."""
    rig, target = example_rig(), bracket_target()
    first, later = (draw_images(rig, target, pose(0.6, y, 0.05, 4.0, -6.0, 5.0))[0] for y in (0.010, 0.013))
    woven = first.copy()
    woven[1::2] = later[1::2]
    rng = np.random.default_rng(5)
    noise = [rng.integers(0, 256, size, dtype=np.uint8) for size in ((64, 96), (37, 71), (33, 32), (16, 16), (2, 40))]
    soft = [cv2.GaussianBlur(image, (0, 0), 1.5) for image in noise[:3]]
    stripes = np.where(np.arange(64) // 4 % 2 == 0, 255, 0).astype(np.uint8) * np.ones((70, 1), np.uint8)
    return [first, woven, np.repeat(first[::2], 2, axis=0), *noise, *soft, stripes]


@pytest.mark.parametrize("image", pictures())
def test_field_signs_are_those_of_the_reference(image):
    assert field_signs(image) == reference_signs(image)


def test_woven_images_have_combed_tiles_and_doubled_ones_equal_rows():
    first, woven, doubled = map(field_signs, pictures()[:3])
    assert first.combed <= 0.03 * first.tiles
    assert woven.combed >= 0.3 * woven.tiles
    assert doubled.equal_pairs == doubled.changed_pairs > first.equal_pairs


@pytest.mark.parametrize("image", pictures())
def test_noise_is_the_median_of_the_mask(image):
    mask = cv2.filter2D(image.astype(np.float64), -1, np.outer([1.0, -2.0, 1.0], [1.0, -2.0, 1.0]))[1:-1:3, 1:-1]
    assert noise_median(image) == (np.median(np.abs(mask)) if mask.size else 0.0)


def test_a_digest_tells_images_apart_by_every_bit_and_by_their_size():
    rng = np.random.default_rng(7)
    image = rng.integers(0, 256, (24, 45), dtype=np.uint8)
    changed = [image, image.T, image.reshape(45, 24), image[:-1], image[:, :-1], np.zeros((8, 9), np.uint8)]
    for flat in range(image.size):
        other = image.copy()
        other.flat[flat] ^= 1 << (flat % 8)
        changed.append(other)
    # Two bits as well: in each lane of the sum the highest ones of two neighbouring words.
    for column in range(7, 40, 8):
        other = image.copy()
        other[5:7, column] ^= 0x80
        changed.append(other)
    assert len(set(map(digest, changed))) == len(changed)
    assert len(digest(image)) == 8


def test_rows_with_a_stride_and_other_layouts_make_no_difference():
    image = pictures()[0]
    wide = np.full((len(image), image.shape[1] + 9), 77, np.uint8)
    wide[:, : image.shape[1]] = image
    for function in (digest, field_signs, noise_median):
        assert function(wide[:, : image.shape[1]]) == function(image) == function(np.asfortranarray(image))
