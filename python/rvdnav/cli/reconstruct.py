"""``rvdnav reconstruct``: the visible surface of one stereo frame as a point cloud."""

from __future__ import annotations

from pathlib import Path

from rvdnav.cli.tables import print_cloud
from rvdnav.cli.terminal import console
from rvdnav.core import Core
from rvdnav.errors import InputError
from rvdnav.output import staged_directory, staged_report
from rvdnav.reconstruction import ply_bytes, reconstruct
from rvdnav.report import write_cloud_report
from rvdnav.sequence import Sequence, open_sequence

_CAMERAS = ("left", "right")


def reconstruct_frame(path: Path, index: int, out: Path) -> int:
    """Write the surface in a frame of the sequence at ``path`` (``index`` 0: the first) to ``out``, and a report.

    Returns 0 if there are any points, else 1.  Raises InputError.
    """
    report = out.with_suffix(".html")
    _check_output(out, report)
    sequence = open_sequence(path)
    if not sequence.rig.is_stereo:
        raise InputError(f"{path / 'camchain.yaml'}: one camera; a surface needs two")
    _check_index(path, sequence, index)
    frame = sequence[index]
    if frame.left is None or frame.right is None:
        camera = _CAMERAS[0 if frame.left is None else 1]
        raise InputError(f"{path}: frame {index} has no {camera} image; a surface needs both")
    cloud = reconstruct(Core(sequence.rig), frame.left.pixels, frame.right.pixels)
    with staged_directory(out.parent) as staging:
        (staging / out.name).write_bytes(ply_bytes(cloud))
    print_cloud(cloud)
    with staged_report(report.parent, report.name) as page:
        write_cloud_report(page, f"{path.resolve().name}, frame {index}", cloud, frame, sequence.rig)
    console.print(f"report: {report}", soft_wrap=True)
    return 0 if len(cloud) else 1


def _check_output(out: Path, report: Path) -> None:
    if out.suffix.lower() != ".ply":
        raise InputError(f"{out}: the name of a point cloud ends in .ply")
    for file in (out, report):
        if file.is_dir():
            raise InputError(f"{file}: is a folder")


def _check_index(path: Path, sequence: Sequence, index: int) -> None:
    if not 0 <= index < len(sequence):
        known = f"there are 0 to {len(sequence) - 1}" if len(sequence) else "there are none"
        raise InputError(f"{path}: there is no frame {index}; {known}")
