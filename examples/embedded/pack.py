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


def pack(sequence_path: Path, file: Path, indices: list[int]) -> None:
    """Writes the frames of the given indices, or all."""
    sequence = open_sequence(sequence_path)
    rig, target, config = c_rig(sequence.rig), c_target(sequence.target), make_config(isa="auto")
    if target == ffi.NULL:
        raise SystemExit(f"{sequence_path}: the target is no four-bar bracket")
    settings = ffi.buffer(config)[: ffi.offsetof("rvdnav_config", "clock")]
    frames = list(sequence)
    chosen = [frames[i] for i in indices] if indices else frames
    with file.open("wb") as out:
        sizes = (len(ffi.buffer(rig)), len(ffi.buffer(target)), len(settings))
        out.write(struct.pack("<8s6I", b"rvdnavsq", lib.rvdnav_abi_version(), len(chosen), *sizes, 0))
        out.write(ffi.buffer(rig)[:] + ffi.buffer(target)[:] + settings)
        for frame in chosen:
            images = (frame.left, frame.right)
            cameras = sum(1 << camera for camera, image in enumerate(images) if image is not None)
            out.write(struct.pack("<qII", frame.timestamp_ns, cameras, 0))
            for image in images:
                if image is not None:
                    out.write(image.pixels.tobytes())


if __name__ == "__main__":
    pack(Path(sys.argv[1]), Path(sys.argv[2]), [int(i) for i in sys.argv[3:]])
