"""Faults with a strength do what their name says, as much as the strength says."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest
from conftest import START_NS, STEP_NS
from rvdnav import InputError, open_sequence
from rvdnav.faults import STRENGTHS, Fault, FaultySequence, parse_fault
from rvdnav.sequence import Sequence, Truth
from scipy.ndimage import gaussian_filter
from scipy.spatial.transform import Rotation
from scipy.special import erf
from solutions import transform

DARK, BRIGHT, STEP_COLUMN = 80.0, 120.0, 34.5
"""Of the left image of the first frame (conftest.grey): a step along a column."""
COLUMNS = np.arange(70)


@pytest.fixture
def recorded(make_sequence: Callable[..., Path]) -> Sequence:
    return open_sequence(make_sequence(4))


def moving(recorded: Sequence, velocity_W: tuple[float, float, float]) -> Sequence:
    """The sequence with a target that moves with a velocity, m/s, from half a metre ahead."""
    stamps = [START_NS + i * STEP_NS for i in range(4)]
    poses = [transform(np.array([0.5, 0.0, 0.06]) + np.array(velocity_W) * 1e-9 * (ns - START_NS)) for ns in stamps]
    recorded.truth = Truth(stamps, np.array(poses))
    return recorded


def struck(recorded: Sequence, fault: str, index: int = 0, seed: int = 0) -> np.ndarray:
    """The left image of a frame with a fault in all frames."""
    return FaultySequence(recorded, [parse_fault(f"{fault}:all")], seed)[index].left.pixels


def crossing(row: np.ndarray) -> float:
    """Where along a row the step's middle is."""
    column = int(np.flatnonzero(row >= 100.0)[0])
    below, above = float(row[column - 1]), float(row[column])
    return column - 1 + (100.0 - below) / (above - below)


@pytest.mark.parametrize("sigma", [1.0, 2.5, 4.0])
def test_blur_makes_a_step_an_error_function(recorded: Sequence, sigma: float) -> None:
    exact = DARK + (BRIGHT - DARK) * 0.5 * (1.0 + erf((COLUMNS - STEP_COLUMN) / (np.sqrt(2.0) * sigma)))
    assert np.abs(struck(recorded, f"blur={sigma}") - exact).max() < 1.0


@pytest.mark.parametrize("length", [5.0, 9.0])
@pytest.mark.parametrize("direction", [0.0, 180.0, 60.0, 90.0])
def test_motion_blur_makes_a_step_a_ramp(recorded: Sequence, length: float, direction: float) -> None:
    across = max(length * abs(np.cos(np.radians(direction))), 1e-9)
    # The step between two pixels counts as a ramp of one pixel.
    ideal = DARK + (BRIGHT - DARK) * np.clip((COLUMNS - STEP_COLUMN) / across + 0.5, 0.0, 1.0)
    assert np.abs(struck(recorded, f"motion_blur={length},{direction}") - ideal).max() < 4.0


@pytest.mark.parametrize(("velocity", "smeared"), [((0.0, 0.1, 0.0), False), ((0.0, 0.0, 0.1), True)])
def test_motion_blur_follows_the_target(
    recorded: Sequence, velocity: tuple[float, float, float], smeared: bool
) -> None:
    pixels = struck(moving(recorded, velocity), "motion_blur=9", index=1)
    sharp = recorded[1].left.pixels
    assert (np.abs(pixels.astype(int) - sharp).max() > 10) == smeared


@pytest.mark.parametrize("exponent", [0.45, 1.0, 2.2])
def test_gamma(recorded: Sequence, exponent: float) -> None:
    exact = 255.0 * (recorded[0].left.pixels / 255.0) ** exponent
    assert np.abs(struck(recorded, f"gamma={exponent}") - exact).max() <= 0.5


def test_an_unsharp_mask_overshoots(recorded: Sequence) -> None:
    before = recorded[0].left.pixels.astype(float)
    exact = before + 2.0 * (before - gaussian_filter(before, 1.5, mode="nearest"))
    assert np.abs(struck(recorded, "sharpened=2") - exact).max() <= 0.6
    assert exact.max() > BRIGHT + 20.0


def test_jpeg_loses_more_at_lower_quality(shared_data: Path) -> None:
    sequence = open_sequence(shared_data / "sequences" / "approach")
    before = sequence[0].left.pixels.astype(float)
    losses = [np.abs(struck(sequence, f"jpeg={quality}") - before).mean() for quality in (95, 40, 10)]
    assert 0.0 < losses[0] < losses[1] < losses[2] < 10.0


@pytest.mark.parametrize("sigma", [5.0, 12.0])
def test_noise_is_white_and_another_in_every_image(recorded: Sequence, sigma: float) -> None:
    faulty = FaultySequence(recorded, [parse_fault(f"noise={sigma}:all")])
    added = [
        image.pixels.astype(float) - original.pixels
        for frame, before in zip(faulty, recorded, strict=True)
        for image, original in ((frame.left, before.left), (frame.right, before.right))
    ]
    for noise in added:
        assert noise.std() == pytest.approx(sigma, rel=0.05)
        assert abs(noise.mean()) < 0.1 * sigma
    off_diagonal = np.corrcoef([noise.ravel() for noise in added]) - np.eye(len(added))
    assert np.abs(off_diagonal).max() < 0.06
    np.testing.assert_array_equal(struck(recorded, f"noise={sigma}"), struck(recorded, f"noise={sigma}"))
    assert (struck(recorded, f"noise={sigma}") != struck(recorded, f"noise={sigma}", seed=1)).any()


def test_row_noise_is_the_same_along_a_row(recorded: Sequence) -> None:
    added = struck(recorded, "row_noise=10").astype(int) - recorded[0].left.pixels
    assert (added == added[:, :1]).all()
    assert added[:, 0].std() == pytest.approx(10.0, rel=0.25)


def test_hot_pixels_stay_where_they_are(recorded: Sequence) -> None:
    darker = np.s_[:, :35]
    changed = [(struck(recorded, "hot_pixels=50", i) != recorded[i].left.pixels)[darker] for i in (0, 1)]
    assert changed[0].mean() == pytest.approx(0.05, rel=0.3)
    np.testing.assert_array_equal(*changed)
    assert struck(recorded, "hot_pixels=50")[darker][changed[0]].min() >= 128


def test_grey_steps(recorded: Sequence) -> None:
    noisy = [parse_fault("noise=20:all"), parse_fault("grey_steps=16:all")]
    pixels, before = (FaultySequence(recorded, noisy[: n + 1])[0].left.pixels.astype(int) for n in (1, 0))
    assert set(np.unique(pixels)) <= {*range(0, 256, 16), 255}
    assert np.abs(pixels - before).max() <= 8


def test_a_flare_is_strongest_in_its_corner(recorded: Sequence) -> None:
    added = struck(recorded, "flare=60").astype(int) - recorded[0].left.pixels
    assert added[0, -1] == 60
    assert added[-1, 0] == 6
    assert added.min() >= 6


def test_vignetting_darkens_the_corners(recorded: Sequence) -> None:
    before, after = recorded[0].left.pixels.astype(float), struck(recorded, "vignetting=0.5")
    assert np.abs(after[[0, 0, -1, -1], [0, -1, 0, -1]] / before[[0, 0, -1, -1], [0, -1, 0, -1]] - 0.5).max() < 0.01
    assert np.abs(after[28:30, 34:36] - before[28:30, 34:36]).max() <= 1.0


@pytest.mark.parametrize("shear", [8.0, -3.0])
def test_a_rolling_shutter_shears_about_the_middle_row(recorded: Sequence, shear: float) -> None:
    pixels = struck(recorded, f"rolling_shutter={shear}")
    rows = np.arange(len(pixels))
    found = [crossing(pixels[row]) for row in rows]
    wanted = STEP_COLUMN + shear * (rows / (len(rows) - 1) - 0.5)
    np.testing.assert_allclose(found, wanted, atol=0.2)


def test_a_doubled_field(recorded: Sequence) -> None:
    noisy = [parse_fault("noise=20:all"), parse_fault("field_doubled:all")]
    pixels, before = (FaultySequence(recorded, noisy[: n + 1])[0].left.pixels for n in (1, 0))
    np.testing.assert_array_equal(pixels[::2], before[::2])
    np.testing.assert_array_equal(pixels[1::2], before[::2])


@pytest.mark.parametrize(
    ("fault", "rows", "others"),
    [
        ("interlaced=125", 1, 2),
        ("interlaced=250", 1, 3),
        ("interlaced=-125", 1, 0),
        ("interlaced_bottom=125", 2, 1),
        ("interlaced=125.9", 1, 2),
    ],
)
def test_fields_recorded_at_other_times(recorded: Sequence, fault: str, rows: int, others: int) -> None:
    pixels = struck(recorded, fault, index=1)
    for parity, index in enumerate((rows, others)):
        np.testing.assert_array_equal(pixels[parity::2], recorded[index].left.pixels[parity::2])


def test_the_other_field_has_the_faults_that_come_before(recorded: Sequence) -> None:
    faults = [parse_fault("gamma=2:0-1"), parse_fault("interlaced=125:all"), parse_fault("gain_0.3:0")]
    pixels = FaultySequence(recorded, faults)[0].left.pixels
    expected = 0.3 * np.rint(255.0 * (recorded[1].left.pixels / 255.0) ** 2)
    assert np.abs(pixels[1::2] - expected[1::2]).max() <= 0.5 + 1e-9


@pytest.mark.parametrize("index", [5, 40])
def test_a_field_that_was_not_recorded_is_moved_with_the_target(shared_data: Path, index: int) -> None:
    """Without the next frame's images, the bracket is where the next frame shows it."""
    sequence = open_sequence(shared_data / "sequences" / "approach")
    next_frame = sequence[index + 1]
    pixels = struck(sequence, f"interlaced={125 - 1.1}", index)[1::2].astype(float)
    T = sequence.truth.at(next_frame.timestamp_ns)
    outer, inner = (
        [sequence.rig.project(0, T[:3, :3] @ sequence.target.points[f"{side}{i}"] + T[:3, 3]) for i in range(1, 5)]
        for side in "PQ"
    )
    mask = np.zeros(next_frame.left.pixels.shape, np.uint8)
    cv2.fillPoly(mask, [np.rint(corners).astype(np.int32) for corners in (outer, inner)], 1)
    mask = cv2.dilate(mask, np.ones((7, 7)))[1::2].astype(bool)
    wanted, still = next_frame.left.pixels[1::2].astype(float), sequence[index].left.pixels[1::2].astype(float)
    assert np.abs(pixels - wanted)[mask].mean() < 0.3 * np.abs(still - wanted)[mask].mean()


def test_motion_needs_two_true_poses(recorded: Sequence) -> None:
    for fault in ("motion_blur=5", "interlaced=20"):
        with pytest.raises(InputError, match="true motion"):
            struck(recorded, fault)
    struck(recorded, "motion_blur=5,0")


def draws(recorded: Sequence, fault: str, count: int = 300) -> list[FaultySequence]:
    return [FaultySequence(recorded, [parse_fault(f"{fault}:all")], seed) for seed in range(count)]


def test_a_calibration_off_at_random(recorded: Sequence) -> None:
    rig = recorded.rig
    T = np.linalg.inv(rig.T_world_cam[1]) @ rig.T_world_cam[0]
    focal, centre, turns = [], [], []
    for faulty in draws(recorded, "calibration=0.5,3,0.1"):
        told = faulty.rig
        assert list(faulty[0].left.pixels.ravel()) == list(recorded[0].left.pixels.ravel())
        for camera, true in zip(told.cameras, rig.cameras, strict=True):
            assert camera.fx / true.fx == pytest.approx(camera.fy / true.fy)
            focal.append(100.0 * (camera.fx / true.fx - 1.0))
            centre += [camera.cx - true.cx, camera.cy - true.cy]
        changed = np.linalg.inv(told.T_world_cam[1]) @ told.T_world_cam[0]
        np.testing.assert_allclose(changed[:3, 3], T[:3, 3], atol=1e-9)
        turns.append(Rotation.from_matrix(changed[:3, :3] @ T[:3, :3].T).as_rotvec(degrees=True))
    for values, sigma in ((focal, 0.5), (centre, 3.0), (turns, 0.1)):
        assert np.std(values) == pytest.approx(sigma, rel=0.08)
        assert abs(np.mean(values)) < 0.15 * sigma


def test_target_sizes_off_at_random(recorded: Sequence) -> None:
    true = recorded.target.bracket
    errors = []
    for faulty in draws(recorded, "target_sizes=0.3"):
        told = faulty.target.bracket
        np.testing.assert_allclose(np.ptp(told.bar_widths, axis=1), 0.0, atol=1e-6)  # still a trapezoid with even bars
        errors.append(
            [
                told.long_base - true.long_base,
                told.short_base - true.short_base,
                told.heights[0] - true.heights[0],
                *(told.bar_widths[:3, 0] - true.bar_widths[:3, 0]),
                told.thickness - true.thickness,
            ]
        )
    np.testing.assert_allclose(np.std(errors, axis=0), 3e-4, rtol=0.15)
    correlation = np.corrcoef(np.transpose(errors)) - np.eye(7)
    assert np.abs(correlation).max() < 0.25
    assert faulty.rig == recorded.rig


def test_target_points_off_at_random(recorded: Sequence) -> None:
    true = np.array(list(recorded.target.points.values()))
    errors = [np.array(list(faulty.target.points.values())) - true for faulty in draws(recorded, "target_points=0.3")]
    np.testing.assert_allclose(np.std(errors, axis=0)[:, 1:], 3e-4, rtol=0.15)
    assert (np.array(errors)[:, :, 0] == 0.0).all()  # the front face stays flat


def test_any_target_is_stretched(recorded: Sequence) -> None:
    recorded.target = attrs.evolve(recorded.target, bars=(), edges=[("P1", "P2")], faces=[("P1", "P2", "P3", "P4")])
    true = np.array(list(recorded.target.points.values()))
    extents = []
    for faulty in draws(recorded, "target_sizes=1"):
        told = np.array(list(faulty.target.points.values()))
        extents.append(np.ptp(told, axis=0) - np.ptp(true, axis=0))
    np.testing.assert_allclose(np.std(extents, axis=0), [0.0, 1e-3, 1e-3], rtol=0.15)


def test_sizes_that_nobody_knows_cannot_be_wrong(recorded: Sequence) -> None:
    recorded.target = attrs.evolve(recorded.target, dimensions_known=False)
    with pytest.raises(InputError, match="fault target_sizes: the target's dimensions are unknown"):
        FaultySequence(recorded, [parse_fault("target_sizes=1:all")])


@pytest.mark.parametrize("fault", ["target_points=100", "calibration=20,1000,20"])
def test_errors_that_leave_nothing(recorded: Sequence, fault: str) -> None:
    with pytest.raises(InputError, match=f"fault {fault}: ") as caught:
        draws(recorded, fault)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", STRENGTHS)
def test_every_strength_is_limited_and_every_fault_is_played(recorded: Sequence, name: str) -> None:
    moving(recorded, (0.0, 0.0, 0.1))
    middle = [min(max(1.0, s.low), s.high) for s in STRENGTHS[name]]
    frames = list(FaultySequence(recorded, [Fault(name, strength=tuple(middle))]))
    assert len(frames) == len(recorded)
    for index, strength in enumerate(STRENGTHS[name]):
        for beyond in (strength.low - 1.0, strength.high + 1.0, float("nan")):
            numbers = [*middle[:index], beyond, *middle[index + 1 :]]
            with pytest.raises(InputError, match=f"{strength.name} '.*' is no number from "):
                parse_fault(f"{name}={','.join(map(str, numbers))}:all")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("blur:all", r"its strength is sigma \(px\)"),
        ("blur=:all", "sigma '' is no number from 0.1 to 30 px"),
        ("blur=1,2:all", r"its strength is sigma \(px\)"),
        ("blur=1_0:all", "sigma '1_0' is no number"),
        ("blur=٣:all", "is no number"),
        ("motion_blur=5,0,1:all", r"its strength is length \(px\), direction \(degrees\) if wanted"),
        ("black=3:all", "it has no strength"),
        ("blur=2", "no frames; write blur=2:all or blur=2:10-14,20"),
        ("calibration=0.1,1,0.1:3", "wrong in all frames; write calibration=0.1,1,0.1:all"),
    ],
)
def test_what_is_no_strength(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        parse_fault(text)
    assert repr(text) in str(caught.value)


def test_a_fault_is_named_as_it_is_written() -> None:
    for text in ("blur=2.5", "calibration=0.05,0.3,0.01", "black_left"):
        assert parse_fault(f"{text}:all").label == text
