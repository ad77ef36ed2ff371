"""The sensor's numbers against the model that docs/simulation.md states."""

from __future__ import annotations

import numpy as np
import pytest
from rvdnav.camera import CameraModel
from rvdnav.simulation.render import LightImage
from rvdnav.simulation.scenario import Sensor
from rvdnav.simulation.sensor import expose, pixel_gains, point_images
from scipy.ndimage import gaussian_filter1d
from scipy.stats import norm

CAMERA = CameraModel(64, 48, 60.0, 60.0, 31.5, 23.5, [0.0, 0.0, 0.0, 0.0])
DARK = np.zeros((48, 64))


def flat(value: float) -> LightImage:
    return LightImage(np.full((48, 64), value), np.zeros((48, 64)))


def test_mean_and_variance_of_a_flat_field_are_those_stated():
    sensor = Sensor(vignetting=0.0, read_noise=1.5, shot_noise=0.03, prnu=0.0, level=120.0, black_level=8.0)
    rng = np.random.default_rng(5)
    for light in (0.0, 0.25, 1.0):
        images = np.array([expose(sensor, flat(light), DARK, np.ones((48, 64)), rng) for _ in range(40)], dtype=float)
        signal = 120.0 * light
        # rounding adds 1/12; of 123 thousand samples the variance is good to 0.4 % (one sigma)
        assert images.mean() == pytest.approx(8.0 + signal, abs=0.05)
        assert images.var() == pytest.approx(1.5**2 + 0.03 * signal + 1.0 / 12.0, rel=0.02)


def test_unequal_pixels_stay_what_they_are():
    sensor = Sensor(vignetting=0.0, prnu=0.02, read_noise=0.0, shot_noise=0.0, level=200.0, black_level=0.0)
    gains = pixel_gains(sensor, CAMERA, np.random.default_rng(1))
    assert gains.std() == pytest.approx(0.02, rel=0.05)
    first = expose(sensor, flat(1.0), DARK, gains, np.random.default_rng(2))
    second = expose(sensor, flat(1.0), DARK, gains, np.random.default_rng(3))
    np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(first, np.rint(200.0 * gains))


def test_vignetting_takes_the_stated_part_in_the_corner():
    gains = pixel_gains(Sensor(vignetting=0.3, prnu=0.0), CAMERA, np.random.default_rng(1))
    assert gains[23:25, 31:33].min() > 0.999
    corner = np.hypot(31.5, 23.5) / np.hypot(32.0, 24.0)
    assert gains[0, 0] == pytest.approx(1.0 - 0.3 * corner**2)


def test_the_blur_has_the_stated_width():
    step = LightImage(np.repeat((np.arange(64) > 31)[None, :], 48, axis=0).astype(float), np.zeros((48, 64)))
    sensor = Sensor(
        psf_sigma=1.2, vignetting=0.0, prnu=0.0, read_noise=0.0, shot_noise=0.0, level=240.0, black_level=0.0
    )
    image = expose(sensor, step, DARK, np.ones((48, 64)), np.random.default_rng(0))
    np.testing.assert_allclose(image, 240.0 * gaussian_filter1d(step.signal, 1.2, axis=1), atol=1.0)


def test_stars_have_their_place_their_sum_and_the_blur():
    uv = np.array([[20.3, 10.8], [40.0, 30.5], [np.nan, np.nan], [1e30, 5.0], [-3.0, 20.0]])
    image = point_images(Sensor(psf_sigma=0.7), uv, np.array([100.0, 300.0, 1.0, 1.0, 1.0]), (48, 64))
    assert image.sum() == pytest.approx(400.0, rel=1e-3)
    spot = image[4:18, 12:30]
    v, u = np.mgrid[4:18, 12:30]
    assert (spot * u).sum() / spot.sum() == pytest.approx(20.3, abs=1e-3)
    assert (spot * v).sum() / spot.sum() == pytest.approx(10.8, abs=1e-3)
    assert image[30, 40] == pytest.approx(
        300.0
        * (norm.cdf(0.5, 0, 0.7) - 0.5 + norm.cdf(0.5, 0, 0.7) - 0.5)
        * (norm.cdf(0.0, 0, 0.7) - norm.cdf(-1.0, 0, 0.7)),
        rel=1e-6,
    )


def test_what_is_covered_hides_the_stars_and_the_brightest_is_white():
    sensor = Sensor(vignetting=0.0)
    stars = np.full((48, 64), 90.0)
    covered = expose(sensor, flat(0.0), stars, np.ones((48, 64)), np.random.default_rng(1))
    open_sky = expose(sensor, LightImage(DARK, np.ones((48, 64))), stars, np.ones((48, 64)), np.random.default_rng(1))
    assert covered.max() < 15
    assert open_sky.mean() == pytest.approx(96.0, abs=0.5)
    assert expose(sensor, flat(5.0), stars, np.ones((48, 64)), np.random.default_rng(1)).min() == 255


def test_response_and_sharpening_come_after_the_noise():
    step = LightImage(np.repeat((np.arange(64) > 31)[None, :], 48, axis=0).astype(float), np.zeros((48, 64)))
    plain = {"psf_sigma": 0.0, "vignetting": 0.0, "prnu": 0.0, "read_noise": 0.0, "shot_noise": 0.0, "level": 100.0}
    image = expose(Sensor(**plain, gamma=0.45), step, DARK, np.ones((48, 64)), np.random.default_rng(0))
    np.testing.assert_array_equal(np.unique(image), np.rint(255.0 * (np.array([6.0, 106.0]) / 255.0) ** 0.45))
    image = expose(Sensor(**plain, sharpening=1.0), step, DARK, np.ones((48, 64)), np.random.default_rng(0))
    exact = 2.0 * (6.0 + 100.0 * step.signal) - gaussian_filter1d(6.0 + 100.0 * step.signal, 1.5, axis=1)
    np.testing.assert_allclose(image, np.clip(exact, 0.0, 255.0), atol=0.6)
