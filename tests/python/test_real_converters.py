"""The converters of examples/real, on small files of each format."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from cao_to_target import target_from_cao
from images_to_camera import write_camera
from pose_to_initial_pose import pose_from_clicks, pose_from_file, pose_text
from rvdnav.navigator import parse_pose
from rvdnav.target import Target, load_target
from rvdnav.target_writer import save_target
from scipy.spatial.transform import Rotation
from wrl_to_target import target_from_wrl
from xml_to_rig import camera_from_xml

BRICK = """V1
# a brick of 4 x 2 x 1 cm
8 # points
0 0 0
0.04 0 0
0.04 0.02 0 # with a remark
0 0.02 0
0 0 0.01
0.04 0 0.01
0.04 0.02 0.01
0 0.02 0.01
1 # lines
0 6
0
6 # faces
4 3 2 1 0 name=bottom
4 4 5 6 7
4 0 1 5 4
4 1 2 6 5 useLod=false
4 2 3 7 6
4 3 0 4 7
1 # a cylinder
0 1 0.01
0
"""


def ends(target: Target) -> list[np.ndarray]:
    return [np.array([target.points[a], target.points[b]]) for a, b in target.edges]


def test_a_cao_model_has_its_edges_once_and_its_lines(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "brick.cao"
    path.write_text(BRICK)
    target = target_from_cao(path, "brick")
    assert (len(target.points), len(target.edges), len(target.faces)) == (8, 13, 6)
    lengths = sorted(float(np.linalg.norm(b - a)) for a, b in ends(target))
    diagonal = float(np.sqrt(0.04**2 + 0.02**2 + 0.01**2))
    np.testing.assert_allclose(lengths, [0.01] * 4 + [0.02] * 4 + [0.04] * 4 + [diagonal])
    assert "1 cylinders or circles are left out" in capsys.readouterr().out
    save_target(target, tmp_path / "target.yaml")
    assert load_target(tmp_path / "target.yaml").faces == target.faces


def test_parts_are_turned_and_shifted_where_they_are_loaded(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "brick.cao").write_text(BRICK)
    path = tmp_path / "two.cao"
    path.write_text(
        'V1\nload("parts/brick.cao")\nload("parts/brick.cao", t=[0.1; 0; 0.2], tu=[0; 0; 90 deg]) # turned\n'
        + "0\n" * 6
    )
    points = np.array(list(target_from_cao(path, "two").points.values()))
    assert len(points) == 16
    turned = points[:8] @ Rotation.from_euler("z", 90, degrees=True).as_matrix().T + [0.1, 0.0, 0.2]
    np.testing.assert_allclose(points[8:], turned, atol=1e-12)


def test_a_face_that_is_almost_planar_is_made_so_and_a_crooked_one_refused(tmp_path: Path) -> None:
    path = tmp_path / "brick.cao"
    path.write_text(BRICK.replace("0.04 0.02 0.01", "0.04 0.02 0.0104"))
    corner = target_from_cao(path, "brick").points["P6"]
    assert 0.01 < corner[2] < 0.0104
    path.write_text(BRICK.replace("0.04 0.02 0.01", "0.04 0.02 0.018"))
    with pytest.raises(ValueError, match="not planar"):
        target_from_cao(path, "brick")


@pytest.mark.parametrize("text", ["", "V2\n", "V1\n8\n0 0 0\n", BRICK.replace("4 4 5 6 7", "4 4 5 6 77")])
def test_a_broken_cao_model_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "broken.cao"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"broken\.cao"):
        target_from_cao(path, "broken")


def test_the_triangles_of_a_vrml_model_make_faces_without_diagonals(tmp_path: Path) -> None:
    path = tmp_path / "cube.wrl"
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    index = ", ".join(f"{a},{b},{c},-1" for a, b, c in [*faces, (0, 0, 1)])
    point = ", ".join(f"{x} {y} {z}" for x, y, z in corners)
    path.write_text(
        f"#VRML V2.0 utf8\nShape {{ geometry IndexedFaceSet {{ coord Coordinate {{ point [ {point} ] }}\n"
        f"coordIndex [ {index} ] }} }}\n"
    )
    target = target_from_wrl(path, "cube")
    assert (len(target.points), len(target.faces)) == (8, 12)
    np.testing.assert_allclose([float(np.linalg.norm(b - a)) for a, b in ends(target)], np.ones(12))


def test_the_pose_of_clicks_is_that_of_the_camera(tmp_path: Path) -> None:
    (tmp_path / "camera.xml").write_text(
        "<conf><camera><u0>320</u0><v0>241</v0><px>700</px><py>702</py><kud>-0.1</kud></camera></conf>"
    )
    camera = camera_from_xml(tmp_path / "camera.xml")
    assert (camera.width, camera.height, camera.fy, camera.distortion[0]) == (640, 480, 702.0, -0.1)
    R, t = Rotation.from_rotvec([2.1, 1.1, -0.4]), np.array([0.02, 0.05, 0.5])
    points = np.array([[0, 0, 0], [0, 0, 0.08], [-0.08, 0, 0.08], [-0.08, 0.08, 0.08]])
    (tmp_path / "cube.init").write_text("4 # points\n" + "\n".join(" ".join(map(str, p)) for p in points) + "\n")
    pixels = camera.project(R.apply(points) + t)
    T = pose_from_clicks(tmp_path / "cube.init", camera, [(u, v) for u, v in pixels])
    np.testing.assert_allclose(T[:3, 3], t, atol=1e-6)
    np.testing.assert_allclose(T[:3, :3], R.as_matrix(), atol=1e-5)
    np.testing.assert_allclose(parse_pose(pose_text(T)), T, atol=1e-8)
    (tmp_path / "cube.pos").write_text("\n".join(map(str, [*t, *R.as_rotvec()])))
    np.testing.assert_allclose(pose_from_file(tmp_path / "cube.pos"), T, atol=1e-5)
    with pytest.raises(ValueError, match="4 points but 3 pixels"):
        pose_from_clicks(tmp_path / "cube.init", camera, [(u, v) for u, v in pixels[:3]])


def test_pictures_become_the_images_of_a_camera_in_their_order(tmp_path: Path) -> None:
    pixels = [np.full((4, 6), 40 * number, np.uint8) for number in range(3)]
    for number, picture in enumerate(pixels):
        cv2.imwrite(str(tmp_path / f"image{number}.pgm"), picture)
    stamps = write_camera(sorted(tmp_path.glob("*.pgm")), tmp_path / "cam0", rate=10.0)
    assert np.diff(stamps).tolist() == [100_000_000, 100_000_000]
    for stamp, picture in zip(stamps, pixels, strict=True):
        np.testing.assert_array_equal(cv2.imread(str(tmp_path / "cam0" / "data" / f"{stamp}.png"), 0), picture)
