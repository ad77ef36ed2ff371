"""Packs a sequence folder into one file for the programs beside this: pack.py SEQUENCE FILE [INDEX...]

The format is described in sequence.h.
"""

import struct
import sys
from pathlib import Path

from rvdnav import open_sequence
from rvdnav.core.config import make_config
from rvdnav.core.context import c_rig, c_target
from rvdnav.core.library import ffi, lib
from rvdnav.core.pose import set_cameras
from rvdnav.navigator.edge_model import EdgeModel
from rvdnav.navigator.geometry import rectified_cameras


def pack(sequence_path: Path, file: Path, indices: list[int]) -> None:
    """Writes the frames of the given indices, or all; the bracket as if it were exact."""
    sequence = open_sequence(sequence_path)
    bracket = sequence.target.bracket
    if bracket is None:
        raise SystemExit(f"{sequence_path}: the target is no four-bar bracket")
    rig, target, config = c_rig(sequence.rig), c_target(sequence.target), make_config(isa="auto")
    cameras = ffi.new("rvdnav_pose_cameras *")
    set_cameras(cameras, rectified_cameras(sequence.rig))
    model = EdgeModel.of_bracket(bracket)
    settings = ffi.buffer(config)[: ffi.offsetof("rvdnav_config", "clock")]
    frames = list(sequence)
    chosen = [frames[i] for i in indices] if indices else frames
    with file.open("wb") as out:
        parts = [bytes(ffi.buffer(rig)), bytes(ffi.buffer(target)), settings, bytes(ffi.buffer(cameras))]
        out.write(struct.pack("<8s6I", b"rvdnavsq", lib.rvdnav_abi_version(), len(chosen), *map(len, parts)))
        out.write(b"".join(parts))
        out.write(model.points.astype("<f8").tobytes() + bracket.side_normals.astype("<f8").tobytes())
        out.write(model.ends.astype("<i4").tobytes())
        for frame in chosen:
            images = (frame.left, frame.right)
            present = sum(1 << camera for camera, image in enumerate(images) if image is not None)
            out.write(struct.pack("<qII", frame.timestamp_ns, present, 0))
            for image in images:
                if image is not None:
                    out.write(image.pixels.tobytes())


if __name__ == "__main__":
    pack(Path(sys.argv[1]), Path(sys.argv[2]), [int(i) for i in sys.argv[3:]])
