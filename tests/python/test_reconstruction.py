"""The surface as a point cloud: exact geometry, the PLY file, the report and the command."""

from __future__ import annotations

import base64
import shutil
from pathlib import Path

import attrs
import cv2
import numpy as np
import pytest
import yaml
from drawn_scene import Look, bracket_target, draw_frame, example_rig, pose, wide_rig
from rvdnav import CoreError, open_sequence
from rvdnav.cli.app import execute
from rvdnav.core import Core
from rvdnav.reconstruction import Cloud, ply_bytes, reconstruct
from rvdnav.report import write_cloud_report
from rvdnav.rig import Rig
from rvdnav.target import Target

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "approach"


def a_cloud(n: int = 7) -> Cloud:
    rng = np.random.default_rng(3)
    return Cloud(
        points_W=rng.uniform(0.3, 1.2, (n, 3)),
        sigma=rng.uniform(1e-4, 5e-3, n),
        grey=rng.integers(0, 256, n).astype(np.uint8),
        left=rng.uniform(-200, 200, (n, 2)),
        disparity=rng.uniform(60, 200, n),
        sigma_disparity=rng.uniform(0.05, 0.5, n),
        score=rng.uniform(0.7, 1.0, n),
        crossings=2 * n,
    )


def face_points(cloud: Cloud, rig: Rig, target: Target, T: np.ndarray, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """Mask of the points whose left ray meets the bracket's front face, and all points' distance behind its plane, m.

    reach: how far beyond the face's outline still counts, px.
    """
    normal, centre = T[:3, 0], rig.T_world_cam[0][:3, 3]
    rays = np.column_stack([cloud.left / rig.focal_rect, np.ones(len(cloud))]) @ rig.R_world_rect.T
    hits = centre + rays * (((T[:3, 3] - centre) @ normal) / (rays @ normal))[:, None]
    hits_C = ((hits - T[:3, 3]) @ T[:3, :3])[:, 1:]
    bracket = target.bracket
    assert bracket is not None
    margin = reach * float(T[0, 3]) / rig.focal_rect
    inside = [_depth_inside(corners[:, 1:], hits_C) for corners in (bracket.outer, bracket.inner)]
    on_face = (inside[0] > -margin) & (inside[1] < margin)
    return on_face, (cloud.points_W - T[:3, 3]) @ normal


def _depth_inside(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distance from the nearest side of a convex polygon, m, positive inside."""
    sides = np.roll(corners, -1, axis=0) - corners
    normals = np.column_stack([-sides[:, 1], sides[:, 0]]) / np.linalg.norm(sides, axis=1, keepdims=True)
    distances = np.einsum("nsk,sk->ns", points[:, None] - corners, normals)
    turn = np.sign(np.einsum("sk,sk->s", corners.mean(axis=0) - corners, normals))
    return (distances * turn).min(axis=1)


@pytest.mark.parametrize("x", [0.4, 0.8, 1.3])
@pytest.mark.parametrize("make_rig", [example_rig, wide_rig])
def test_points_of_a_drawn_bracket_lie_on_its_face_within_their_sigmas(make_rig, x):
    rig, target = make_rig(), bracket_target()
    T = pose(x, z=0.03, phi=4.0, theta=-6.0, psi=3.0)
    frame = draw_frame(rig, target, T, seed=5, look=Look(thick=False))
    cloud = reconstruct(Core(rig), frame.left.pixels, frame.right.pixels)
    on_face, error = face_points(cloud, rig, target, T, reach=0.7)
    assert on_face.sum() > 60
    assert np.mean(np.abs(error[on_face]) <= 3 * cloud.sigma[on_face]) > 0.93
    assert np.median(cloud.sigma[on_face]) < 0.005 * x**2
    assert np.median(np.abs(error[on_face])) < 0.002 * x**2


@pytest.mark.parametrize("name", ["approach", "sunlit"])
def test_rendered_faces_lie_where_they_are(shared_data, name):
    """Of all frames' points on the face 90 % and more lie within 3 sigma of it, with sigmas below 5 mm at 1 m."""
    sequence = open_sequence(shared_data / "sequences" / name)
    core = Core(sequence.rig)
    within, sigmas = [], []
    for index in range(1, len(sequence), 6):
        frame = sequence[index]
        cloud = reconstruct(core, frame.left.pixels, frame.right.pixels)
        T = sequence.truth.at(frame.timestamp_ns)
        on_face, error = face_points(cloud, sequence.rig, sequence.target, T, reach=0.0)
        assert on_face.sum() > 80
        within.append(np.abs(error[on_face]) <= 3 * cloud.sigma[on_face])
        assert within[-1].mean() > 0.9
        sigmas.append(np.median(cloud.sigma[on_face]) / T[0, 3] ** 2)
    assert np.concatenate(within).mean() > 0.95
    assert np.median(sigmas) < 0.003


def test_points_are_where_their_disparity_says():
    rig = example_rig()
    frame = draw_frame(rig, bracket_target(), pose(0.8), seed=6)
    cloud = reconstruct(Core(rig), frame.left.pixels, frame.right.pixels)
    right = cloud.left - np.column_stack([cloud.disparity, np.zeros(len(cloud))])
    np.testing.assert_allclose(rig.project_rect(0, cloud.points_W), cloud.left, atol=1e-6)
    np.testing.assert_allclose(rig.project_rect(1, cloud.points_W), right, atol=1e-6)
    # A sigma is what the disparity's own does to the point.
    moved = rig.project_rect(1, cloud.points_W)[:, 0] - cloud.sigma_disparity
    nearer = rig.focal_rect * rig.baseline / (cloud.left[:, 0] - moved)
    ray = np.linalg.norm(cloud.points_W - rig.T_world_cam[0][:3, 3], axis=1)
    change = ray * (1.0 - nearer / cloud.depth)
    np.testing.assert_allclose(cloud.sigma, change, rtol=0.05)


def test_settings_bound_the_search():
    rig = example_rig()
    frame = draw_frame(rig, bracket_target(), pose(0.8), seed=6)
    near = reconstruct(Core(rig, range_max=0.7), frame.left.pixels, frame.right.pixels)
    assert np.all(near.depth < 0.71)
    strict = reconstruct(Core(rig, match_min_score_q8=243), frame.left.pixels, frame.right.pixels)
    assert np.all(strict.score >= 243 / 256 - 1e-4)


def test_one_camera_is_refused_by_the_core():
    rig = example_rig()
    alone = Rig(rig.cameras[:1], rig.T_world_cam[:1])
    image = np.zeros((rig.height, rig.width), np.uint8)
    with pytest.raises(CoreError, match="argument"):
        reconstruct(Core(alone), image, image)


def read_ply(data: bytes) -> dict[str, np.ndarray]:
    """A reader by the format's own rules: scalar properties of one element, little-endian."""
    head, _, body = data.partition(b"end_header\n")
    lines = head.decode("ascii").splitlines()
    assert lines[:2] == ["ply", "format binary_little_endian 1.0"]
    count = next(int(line.split()[2]) for line in lines if line.startswith("element vertex "))
    kinds = {"float": "<f4", "uchar": "u1"}
    fields = [(line.split()[2], kinds[line.split()[1]]) for line in lines if line.startswith("property ")]
    assert len(body) == count * np.dtype(fields).itemsize
    vertices = np.frombuffer(body, fields)
    return {name: vertices[name] for name, _ in fields}


@pytest.mark.parametrize("n", [0, 1, 500])
def test_a_ply_file_holds_the_cloud(n):
    cloud = a_cloud(n)
    read = read_ply(ply_bytes(cloud))
    assert list(read) == ["x", "y", "z", "sigma", "grey", "red", "green", "blue"]
    np.testing.assert_allclose(np.column_stack([read[k] for k in "xyz"]), cloud.points_W, rtol=1e-6)
    np.testing.assert_allclose(read["sigma"], cloud.sigma, rtol=1e-6)
    for name in ("grey", "red", "green", "blue"):
        np.testing.assert_array_equal(read[name], cloud.grey)


@pytest.fixture
def example(tmp_path) -> Path:
    """The first frames of the example."""
    folder = tmp_path / "sequence"
    for camera in ("cam0", "cam1"):
        (folder / camera / "data").mkdir(parents=True)
        for path in sorted((EXAMPLE / camera / "data").iterdir())[:2]:
            shutil.copy(path, folder / camera / "data")
    for name in ("camchain.yaml", "rig.yaml", "target.yaml"):
        shutil.copy(EXAMPLE / name, folder)
    return folder


def test_the_command_writes_cloud_and_report(example, tmp_path, capsys):
    out = tmp_path / "new" / "cloud.ply"
    assert execute(["reconstruct", str(example), "--frame", "1", "--out", str(out)]) == 0
    assert sorted(path.name for path in out.parent.iterdir()) == ["cloud.html", "cloud.ply", "plotly.min.js"]
    frame = open_sequence(example)[1]
    cloud = reconstruct(Core(open_sequence(example).rig), frame.left.pixels, frame.right.pixels)
    assert out.read_bytes() == ply_bytes(cloud)
    page = (out.parent / "cloud.html").read_text()
    for words in ("sequence, frame 1", str(len(cloud)), "data:image/jpeg;base64,", "figure-cloud", "figure-sigma"):
        assert words in page
    text = capsys.readouterr().out
    assert 0 < len(cloud) < cloud.crossings
    assert f"{len(cloud)} of {cloud.crossings} zero crossings" in text
    assert "the other zero crossings have no match to rely on" in text
    assert "sigma, median / 95 %" in text
    first = (out.read_bytes(), page)
    execute(["reconstruct", str(example), "--frame", "1", "--out", str(out)])
    assert (out.read_bytes(), (out.parent / "cloud.html").read_text()) == first


def test_a_frame_without_any_match_is_exit_code_1_with_the_files_written(make_sequence, tmp_path, capsys):
    out = tmp_path / "cloud.ply"
    assert execute(["reconstruct", str(make_sequence()), "--frame", "0", "--out", str(out)]) == 1
    assert len(read_ply(out.read_bytes())["x"]) == 0
    assert out.with_suffix(".html").exists()
    assert "0 of " in capsys.readouterr().out


@pytest.mark.parametrize(
    ("sequence", "frame", "out", "fault"),
    [
        ("{tmp}/nowhere", "0", "{tmp}/c.ply", "{tmp}/nowhere: no such folder"),
        ("{sequence}", "2", "{tmp}/c.ply", "{sequence}: there is no frame 2; there are 0 to 1"),
        ("{sequence}", "-1", "{tmp}/c.ply", "{sequence}: there is no frame -1; there are 0 to 1"),
        ("{sequence}", "one", "{tmp}/c.ply", "--frame"),
        ("{sequence}", "0", "{tmp}/c.xyz", "{tmp}/c.xyz: the name of a point cloud ends in .ply"),
        ("{sequence}", "0", "{tmp}/folder.ply", "{tmp}/folder.ply: is a folder"),
        ("{sequence}", "0", "{tmp}/file/c.ply", "{tmp}/file: not a folder"),
    ],
)
def test_a_mistake_gets_one_line_and_exit_code_2(example, tmp_path, capsys, sequence, frame, out, fault):
    (tmp_path / "file").write_text("")
    (tmp_path / "folder.ply").mkdir()
    before = sorted(tmp_path.rglob("*"))
    places = {"tmp": tmp_path, "sequence": example}
    arguments = ["reconstruct", sequence, "--frame", frame, "--out", out]
    assert execute([argument.format(**places) for argument in arguments]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert fault.format(**places) in line
    assert sorted(tmp_path.rglob("*")) == before


def test_one_camera_and_half_frames_are_bad_input(example, tmp_path, capsys):
    shutil.rmtree(example / "cam1")
    out = str(tmp_path / "c.ply")
    assert execute(["reconstruct", str(example), "--frame", "0", "--out", out]) == 2
    assert "frame 0 has no right image; a surface needs both" in capsys.readouterr().err
    chain = yaml.safe_load((example / "camchain.yaml").read_text())
    del chain["cam1"]
    (example / "camchain.yaml").write_text(yaml.safe_dump(chain))
    (example / "rig.yaml").unlink()
    assert execute(["reconstruct", str(example), "--frame", "0", "--out", out]) == 2
    assert "camchain.yaml: one camera; a surface needs two" in capsys.readouterr().err
    assert not Path(out).exists()


def test_the_picture_shows_near_and_far_points_in_different_colours(tmp_path):
    rig = example_rig()
    frame = draw_frame(rig, bracket_target(), pose(0.8), seed=6)
    frame = attrs.evolve(frame, left=attrs.evolve(frame.left, pixels=np.zeros((576, 704), np.uint8)))
    places = np.array([[-50.0, 10.0], [80.0, 10.0]])
    cloud = attrs.evolve(a_cloud(2), left=places, points_W=np.array([[0.5, 0, 0], [1.5, 0, 0]]))
    write_cloud_report(tmp_path / "page.html", "two <points>", cloud, frame, rig)
    page = (tmp_path / "page.html").read_text()
    assert "two &lt;points&gt;" in page
    encoded = page.partition("data:image/jpeg;base64,")[2].partition('"')[0]
    picture = cv2.imdecode(np.frombuffer(base64.b64decode(encoded), np.uint8), cv2.IMREAD_COLOR)
    blue, red = (picture[round(2 * v + 0.5), round(2 * u + 0.5)].astype(int) for u, v in rig.rect_to_raw(0, places))
    assert blue[0] > blue[1] + 20
    assert red[2] > red[0] + 30
