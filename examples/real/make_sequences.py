"""Sequences from the pictures and videos that scripts/fetch-real-images has brought: all of them, or those named.

python examples/real/make_sequences.py data/visp data/real [NAME ...]
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import attrs
import numpy as np
from cao_to_target import target_from_cao
from images_to_camera import write_camera
from pose_to_initial_pose import pose_from_clicks, pose_from_file, pose_text
from rvdnav.rig import Rig, save_rig, world_from_camchain
from rvdnav.sequence import write_tum
from rvdnav.target_writer import save_target
from wrl_to_target import target_from_wrl
from xml_to_rig import camera_from_xml

_TEABOX = "tutorial/tracking/model-based/generic/model/teabox"
_STEREO = "tutorial/tracking/model-based/generic-stereo"
_BLENDER = "tutorial/tracking/model-based/generic-rgbd-blender"
_CASTLE = "mbt-depth/castel"
_CASTLE_SIMULATED = "mbt-depth/Castle-simu"


@attrs.frozen
class Recording:
    """Where the parts of a sequence are.

    model, cameras, start: files; images: of each camera, a video or a pattern of pictures.  clicks: pixels of the
    points of `start`, an .init file, in the first image, put there by hand.  T_right_left: a file.  poses: a pattern
    of files with the true pose in each frame.
    """

    model: str
    cameras: tuple[str, ...]
    images: tuple[str, ...]
    start: str
    clicks: tuple[tuple[float, float], ...] = ()
    T_right_left: str | None = None
    poses: str | None = None


RECORDINGS = {
    "cube": Recording("mbt/cube.cao", ("mbt/cube.xml",), ("mbt/cube/*.pgm",), "mbt/cube.0.pos"),
    "cube_video": Recording(
        "tutorial/detection/object/cube.cao",
        ("tutorial/detection/object/cube.xml",),
        ("tutorial/detection/object/cube.mp4",),
        "mbt/cube.0.pos",  # the same scene, a little later
    ),
    "teabox": Recording(
        f"{_TEABOX}/teabox.cao",
        (f"{_TEABOX}/teabox.xml",),
        (f"{_TEABOX}/teabox.mp4",),
        f"{_TEABOX}/teabox.init",
        clicks=((192.6, 84.0), (347.4, 205.7), (329.7, 376.0), (458.3, 349.7)),
    ),
    "teabox_stereo": Recording(
        f"{_STEREO}/teabox.cao",
        (f"{_STEREO}/teabox_left.xml", f"{_STEREO}/teabox_right.xml"),
        (f"{_STEREO}/teabox_left.mp4", f"{_STEREO}/teabox_right.mp4"),
        f"{_STEREO}/teabox_left.init",
        clicks=((245.6, 341.4), (523.5, 323.0), (508.1, 385.9), (502.9, 233.9)),
        T_right_left=f"{_STEREO}/cRightMcLeft.txt",
    ),
    "castle": Recording(
        f"{_CASTLE}/chateau.cao",
        (f"{_CASTLE}/chateau.xml",),
        (f"{_CASTLE}/castel/*.pgm",),
        f"{_CASTLE}/chateau.0.pos",
    ),
    "castle_simulated": Recording(
        f"{_CASTLE_SIMULATED}/Models/chateau.wrl",
        (f"{_CASTLE_SIMULATED}/Config/chateau.xml",),
        (f"{_CASTLE_SIMULATED}/Images/*.pgm",),
        f"{_CASTLE_SIMULATED}/CameraPose/Camera_001.txt",
        poses=f"{_CASTLE_SIMULATED}/CameraPose/*.txt",
    ),
    "teabox_simulated": Recording(
        f"{_BLENDER}/teabox.cao",
        (f"{_BLENDER}/teabox.xml",),
        (f"{_BLENDER}/images/*.jpg",),
        f"{_BLENDER}/camera_poses/Camera_001.txt",
        poses=f"{_BLENDER}/camera_poses/*.txt",
    ),
}


def make_sequence(name: str, source: Path, folder: Path) -> Path:
    """Write one of the recordings as a sequence into the folder, with `initial_pose.txt`; returns the sequence."""
    recording = RECORDINGS[name]
    sequence = folder / name
    sequence.mkdir(parents=True, exist_ok=True)
    read_model = target_from_cao if recording.model.endswith(".cao") else target_from_wrl
    save_target(read_model(source / recording.model, name), sequence / "target.yaml")
    cameras = [camera_from_xml(source / file) for file in recording.cameras]
    T_world_cam: tuple[np.ndarray, ...] = (np.eye(4),)
    if recording.T_right_left is not None:
        T_world_cam = world_from_camchain(pose_from_file(source / recording.T_right_left))
    save_rig(Rig(cameras, T_world_cam), sequence)
    start = source / recording.start
    T_cam0_target = pose_from_clicks(start, cameras[0], recording.clicks) if recording.clicks else pose_from_file(start)
    (sequence / "initial_pose.txt").write_text(pose_text(T_world_cam[0] @ T_cam0_target) + "\n")
    for index, images in enumerate(recording.images):
        camera = sequence / f"cam{index}"
        if "*" not in images:
            shutil.copyfile(source / images, camera.with_suffix(Path(images).suffix))
            continue
        stamps = write_camera(sorted(source.glob(images)), camera)
        if recording.poses is not None:
            true = (T_world_cam[0] @ pose_from_file(file) for file in sorted(source.glob(recording.poses)))
            write_tum(sequence / "groundtruth.tum", zip(stamps, true, strict=True))
    return sequence


if __name__ == "__main__":
    for chosen in sys.argv[3:] or RECORDINGS:
        print(make_sequence(chosen, Path(sys.argv[1]), Path(sys.argv[2])))
