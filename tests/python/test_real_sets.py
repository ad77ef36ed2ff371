"""Photographs and videos of real things: how many frames are published, and how well projected edges lie on theirs.

The distances are those of `edge_distance`, which shares nothing with the navigator.  The sets are other people's: they
are fetched by scripts/fetch-real-images, and the tests are skipped without them.
"""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from edge_distance import edge_distances
from make_sequences import RECORDINGS, make_sequence
from rvdnav import Navigator, open_sequence
from rvdnav.navigator import parse_pose
from rvdnav.navigator.edge_model import edge_model

_ROOT = Path(__file__).resolve().parents[2]
_VISP = _ROOT / "data" / "visp"
_SHARED = _ROOT.parent / "shared" / "data" / "real"


def set_folder(name: str, tmp_path: Path) -> Path:
    if name in RECORDINGS:
        if not (_VISP / "whole").exists():
            pytest.skip("scripts/fetch-real-images has not fetched the pictures")
        if "*" not in RECORDINGS[name].images[0]:
            pytest.importorskip("av")
        return make_sequence(name, _VISP, tmp_path)
    if not (_SHARED / name).is_dir():
        pytest.skip(f"the set {name} is not here")
    return _SHARED / name


# Frames of the set that are looked at, how many of them must be published, and the largest distance of the median place
# of a frame, px.
@pytest.mark.parametrize(
    ("name", "frames", "least", "distance"),
    [
        ("cube", 10, 8, 0.6),  # the second frame is the first one once more
        ("cube_video", 10, 8, 0.6),
        ("teabox", 12, 10, 1.3),
        ("teabox_stereo", 5, 5, 0.9),
        ("castle_simulated", 10, 10, 0.5),
        ("teabox_simulated", 6, 6, 0.4),
        ("blue_box", 10, 10, 0.7),
    ],
)
def test_published_frames_lie_on_the_edges_of_the_image(
    tmp_path: Path, name: str, frames: int, least: int, distance: float
) -> None:
    folder = set_folder(name, tmp_path)
    sequence = open_sequence(folder)
    model = edge_model(sequence.target)
    start = parse_pose((folder / "initial_pose.txt").read_text())
    navigator = Navigator(sequence.rig, sequence.target, initial_pose=start)
    medians = []
    for frame in islice(sequence, frames):
        T = navigator.process(frame).T_world_target
        if T is None:
            continue
        for camera, image in enumerate((frame.left, frame.right)):
            if image is not None:
                found = edge_distances(image.pixels, sequence.rig, camera, model, T)
                medians.append(float(np.median(np.concatenate(list(found.values())))))
    published = len(medians) // len(sequence.rig.cameras)
    print(name, published, max(medians))
    assert published >= least
    assert max(medians) <= distance
