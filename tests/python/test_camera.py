from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rvdnav.camera import CameraModel

LENS = CameraModel(704, 576, 668.42, 669.15, 356.83, 283.41, [-0.2034, 0.0617, 0.00052, -0.00041])


def points(n: int = 200, spread: float = 0.55) -> np.ndarray:
    """Points in front of the camera, the farthest aside beyond the corners of the image."""
    rng = np.random.default_rng(7)
    z = rng.uniform(0.3, 2.0, n)
    return np.column_stack([rng.uniform(-spread, spread, (n, 2)) * z[:, None], z])


def test_project_equals_opencv() -> None:
    p_C = points()
    expected = cv2.projectPoints(p_C, np.zeros(3), np.zeros(3), LENS.K, LENS.distortion)[0].reshape(-1, 2)
    np.testing.assert_allclose(LENS.project(p_C), expected, atol=1e-9)


def test_unproject_equals_opencv() -> None:
    uv = LENS.project(points())
    criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-14)
    undistorted = cv2.undistortImagePoints(uv, LENS.K, LENS.distortion, None, criteria).reshape(-1, 2)
    rays = LENS.unproject(uv)
    np.testing.assert_allclose(rays[:, :2] @ LENS.K[:2, :2] + LENS.K[:2, 2], undistorted, atol=1e-6)
    np.testing.assert_array_equal(rays[:, 2], 1.0)


def test_shapes_are_kept() -> None:
    p_C = points(24).reshape(2, 3, 4, 3)
    uv = LENS.project(p_C)
    rays = LENS.unproject(uv)
    assert uv.shape == (2, 3, 4, 2)
    np.testing.assert_allclose(rays, p_C / p_C[..., 2:], atol=1e-11)
    np.testing.assert_array_equal(LENS.unproject(uv[1, 2, 3]), rays[1, 2, 3])  # whatever else is asked with it


@given(
    k1=st.floats(-0.3, 0.3),
    k2=st.floats(-0.05, 0.1),
    p=st.tuples(st.floats(-0.003, 0.003), st.floats(-0.003, 0.003)),
    u=st.floats(0, 703),
    v=st.floats(0, 575),
)
def test_round_trip_over_lenses(k1: float, k2: float, p: tuple[float, float], u: float, v: float) -> None:
    camera = CameraModel(704, 576, 700.0, 690.0, 350.0, 290.0, [k1, k2, *p])
    np.testing.assert_allclose(camera.project(camera.unproject(np.array([u, v]))), [u, v], atol=1e-8)


def test_points_not_in_front_are_nan() -> None:
    uv = LENS.project(np.array([[0.1, 0.1, 1.0], [0.1, 0.1, 0.0], [0.1, 0.1, -1.0]]))
    assert np.isfinite(uv[0]).all()
    assert np.isnan(uv[1:]).all()


def test_folded_points_are_nan_and_not_back_in_the_image() -> None:
    camera = CameraModel(704, 576, 668.0, 668.0, 351.5, 287.5, [-0.3, 0.0, 0.0, 0.0])
    fold = np.sqrt(1.0 / 0.9)  # of r - 0.3 r³
    p_C = np.array([[0.99 * fold, 0.0, 1.0], [1.7 * fold, 0.0, 1.0]])
    would_be = cv2.projectPoints(p_C, np.zeros(3), np.zeros(3), camera.K, camera.distortion)[0][1, 0]
    assert 0 < would_be[0] < 704  # the bare formula places it inside the image
    uv = camera.project(p_C)
    assert np.isfinite(uv[0]).all()
    assert np.isnan(uv[1]).all()
    assert np.isnan(camera.unproject(np.array([1e4, 288.0]))[:2]).all()


def test_pixel_zero_is_a_centre() -> None:
    plain = CameraModel(5, 3, 10.0, 10.0, 2.0, 1.0, np.zeros(4))
    np.testing.assert_array_equal(plain.project(np.array([0.0, 0.0, 1.0])), [2.0, 1.0])


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"fx": 0.0}, "fx"),
        ({"fy": -1.0}, "fy"),
        ({"fx": np.inf}, "fx is not finite"),
        ({"cx": np.nan}, "cx is not finite"),
        ({"width": 0}, "width"),
        ({"distortion": [0.0, np.nan, 0.0, 0.0]}, "not finite"),
        ({"distortion": [0.0] * 5}, "shape"),
        ({"distortion": [-1.5, 0.0, 0.0, 0.0]}, "folds back inside the image: 6[0-9] % of its pixels have no ray"),
        ({"distortion": [0.0, 0.0, 1e4, 0.0]}, "p1 = 10000"),
        ({"fx": 1e5}, r"fx = 100000 is not 70.4 to 70400 px"),
        ({"fy": 1e300}, r"fy = 1e\+300 is not"),
        ({"fx": 6680.0}, "fx = 6680 and fy = 668"),
        ({"cx": 5000.0}, "cx = 5000 lies more than 4096 px"),
        ({"cy": -1e300}, r"cy = -1e\+300"),
    ],
)
def test_bad_parameters_are_refused(change: dict[str, object], fault: str) -> None:
    values: dict[str, object] = {
        "width": 704,
        "height": 576,
        "fx": 668.0,
        "fy": 668.0,
        "cx": 351.5,
        "cy": 287.5,
        "distortion": np.zeros(4),
    }
    with pytest.raises(ValueError, match=fault):
        CameraModel(**(values | change))


def straight(distorted: float) -> CameraModel:
    """A lens whose distorted radius grows up to this, px: two thirds of the ideal one's, where k1 = -1 / (3 r²)."""
    k1 = -4.0 / 27.0 / (distorted / 600.0) ** 2
    return CameraModel(704, 576, 600.0, 600.0, 351.5, 287.5, [k1, 0.0, 0.0, 0.0])


def test_a_fold_outside_the_image_is_no_fault() -> None:
    corner = float(np.hypot(351.5, 287.5))
    camera = straight(corner + 0.1)
    assert camera.pixels_without_ray == 0
    assert np.isfinite(camera.unproject(np.zeros(2))).all()


def test_pixels_beyond_a_fold_have_no_ray() -> None:
    v, u = np.mgrid[:576, :704]
    beyond = int((np.hypot(u - 351.5, v - 287.5) > 440.0).sum())
    assert 100 < beyond < 2000
    assert straight(440.0).pixels_without_ray == pytest.approx(beyond, rel=0.2)


def test_parameters_cannot_change() -> None:
    with pytest.raises(ValueError, match="read-only"):
        LENS.distortion[0] = 0.0
    assert CameraModel(704, 576, 668.42, 669.15, 356.83, 283.41, LENS.distortion.tolist()) == LENS


@pytest.mark.parametrize("tangential", [(0.0, 0.0), (0.004, -0.002)])
def test_every_pixel_beyond_a_fold_is_counted(tangential: tuple[float, float]) -> None:
    camera = CameraModel(176, 144, 212.0, 210.0, 91.0, 69.0, [-0.6, 0.01, *tangential])
    uv = np.stack(np.meshgrid(np.arange(176.0), np.arange(144.0)), axis=-1)
    without = int(np.isnan(camera.unproject(uv)).any(axis=-1).sum())
    assert 100 < without == camera.pixels_without_ray
