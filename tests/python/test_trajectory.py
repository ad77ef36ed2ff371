from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rvdnav.errors import InputError
from rvdnav.trajectory import Truth, read_tum, write_tum
from scipy.spatial.transform import Rotation

START_NS = 1_700_000_000_000_000_000


def poses(n: int) -> np.ndarray:
    rng = np.random.default_rng(11)
    T = np.tile(np.eye(4), (n, 1, 1))
    T[:, :3, :3] = Rotation.random(n, random_state=rng).as_matrix()
    T[:, :3, 3] = rng.uniform(-2, 2, (n, 3))
    return T


def test_round_trip(tmp_path: Path) -> None:
    T = poses(50)
    stamps = [START_NS + i * 125_000_001 for i in range(50)]
    write_tum(tmp_path / "poses.tum", zip(stamps, T, strict=True))
    read = read_tum(tmp_path / "poses.tum")
    assert read.timestamps_ns.tolist() == stamps
    np.testing.assert_allclose(read.T_world_target, T, atol=5e-9)


def test_the_file_is_what_others_read(tmp_path: Path) -> None:
    T = poses(4)
    write_tum(tmp_path / "poses.tum", [(START_NS + i, pose) for i, pose in enumerate(T)])
    table = np.loadtxt(tmp_path / "poses.tum")
    np.testing.assert_allclose(table[:, 1:4], T[:, :3, 3], atol=1e-9)
    np.testing.assert_allclose(Rotation.from_quat(table[:, 4:]).as_matrix(), T[:, :3, :3], atol=5e-9)
    assert (tmp_path / "poses.tum").read_text().splitlines()[2].split()[0] == "1700000000.000000001"


def test_shared_truth(shared_data: Path) -> None:
    path = shared_data / "sequences" / "approach" / "groundtruth.tum"
    truth = read_tum(path)
    assert len(truth) == 48
    assert truth.timestamps_ns[1] == 1_700_000_000_125_000_000
    table = np.loadtxt(path)
    np.testing.assert_allclose(truth.T_world_target[:, :3, 3], table[:, 1:4], atol=1e-12)
    np.testing.assert_allclose(
        truth.T_world_target[:, :3, :3], Rotation.from_quat(table[:, 4:]).as_matrix(), atol=1e-12
    )


def test_a_run_without_poses(tmp_path: Path) -> None:
    write_tum(tmp_path / "poses.tum", [])
    read = read_tum(tmp_path / "poses.tum")
    assert len(read) == 0
    assert read.at(0) is None


def test_a_failed_write_leaves_the_old_file(tmp_path: Path) -> None:
    path = tmp_path / "poses.tum"
    path.write_text("old\n")
    with pytest.raises(TypeError):
        write_tum(path, [(START_NS, np.eye(4)), (START_NS, None)])
    assert path.read_text() == "old\n"
    assert [file.name for file in tmp_path.iterdir()] == ["poses.tum"]
    with pytest.raises(InputError, match="nowhere"):
        write_tum(tmp_path / "nowhere" / "poses.tum", [])
    (tmp_path / "taken").mkdir()
    with pytest.raises(InputError, match="taken: cannot be written"):
        write_tum(tmp_path / "taken", [])
    assert sorted(file.name for file in tmp_path.iterdir()) == ["poses.tum", "taken"]


def test_lookup_by_time() -> None:
    T = poses(3)
    truth = Truth([START_NS, START_NS + 10**8, START_NS + 2 * 10**8], T)
    for index in range(3):
        for shift in (-1000, -238, 0, 999):
            found = truth.at(START_NS + index * 10**8 + shift)
            np.testing.assert_array_equal(found, T[index])
    for missing in (START_NS - 1001, START_NS + 1001, START_NS + 5 * 10**7, START_NS + 3 * 10**8):
        assert truth.at(missing) is None


def test_writers_of_other_tools_are_understood(tmp_path: Path) -> None:
    path = tmp_path / "groundtruth.tum"
    path.write_text("\n# by evo\n1.700000000125000000e+09 1e0 2 3 0 0 0 1\n1700000000.25,1,2,3,0,0,0.7071,0.7071\n")
    truth = read_tum(path)
    assert truth.timestamps_ns.tolist() == [1_700_000_000_125_000_000, 1_700_000_000_250_000_000]
    np.testing.assert_allclose(truth.T_world_target[1, :3, :3], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-12)


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        ("2.0 1 2 3 0 0 0", "7 values"),
        ("2.0 1 2 3 0 0 0 1 9", "9 values"),
        ("2.0 1 x 3 0 0 0 1", "could not convert"),
        ("2.0 1 nan 3 0 0 0 1", "not finite"),
        ("2.0 1 2 3 0 0 0 1.1", "length 1.1"),
        ("2.0 1 2 3 0 0 0 0", "length 0"),
        ("1.0 1 2 3 0 0 0 1", "do not increase"),
        ("nan 1 2 3 0 0 0 1", "is not a timestamp"),
        ("1e11 1 2 3 0 0 0 1", "outside the range"),
    ],
)
def test_malformed_lines(tmp_path: Path, line: str, fault: str) -> None:
    path = tmp_path / "poses.tum"
    path.write_text(f"# head\n1.0 1 2 3 0 0 0 1\n{line}\n")
    with pytest.raises(InputError) as caught:
        read_tum(path)
    message = str(caught.value)
    assert message.startswith(f"{path}: line 3: ")
    assert fault in message


def test_truths_that_are_none() -> None:
    with pytest.raises(ValueError, match="do not increase"):
        Truth([2, 1], poses(2))
    with pytest.raises(ValueError, match="timestamps for 2 poses"):
        Truth([1], poses(2))
