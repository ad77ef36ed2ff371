"""Every fault does to a recorded sequence exactly what its name says."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import attrs
import numpy as np
import pytest
from conftest import START_NS, STEP_NS
from rvdnav import Frame, InputError, Navigator, Rig, open_sequence
from rvdnav.evaluation import evaluate
from rvdnav.faults import FAULT_NAMES, STRENGTHS, Fault, FaultySequence, Response, parse_fault
from rvdnav.faults.pixels import noise_sigma
from rvdnav.faults.region import target_region
from rvdnav.sequence import Sequence as Recorded
from rvdnav.sequence import write_tum
from rvdnav.solution import Mode, Reason
from scipy.spatial.transform import Rotation
from solutions import a_run, transform, true_poses

FRAMES = 6


@pytest.fixture
def recorded(make_sequence: Callable[..., Path]) -> Recorded:
    return open_sequence(make_sequence(FRAMES))


def play(recorded: Recorded, *faults: str) -> list[Frame]:
    return list(FaultySequence(recorded, [parse_fault(fault) for fault in faults]))


def numbers(frames: Sequence[Frame]) -> list[int]:
    """Numbers of the recorded frames by their stamps."""
    return [(frame.timestamp_ns - START_NS) // STEP_NS for frame in frames]


def shown(frames: Sequence[Frame]) -> list[tuple[int, int, int, int]]:
    """(camera, number) that the left and the right pixels were recorded under; see conftest.grey."""
    return [
        (*divmod(int(frame.left.pixels.max()) - 120, 50), *divmod(int(frame.right.pixels.max()) - 120, 50))
        for frame in frames
    ]


def as_pairs(frames: Sequence[Frame]) -> list[tuple[int, int]]:
    """Recorded frame number of the left and the right image, where each is from its own camera."""
    values = shown(frames)
    assert all((left, right) == (0, 1) for left, _, right, _ in values)
    return [(left // 10, right // 10) for _, left, _, right in values]


def test_without_faults_nothing_changes(recorded: Recorded) -> None:
    assert play(recorded) == list(recorded)


def test_dropped(recorded: Recorded) -> None:
    assert play(recorded, "dropped:1-2,5") == [recorded[i] for i in (0, 3, 4)]


@pytest.mark.parametrize(
    ("fault", "expected"),
    [
        ("duplicated:2", [(0, 0), (1, 1), (1, 1), (3, 3), (4, 4)]),
        ("duplicated:2-3", [(0, 0), (1, 1), (1, 1), (1, 1), (4, 4)]),
        ("duplicated:0", [(0, 0), (1, 1), (2, 2), (3, 3), (4, 4)]),
        ("left_behind:2-3", [(0, 0), (1, 1), (1, 2), (2, 3), (4, 4)]),
        ("right_behind:all", [(0, 0), (1, 0), (2, 1), (3, 2), (4, 3)]),
    ],
)
def test_old_pixels_under_new_stamps(make_sequence, fault: str, expected: list[tuple[int, int]]) -> None:
    frames = play(open_sequence(make_sequence(5)), fault)
    assert numbers(frames) == list(range(5))
    assert all(image.timestamp_ns == frame.timestamp_ns for frame in frames for image in (frame.left, frame.right))
    assert as_pairs(frames) == expected


@pytest.mark.parametrize(
    ("fault", "order"),
    [
        ("late:2", [0, 1, 3, 2, 4, 5]),
        ("late:1-2,4", [0, 3, 1, 2, 5, 4]),
        ("late:5", [0, 1, 2, 3, 4, 5]),
    ],
)
def test_late(recorded: Recorded, fault: str, order: list[int]) -> None:
    assert play(recorded, fault) == [recorded[i] for i in order]


def test_swapped(recorded: Recorded) -> None:
    frames = play(recorded, "swapped:1")
    np.testing.assert_array_equal(frames[1].left.pixels, recorded[1].right.pixels)
    np.testing.assert_array_equal(frames[1].right.pixels, recorded[1].left.pixels)
    assert frames[1].timestamp_ns == recorded[1].timestamp_ns
    assert [frames[i] for i in (0, 2)] == [recorded[i] for i in (0, 2)]


def test_a_camera_without_an_image_stays_without(make_sequence) -> None:
    folder = make_sequence(3)
    (folder / "cam1" / "data" / f"{START_NS + STEP_NS}.png").write_bytes(b"")
    sequence = open_sequence(folder)
    assert play(sequence, "noise_x4:all")[1].right is None
    assert play(sequence, "right_behind:2")[2].right is None
    swapped = play(sequence, "swapped:1")[1]
    assert swapped.left is None
    assert swapped.right.timestamp_ns == swapped.timestamp_ns


@pytest.mark.parametrize(("name", "grey"), [("black", 0), ("saturated", 255)])
@pytest.mark.parametrize(("side", "struck"), [("_left", (True, False)), ("_right", (False, True)), ("", (True, True))])
def test_black_and_saturated(recorded: Recorded, name: str, grey: int, side: str, struck: tuple[bool, bool]) -> None:
    frames = play(recorded, f"{name}{side}:2")
    for image, before, hit in zip(
        (frames[2].left, frames[2].right), (recorded[2].left, recorded[2].right), struck, strict=True
    ):
        assert (image.pixels == grey).all() if hit else image == before
    assert [*frames[:2], *frames[3:]] == [recorded[i] for i in (0, 1, 3, 4, 5)]


@pytest.mark.parametrize(("fault", "gain"), [("gain_0.3:0", 0.3), ("gain_2:0", 2.0)])
def test_gain(recorded: Recorded, fault: str, gain: float) -> None:
    frame = play(recorded, fault)[0]
    for image, before in ((frame.left, recorded[0].left), (frame.right, recorded[0].right)):
        exact = np.minimum(gain * before.pixels.astype(float), 255.0)
        assert np.abs(image.pixels - exact).max() <= 0.5


@pytest.fixture
def noisy(shared_data: Path) -> Recorded:
    return open_sequence(shared_data / "sequences" / "approach")


@pytest.mark.parametrize("sigma", [1.0, 3.0])
def test_the_noise_of_an_image_is_found_beside_its_edges(sigma: float) -> None:
    rng = np.random.default_rng(4)
    image = np.full((200, 300), 60.0)
    image[:, 150:] = 180.0
    pixels = np.rint(image + sigma * rng.standard_normal(image.shape)).astype(np.uint8)
    assert noise_sigma(pixels) == pytest.approx(np.hypot(sigma, 12**-0.5), rel=0.05)


def test_four_times_the_noise(noisy: Recorded) -> None:
    faulty, before = play_one(noisy, "noise_x4", 0)
    for camera in (0, 1):
        assert noise_sigma(faulty[camera]) == pytest.approx(4.0 * noise_sigma(before[camera]), rel=0.1)
        assert faulty[camera].mean() == pytest.approx(before[camera].mean(), abs=4.0)  # darkness cuts noise off
    again, _ = play_one(noisy, "noise_x4", 0)
    other_seed = FaultySequence(noisy, [Fault("noise_x4")], seed=1)[0]
    np.testing.assert_array_equal(again, faulty)
    assert (other_seed.left.pixels != faulty[0]).any()
    added = [faulty[camera].astype(int) - before[camera] for camera in (0, 1)]
    assert abs(np.corrcoef(added[0].ravel(), added[1].ravel())[0, 1]) < 0.02


def play_one(recorded: Recorded, name: str, index: int) -> tuple[np.ndarray, np.ndarray]:
    """Both images (2, height, width) of a frame with a fault, and without it."""
    frames = FaultySequence(recorded, [Fault(name)])[index], recorded[index]
    faulty, before = (np.stack([frame.left.pixels, frame.right.pixels]) for frame in frames)
    return faulty, before


@pytest.mark.parametrize("index", [0, 40])
@pytest.mark.parametrize(("name", "thirds"), [("occluder_middle", (1, 2)), ("occluder_side", (0, 1))])
def test_an_arm_hides_a_third_of_the_target(noisy: Recorded, name: str, thirds: tuple[int, int], index: int) -> None:
    faulty, before = play_one(noisy, name, index)
    T = noisy.truth.at(noisy[index].timestamp_ns)
    for camera in (0, 1):
        corners = [noisy.rig.project(camera, T[:3, :3] @ p + T[:3, 3]) for p in noisy.target.points.values()]
        x = np.array(corners)[:, 0]
        x0, x1 = (x.min() + third * np.ptp(x) / 3.0 for third in thirds)
        columns = np.flatnonzero((faulty[camera] != before[camera]).any(axis=0))
        assert (columns.min(), columns.max()) == (np.ceil(x0), np.ceil(x1) - 1)
        arm = faulty[camera][:, columns.min() : columns.max() + 1]
        assert (arm == arm[0]).all()  # nothing shines through
        np.testing.assert_array_equal(faulty[camera][:, : columns.min()], before[camera][:, : columns.min()])


def test_glare_saturates_the_corner_and_fades(noisy: Recorded) -> None:
    faulty, before = play_one(noisy, "glare", 20)
    stamp = noisy[20].timestamp_ns
    for camera in (0, 1):
        region = target_region(noisy.rig, noisy.target, noisy.truth, stamp, camera)
        y, x = np.indices(before[camera].shape)
        distance = np.hypot(x - region.x1, y - region.y0)
        size = max(region.width, region.height)
        assert (faulty[camera][distance < 0.25 * size] == 255).all()
        assert (faulty[camera] >= before[camera]).all()
        np.testing.assert_array_equal(faulty[camera][distance > size], before[camera][distance > size])


@pytest.mark.parametrize(("name", "struck"), [("corrupted_rows_left", {0}), ("corrupted_rows", {0, 1})])
def test_corrupted_rows(noisy: Recorded, name: str, struck: set[int]) -> None:
    faulty, before = play_one(noisy, name, 20)
    stamp = noisy[20].timestamp_ns
    for camera in (0, 1):
        rows = np.flatnonzero((faulty[camera] != before[camera]).any(axis=1))
        if camera not in struck:
            assert not len(rows)
            continue
        region = target_region(noisy.rig, noisy.target, noisy.truth, stamp, camera)
        np.testing.assert_array_equal(rows, np.arange(rows[0], rows[-1] + 1))
        assert len(rows) == pytest.approx(0.2 * region.height, abs=1.0)
        assert rows.mean() == pytest.approx(0.5 * (region.y0 + region.y1), abs=1.0)
        assert faulty[camera][rows].std() == pytest.approx(73.6, rel=0.05)  # of uniform bytes


def test_without_truth_the_target_is_taken_for_in_the_middle(recorded: Recorded) -> None:
    region = target_region(recorded.rig, recorded.target, None, START_NS, 0)
    assert (region.x0, region.y0, region.x1, region.y1) == pytest.approx((70 / 3, 58 / 3, 140 / 3, 116 / 3))
    changed = np.flatnonzero(
        (play_one(recorded, "occluder_side", 0)[0] != play_one(recorded, "gain_2", 0)[1])[0].any(0)
    )
    assert (changed.min(), changed.max()) == (24, 31)


@pytest.mark.parametrize(("axis", "name"), [(0, "x"), (1, "y"), (2, "z")])
@pytest.mark.parametrize(("side", "cameras"), [("left", {0}), ("right", {1}), ("both", {0, 1})])
def test_a_turned_camera(recorded: Recorded, axis: int, name: str, side: str, cameras: set[int]) -> None:
    faulty = FaultySequence(recorded, [parse_fault(f"miscalibrated_{side}_{name}:all")])
    assert list(faulty) == list(recorded)
    assert faulty.rig.cameras == recorded.rig.cameras
    for camera in (0, 1):
        before, after = recorded.rig.T_world_cam[camera], faulty.rig.T_world_cam[camera]
        np.testing.assert_array_equal(after[:3, 3], before[:3, 3])
        turn = Rotation.from_matrix(before[:3, :3].T @ after[:3, :3]).as_rotvec(degrees=True)
        np.testing.assert_allclose(turn, 0.3 * np.eye(3)[axis] * (camera in cameras), atol=1e-9)


@pytest.mark.parametrize(("side", "cameras"), [("left", {0}), ("right", {1}), ("both", {0, 1})])
def test_a_wrong_focal_length(recorded: Recorded, side: str, cameras: set[int]) -> None:
    faulty = FaultySequence(recorded, [parse_fault(f"miscalibrated_{side}_focal:all")])
    for camera in (0, 1):
        before, after = recorded.rig.cameras[camera], faulty.rig.cameras[camera]
        factor = 1.02 if camera in cameras else 1.0
        np.testing.assert_allclose([after.fx, after.fy], [factor * before.fx, factor * before.fy])
        assert (after.cx, after.cy) == (before.cx, before.cy)
    np.testing.assert_array_equal(faulty.rig.T_world_cam, recorded.rig.T_world_cam)


def test_faults_add_up_and_keep_truth_and_notices(make_sequence) -> None:
    folder = make_sequence(4)
    write_tum(folder / "groundtruth.tum", [(START_NS, np.eye(4))])
    (folder / "cam1" / "data" / f"{START_NS}.png").write_bytes(b"")
    sequence = open_sequence(folder)
    faults = [parse_fault(text) for text in ("dropped:1", "gain_2:2", "gain_0.3:2", "miscalibrated_left_x:all")]
    faulty = FaultySequence(sequence, faults)
    assert len(faulty) == 3
    assert faulty.truth is sequence.truth
    assert faulty.notices == sequence.notices != []
    pixels = sequence[2].left.pixels.astype(float)
    expected = 0.3 * np.minimum(2 * pixels, 255)
    assert np.abs(faulty[1].left.pixels - expected).max() <= 0.5 + 1e-9


@pytest.mark.parametrize("name", [name for name in FAULT_NAMES if name not in STRENGTHS])
def test_every_name_is_understood_and_played(recorded: Recorded, name: str) -> None:
    frames = play(recorded, f"{name}:all")
    assert len(frames) == (0 if name == "dropped" else FRAMES)


def test_the_frames_of_a_fault() -> None:
    fault = parse_fault("black:1,3-5,9")
    assert [index for index in range(12) if fault.strikes(index)] == [1, 3, 4, 5, 9]
    assert all(parse_fault("black:all").strikes(index) for index in (0, 10**6))
    assert parse_fault("black:0-999999999").strikes(10**8)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("fog:3", "no fault 'fog'"),
        ("", "no fault ''"),
        ("black", "no frames"),
        ("black:", "'' is no frame number"),
        ("black:x", "'x' is no frame number"),
        ("black:1-", "'1-' is no frame number"),
        ("black:-1", "'-1' is no frame number"),
        ("black:1,,2", "'' is no frame number"),
        ("black:٣", "is no frame number"),
        ("black:5-3", "5-3 ends before it begins"),
        ("miscalibrated_left_x:3", "wrong in all frames"),
    ],
)
def test_what_is_no_fault(text: str, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        parse_fault(text)
    assert repr(text) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_frames_beyond_the_last(recorded: Recorded) -> None:
    with pytest.raises(InputError, match=f"black: there is no frame {FRAMES}"):
        FaultySequence(recorded, [parse_fault(f"black:2,{FRAMES}")])
    assert len(FaultySequence(recorded, [parse_fault(f"black:{FRAMES - 1}")])) == FRAMES


def test_the_response_to_a_fault(recorded: Recorded) -> None:
    faulty = FaultySequence(recorded, [parse_fault("late:2,4")])
    assert faulty.timestamps_ns == tuple(frame.timestamp_ns for frame in faulty)
    run = a_run(faulty.timestamps_ns)  # refuses the first and the sixth frame that arrive
    late, early = (faulty.response(parse_fault(text), run) for text in ("late:2,4", "black:0-3,5"))
    assert [s.timestamp_ns for s in late.struck] == [START_NS + i * STEP_NS for i in (2, 4)]
    assert (late.refused, late.alarm, late.again, late.reasons) == (1, 1, 0, ("LEFT_UNUSABLE", "TOO_FEW_LINES"))
    assert [s.timestamp_ns for s in early.struck] == [START_NS + i * STEP_NS for i in (0, 1, 3, 2, 5)]
    assert (early.refused, early.alarm, early.again) == (1, 0, None)
    dropped = faulty.response(parse_fault("dropped:all"), [])
    assert (dropped.struck, dropped.refused, dropped.alarm, dropped.again) == ((), 0, None, None)


def test_a_reason_beside_a_published_pose_is_an_alarm(recorded: Recorded) -> None:
    faulty = FaultySequence(recorded, [parse_fault("black_left:1-3")])
    run = a_run(faulty.timestamps_ns)
    mono = [attrs.evolve(s, reasons={Reason.LEFT_UNUSABLE}) if s.published and i == 2 else s for i, s in enumerate(run)]
    response = faulty.response(parse_fault("black_left:1-3"), mono)
    assert (response.refused, response.alarm) == (0, 1)


def test_wrong_poses_are_those_of_the_struck_frames() -> None:
    stamps = [START_NS + i * STEP_NS for i in range(8)]
    run, truth = a_run(stamps), true_poses(stamps)
    for index in (2, 3):
        truth[stamps[index]] = truth[stamps[index]] @ transform([0.03, 0.0, 0.0])
    evaluation = evaluate(run, truth)
    assert [Response.of(stamps[i:j], run).wrong(evaluation) for i, j in ((0, 8), (3, 6), (4, 8))] == [2, 1, 0]


def test_the_navigator_holds_through_faults_of_the_delivery(noisy: Recorded) -> None:
    faulty = FaultySequence(noisy, [parse_fault(text) for text in ("duplicated:32", "black_right:34", "late:36")])
    navigator = Navigator(faulty.rig, faulty.target)
    solutions = {index: navigator.process(faulty[index]) for index in range(30, 39)}
    unpublished = {index: s.reasons for index, s in solutions.items() if not s.published}
    assert solutions[34].reasons == {Reason.RIGHT_UNUSABLE}
    assert solutions[34].mode is Mode.MONO_LEFT
    assert set(unpublished) == {32, 37}  # the late frame arrives as the 37th
    assert Reason.DUPLICATE in unpublished[32]
    assert Reason.TIME_ORDER in unpublished[37]


@pytest.mark.parametrize("name", ["miscalibrated_right_x", "miscalibrated_both_focal", "black_right", "swapped"])
def test_a_camera_that_is_not_there(recorded: Recorded, name: str) -> None:
    rig = Rig(recorded.rig.cameras[:1], recorded.rig.T_world_cam[:1])
    alone = Recorded(recorded.path, rig, recorded.target, recorded.truth, [], [])
    with pytest.raises(InputError, match=rf"fault {name}: there is one camera"):
        FaultySequence(alone, [Fault(name)])
    left = name.replace("right", "left").replace("both", "left").replace("swapped", "dropped")
    FaultySequence(alone, [Fault(left)])
