from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import cv2
import numpy as np
import pytest
import yaml
from conftest import CAMCHAIN
from rvdnav.camera import CameraModel
from rvdnav.errors import InputError
from rvdnav.rig import Rig, calibration_parameters, load_rig, save_rig, world_from_camchain
from scipy.spatial.transform import Rotation

LEFT = CameraModel(704, 576, 668.42, 669.15, 356.83, 283.41, [-0.2034, 0.0617, 0.00052, -0.00041])
RIGHT = CameraModel(704, 576, 671.96, 672.31, 347.27, 291.94, [-0.1987, 0.0583, -0.00038, 0.00055])


def camchain_pose(rotation_deg: tuple[float, float, float], center: tuple[float, float, float]) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3] = Rotation.from_euler("xyz", rotation_deg, degrees=True).as_matrix()
    T[:3, 3] = center
    return T


T_CAM1_CAM0 = camchain_pose((0.3, -1.6, 0.4), (-0.12, 0.001, 0.002))
STEREO = Rig((LEFT, RIGHT), world_from_camchain(T_CAM1_CAM0))


def points_in_view(n: int = 60) -> np.ndarray:
    rng = np.random.default_rng(3)
    x = rng.uniform(0.4, 1.5, n)
    return np.column_stack([x, x * rng.uniform(-0.3, 0.3, n), 0.06 + x * rng.uniform(-0.3, 0.3, n)])


def test_world_follows_its_definition() -> None:
    T_world_cam0, T_world_cam1 = world_from_camchain(T_CAM1_CAM0)
    np.testing.assert_allclose(np.linalg.inv(T_world_cam1) @ T_world_cam0, T_CAM1_CAM0, atol=1e-14)
    np.testing.assert_array_equal(T_world_cam1[:3, 3], 0.0)
    np.testing.assert_allclose(T_world_cam0[:3, 3], [0.0, 0.0, math.dist((0, 0, 0), T_CAM1_CAM0[:3, 3])], atol=1e-15)
    for T in (T_world_cam0, T_world_cam1):
        np.testing.assert_allclose(T[:3, :3].T @ T[:3, :3], np.eye(3), atol=1e-14)
        assert np.linalg.det(T[:3, :3]) > 0
        assert T[1, 1] > 0.9  # y_W points down in both images
    axes = T_world_cam0[:3, 2] + T_world_cam1[:3, 2]
    assert axes[0] > 1.9
    assert abs(axes[1]) < 1e-14  # x_W is their sum but for its part along z_W


def test_world_of_the_shared_rig(shared_data: Path) -> None:
    for folder in (shared_data / "calibration" / "truth", shared_data / "sequences" / "approach"):
        given = yaml.safe_load((folder / "rig.yaml").read_text())
        chain = yaml.safe_load((folder / "camchain.yaml").read_text())
        derived = world_from_camchain(np.array(chain["cam1"]["T_cn_cnm1"]))
        for index in range(2):
            np.testing.assert_allclose(derived[index], given[f"T_world_cam{index}"], atol=1e-6)
        rig = load_rig(folder)
        assert rig.is_stereo
        assert rig.baseline == pytest.approx(0.12023, abs=1e-9)
        assert (rig.width, rig.height) == (704, 576)
        np.testing.assert_allclose(rig.T_world_cam[0], given["T_world_cam0"], atol=1e-12)


@pytest.mark.parametrize("center", [(0.0, 0.0, 0.0), (1e-5, 0.0, 0.0)])
def test_zero_baseline_is_refused(center: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="baseline is zero"):
        world_from_camchain(camchain_pose((0, 0, 0), center))


def test_cameras_behind_each_other_are_refused() -> None:
    with pytest.raises(ValueError, match="along the baseline"):
        world_from_camchain(camchain_pose((0, 0, 0), (0.0, 0.0, 0.12)))


def test_focal_length_and_projection_matrices() -> None:
    assert STEREO.focal_rect == pytest.approx((668.42 + 669.15 + 671.96 + 672.31) / 4)
    p_W = points_in_view()
    for index in range(2):
        homogeneous = np.column_stack([p_W, np.ones(len(p_W))]) @ STEREO.projection_matrix(index).T
        np.testing.assert_allclose(homogeneous[:, 2], p_W[:, 0], atol=1e-14)  # depth along x_W
        np.testing.assert_allclose(homogeneous[:, :2] / homogeneous[:, 2:], STEREO.project_rect(index, p_W), atol=1e-10)


def test_epipolar_lines_are_rows_and_disparity_gives_depth() -> None:
    p_W = points_in_view()
    left, right = (STEREO.project_rect(index, p_W) for index in range(2))
    np.testing.assert_allclose(left[:, 1], right[:, 1], atol=1e-11)
    disparity = STEREO.focal_rect * STEREO.baseline / p_W[:, 0]
    np.testing.assert_allclose(left[:, 0] - right[:, 0], disparity, atol=1e-10)


@pytest.mark.parametrize("index", [0, 1])
def test_projection_and_rectification_equal_opencv(index: int) -> None:
    p_W = points_in_view()
    camera, T_cam_world = STEREO.cameras[index], np.linalg.inv(STEREO.T_world_cam[index])
    rotation = cv2.Rodrigues(T_cam_world[:3, :3])[0]
    raw = cv2.projectPoints(p_W, rotation, T_cam_world[:3, 3], camera.K, camera.distortion)[0].reshape(-1, 2)
    np.testing.assert_allclose(STEREO.project(index, p_W), raw, atol=1e-8)
    xy = STEREO.raw_to_rect(index, raw)
    np.testing.assert_allclose(xy, STEREO.project_rect(index, p_W), atol=1e-8)
    np.testing.assert_allclose(STEREO.rect_to_raw(index, xy), raw, atol=1e-8)
    # The map that cv2.remap would use, at whole rectified pixels about the centre.
    f, size = STEREO.focal_rect, (9, 5)
    K_rect = np.array([[f, 0.0, 4.0], [0.0, f, 2.0], [0.0, 0.0, 1.0]])
    maps = cv2.initUndistortRectifyMap(
        camera.K, camera.distortion, STEREO.R_rect_cam(index), K_rect, size, cv2.CV_32FC1
    )
    grid = np.stack(np.meshgrid(np.arange(9) - 4.0, np.arange(5) - 2.0), axis=-1)
    np.testing.assert_allclose(STEREO.rect_to_raw(index, grid), np.stack(maps, axis=-1), atol=1e-4)


def test_shapes_are_kept() -> None:
    p_W = points_in_view(24).reshape(2, 3, 4, 3)
    assert STEREO.project(0, p_W).shape == (2, 3, 4, 2)
    np.testing.assert_allclose(STEREO.project_rect(1, p_W)[1, 2, 3], STEREO.project_rect(1, p_W[1, 2, 3]))


def test_points_behind_are_nan() -> None:
    assert np.isnan(STEREO.project_rect(0, np.array([-1.0, 0.0, 0.0]))).all()


def test_one_camera_has_its_own_axes() -> None:
    alone = Rig((LEFT,), (np.eye(4),))
    assert not alone.is_stereo
    assert alone.baseline == 0.0
    assert alone.focal_rect == pytest.approx((668.42 + 669.15) / 2)
    np.testing.assert_array_equal(alone.R_rect_cam(0), np.eye(3))
    np.testing.assert_allclose(
        alone.project_rect(0, np.array([0.1, 0.2, 1.0])), alone.focal_rect * np.array([0.1, 0.2])
    )
    placed = Rig((LEFT,), (STEREO.T_world_cam[0],))
    np.testing.assert_allclose(placed.R_rect_cam(0), np.eye(3), atol=1e-15)
    p_W = points_in_view()
    np.testing.assert_allclose(placed.raw_to_rect(0, placed.project(0, p_W)), placed.project_rect(0, p_W), atol=1e-8)


@pytest.mark.parametrize(
    ("cameras", "poses", "fault"),
    [
        ((LEFT, RIGHT), STEREO.T_world_cam[:1], "2 cameras but 1"),
        ((), (), "one or two"),
        ((LEFT, CameraModel(640, 480, 600, 600, 320, 240, np.zeros(4))), STEREO.T_world_cam, "resolutions differ"),
        ((LEFT, RIGHT), STEREO.T_world_cam[::-1], "baseline"),
        ((LEFT, RIGHT), [camchain_pose((0, 0, 0), (0.1, 0, 0)) @ T for T in STEREO.T_world_cam], "origin"),
        ((LEFT, RIGHT), [np.diag([1.0, 1.0, 1.001, 1.0])] * 2, "rotation is none"),
        ((LEFT, RIGHT), [np.diag([1.0, 1.0, -1.0, 1.0])] * 2, "mirrors"),
    ],
)
def test_rigs_that_are_none(cameras: tuple[CameraModel, ...], poses: tuple[np.ndarray, ...], fault: str) -> None:
    with pytest.raises(ValueError, match=fault):
        Rig(cameras, poses)


def test_round_trip_through_files(tmp_path: Path) -> None:
    for rig in (STEREO, Rig((LEFT,), (np.eye(4),)), Rig((RIGHT,), (STEREO.T_world_cam[0],))):
        save_rig(rig, tmp_path)
        loaded = load_rig(tmp_path)
        assert loaded.cameras == rig.cameras
        np.testing.assert_allclose(loaded.T_world_cam, rig.T_world_cam, atol=1e-15)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["camchain.yaml", "rig.yaml"]


@pytest.mark.parametrize(
    ("timing", "delays"),
    [
        ({"exposure_ns": 5_000_000}, [0, 0, 0, 0]),
        ({"line_delay_ns": 30_000}, [0, 30_000, 60_000, 90_000]),
        ({"scan": "top_field_first", "field_delay_ns": 20_000_000}, [0, 20_000_000, 0, 20_000_000]),
        ({"scan": "bottom_field_first", "field_delay_ns": 7_000, "line_delay_ns": 64}, [7_000, 0, 7_064, 64]),
    ],
)
def test_the_timing_of_rows(tmp_path: Path, timing: dict[str, Any], delays: list[int]) -> None:
    rig = attrs.evolve(STEREO, **timing)
    assert rig.row_delays_ns[:4].tolist() == delays
    assert len(rig.row_delays_ns) == rig.height
    save_rig(rig, tmp_path)
    loaded = load_rig(tmp_path)
    for key in ("exposure_ns", "line_delay_ns", "scan", "field_delay_ns"):
        assert getattr(loaded, key) == getattr(rig, key) == timing.get(key, getattr(STEREO, key))
    assert rig.perturbed(np.zeros(22)).row_delays_ns[:4].tolist() == delays


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        ("scan: interlaced", "scan 'interlaced' is none of progressive, top_field_first, bottom_field_first"),
        ("scan: [progressive]", "scan is not a text"),
        ("exposure_ns: 1.5", "exposure_ns is not a whole number from 0 to 1000000000"),
        ("line_delay_ns: -1", "line_delay_ns is not a whole number from 0"),
        ("exposure_ns: 1e30", "exposure_ns is not a whole number from 0"),
        ("field_delay_ns: 5", "field_delay_ns belongs to an interlaced scan"),
    ],
)
def test_timings_that_are_none(tmp_path: Path, line: str, fault: str) -> None:
    save_rig(STEREO, tmp_path)
    with (tmp_path / "rig.yaml").open("a") as file:
        file.write(f"{line}\n")
    with pytest.raises(InputError, match=fault) as caught:
        load_rig(tmp_path)
    assert "rig.yaml" in str(caught.value)


def test_rig_yaml_is_optional(tmp_path: Path) -> None:
    save_rig(STEREO, tmp_path)
    (tmp_path / "rig.yaml").unlink()
    np.testing.assert_allclose(load_rig(tmp_path).T_world_cam, STEREO.T_world_cam, atol=1e-14)


def test_one_camera_chain(tmp_path: Path) -> None:
    (tmp_path / "camchain.yaml").write_text(CAMCHAIN[: CAMCHAIN.index("cam1:")])
    rig = load_rig(tmp_path)
    assert len(rig.cameras) == 1
    np.testing.assert_array_equal(rig.T_world_cam[0], np.eye(4))


FAULTS = [
    ("intrinsics: [66.8", "intrinsics: [.nan", "cam0.intrinsics is not finite"),
    ("intrinsics: [66.8", "intrinsics: [-66.8", "cam0: fx is not positive"),
    ("intrinsics: [66.8,", "intrinsics: [", "cam0.intrinsics is not a list of 4 numbers"),
    ("intrinsics: [66.8", "intrinsics: [wide", "cam0.intrinsics is not a list of 4 numbers"),
    ("distortion_model: radtan", "distortion_model: equidistant", "'equidistant' is not supported"),
    ("distortion_model: radtan", "distortion_model: fov", "'fov' is not supported"),
    ("camera_model: pinhole", "camera_model: omni", "'omni' is not supported"),
    ("-0.0004]", "-0.0004, 0.01]", "cam0.distortion_coeffs is not a list of 4 numbers"),
    ("intrinsics: [66.8", "intrinsics: [1.0e+5", "cam0: fx = 100000 is not 7 to 7000 px"),
    ("intrinsics: [66.8", "intrinsics: [1.0e+300", "cam0.intrinsics is beyond 1e+30"),
    ("resolution: [70, 58]", "resolution: [7000, 5800]", "cam0.resolution is 7000 x 5800: a side has 16 to 4096 px"),
    ("[-0.2, 0.06", "[-3.0, 0.06", "cam0: the distortion folds back inside the image"),
    ("resolution: [70, 58]", "resolution: [70, 59]", "resolutions differ"),
    ("resolution: [70, 58]", "resolution: [70.5, 58]", "cam0.resolution is not two whole numbers"),
    ("  resolution: [70, 58]\n", "", "cam0.resolution is missing"),
    ("[1.0, 0.0, 0.0, -0.12]", "[1.1, 0.0, 0.0, -0.12]", "cam1.T_cn_cnm1 is not a rigid transform"),
    ("[1.0, 0.0, 0.0, -0.12]", "[-1.0, 0.0, 0.0, -0.12]", "mirrors"),
    ("[1.0, 0.0, 0.0, -0.12]", "[1.0, 0.0, 0.0, -.inf]", "cam1.T_cn_cnm1 is not finite"),
    ("[1.0, 0.0, 0.0, -0.12]", "[1.0, 0.0, 0.0, 0.0]", "baseline is zero"),
    ("[1.0, 0.0, 0.0, -0.12]", "[1.0, 0.0, 0.0, 0.12]", "cam0 is not the left camera"),
    ("  - [0.0, 0.0, 0.0, 1.0]\n", "", "cam1.T_cn_cnm1 is not a list of 4 x 4 numbers"),
    ("cam1:", "cam0:", "line 7: key 'cam0' is given twice"),
    ("cam1:", "cam2: {}\ncam1:", "more than two cameras"),
    ("cam0:", "left:", "cam0 is missing"),
    ("cam0:", "cam0: [", "line"),
    (CAMCHAIN, "- 1\n", "not a mapping"),
    (CAMCHAIN, "", "not a mapping"),
]


@pytest.mark.parametrize(("old", "new", "fault"), FAULTS)
def test_malformed_camchain_is_one_clear_line(tmp_path: Path, old: str, new: str, fault: str) -> None:
    path = tmp_path / "camchain.yaml"
    path.write_text(CAMCHAIN.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load_rig(tmp_path)
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert fault in message
    assert "\n" not in message


def test_missing_or_binary_camchain(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"camchain\.yaml: no such file"):
        load_rig(tmp_path)
    (tmp_path / "camchain.yaml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="not a text file"):
        load_rig(tmp_path)


@pytest.mark.parametrize(
    ("turn", "where", "fault"),
    [
        ((0.0, 0.001, 0.0), 0, r"rig\.yaml: disagrees with camchain\.yaml"),
        ((0.0, 0.0, 1.0), None, r"rig\.yaml: the world is not the one"),
    ],
)
def test_rig_and_camchain_that_disagree(
    tmp_path: Path, turn: tuple[float, float, float], where: int | None, fault: str
) -> None:
    save_rig(STEREO, tmp_path)
    path = tmp_path / "rig.yaml"
    values = yaml.safe_load(path.read_text())
    for index in range(2):
        if where in (None, index):
            values[f"T_world_cam{index}"] = (
                camchain_pose(turn, (0.0, 0.0, 0.0)) @ values[f"T_world_cam{index}"]
            ).tolist()
    path.write_text(yaml.safe_dump(values))
    with pytest.raises(InputError, match=fault):
        load_rig(tmp_path)


def test_agreement_within_rounding(tmp_path: Path) -> None:
    save_rig(STEREO, tmp_path)
    path = tmp_path / "rig.yaml"
    values = yaml.safe_load(path.read_text())
    path.write_text(yaml.safe_dump({key: np.round(T, 7).tolist() for key, T in values.items()}))
    np.testing.assert_allclose(load_rig(tmp_path).T_world_cam, STEREO.T_world_cam, atol=2e-7)


def covariance(size: int) -> np.ndarray:
    """Of scales as different as those of a calibration, strongly correlated."""
    root = np.random.default_rng(4).standard_normal((size, size + 3)) * np.geomspace(1.0, 1e-7, size)[:, None]
    root += 3.0 * root[:, :1]
    return root @ root.T


ALONE = Rig((LEFT,), (STEREO.T_world_cam[0],))


@pytest.mark.parametrize(("rig", "size"), [(STEREO, 22), (ALONE, 8)], ids=["stereo", "one camera"])
def test_the_calibration_covariance_goes_through_the_file(rig: Rig, size: int, tmp_path: Path) -> None:
    assert rig.calibration_covariance is None
    stated = covariance(size)
    stated[3] = stated[:, 3] = 0.0  # held fixed
    save_rig(attrs.evolve(rig, calibration_covariance=stated), tmp_path)
    values = yaml.safe_load((tmp_path / "rig.yaml").read_text())["calibration_covariance"]
    assert values["parameters"] == list(calibration_parameters(len(rig.cameras)))
    np.testing.assert_allclose(np.array(values["matrix"], dtype=np.float64), stated, rtol=1e-12)  # no number is a text
    np.testing.assert_allclose(load_rig(tmp_path).calibration_covariance, stated, rtol=1e-12)


def test_the_order_of_the_parameters() -> None:
    own = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2")
    left, right = ([f"cam{i}.{name}" for name in own] for i in range(2))
    pair = [f"cam1_cam0.{name}" for name in ("rx", "ry", "rz", "tx", "ty", "tz")]
    assert list(calibration_parameters(1)) == left
    assert list(calibration_parameters(2)) == [*left, *right, *pair]


def test_a_perturbed_rig_has_the_changed_parameters_and_their_world() -> None:
    delta = np.random.default_rng(6).standard_normal(22)
    delta *= np.array([1.0, 1.0, 1.0, 1.0, 0.01, 0.01, 1e-3, 1e-3] * 2 + [0.01] * 3 + [0.003] * 3)
    rig = attrs.evolve(STEREO, calibration_covariance=covariance(22)).perturbed(delta)
    for index, (camera, before) in enumerate(zip(rig.cameras, STEREO.cameras, strict=True)):
        changed = [camera.fx, camera.fy, camera.cx, camera.cy, *camera.distortion]
        given = np.array([before.fx, before.fy, before.cx, before.cy, *before.distortion])
        np.testing.assert_allclose(changed, given + delta[8 * index : 8 * index + 8], atol=1e-12)
    T = np.eye(4)
    T[:3, :3] = Rotation.from_rotvec(delta[16:19]).as_matrix() @ T_CAM1_CAM0[:3, :3]
    T[:3, 3] = T_CAM1_CAM0[:3, 3] + delta[19:]
    np.testing.assert_allclose(rig.T_world_cam, world_from_camchain(T), atol=1e-12)
    assert rig.calibration_covariance is not None
    alone = ALONE.perturbed(delta[:8])
    assert alone.cameras == rig.cameras[:1]
    np.testing.assert_allclose(alone.T_world_cam, ALONE.T_world_cam, atol=1e-15)


def asymmetric(values: dict[str, list[object]]) -> None:
    values["matrix"][2][5] += 1e-3


COVARIANCE_FAULTS = [
    (lambda c: c["parameters"].reverse(), r"parameters\[0\] is 'cam1_cam0.tz', not 'cam0.fx'"),
    (lambda c: c["parameters"].pop(), "parameters has 21 names, not 22"),
    (lambda c: c.pop("parameters"), "parameters is missing"),
    (lambda c: c["matrix"].pop(), "matrix is not a list of 22 x 22 numbers"),
    (lambda c: c["matrix"][0].__setitem__(0, float("nan")), "matrix is not finite"),
    (lambda c: c["matrix"][1].__setitem__(1, -1.0), "matrix is not a covariance: a variance is negative"),
    (asymmetric, "matrix is not a covariance: it is not symmetric"),
    (lambda c: c["matrix"][0].__setitem__(0, 0.0), "matrix is not a covariance: it is not"),
    (lambda c: c["matrix"][0].__setitem__(0, 0.1), "matrix is not a covariance: it is not positive semi-definite"),
]


@pytest.mark.parametrize(("change", "fault"), COVARIANCE_FAULTS, ids=[fault for _, fault in COVARIANCE_FAULTS])
def test_malformed_covariance_is_one_clear_line(tmp_path: Path, change: Callable[..., object], fault: str) -> None:
    save_rig(attrs.evolve(STEREO, calibration_covariance=covariance(22)), tmp_path)
    path = tmp_path / "rig.yaml"
    values = yaml.safe_load(path.read_text())
    change(values["calibration_covariance"])
    path.write_text(yaml.safe_dump(values))
    with pytest.raises(InputError, match=rf"^{path}: calibration_covariance\.{fault}"):
        load_rig(tmp_path)


def test_pixels_beyond_a_fold_are_told(tmp_path: Path) -> None:
    """A public calibration of a 1280 x 720 camera, rounded: one pixel of a corner has no ray."""
    (tmp_path / "camchain.yaml").write_text(
        "cam0:\n  camera_model: pinhole\n  distortion_model: radtan\n  resolution: [1280, 720]\n"
        "  intrinsics: [863.728, 863.222, 637.524, 385.529]\n"
        "  distortion_coeffs: [0.0885275, -0.225994, -0.000152622, 0.000566247]\n"
    )
    notices: list[str] = []
    rig = load_rig(tmp_path, notices)
    assert rig.cameras[0].pixels_without_ray == 1
    assert notices == [
        "camchain.yaml: cam0: the distortion folds back in the image: about 1 of its pixels have no ray, "
        "and nothing is measured there"
    ]
