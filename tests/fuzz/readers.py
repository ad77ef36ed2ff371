"""Every reader of files, with a good file for it and the folder that it reads the file in."""

from __future__ import annotations

import resource
import shutil
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import cv2
import numpy as np
from rvdnav import Navigator, open_sequence
from rvdnav.blackbox import Recorder, replay
from rvdnav.blackbox.digests import write_digests
from rvdnav.calibration import read_pairs
from rvdnav.calibration.opencv_file import load_opencv, save_opencv
from rvdnav.campaign.plan import load_plan
from rvdnav.errors import InputError
from rvdnav.images import ImageError, image_size, read_image
from rvdnav.output import read_solutions
from rvdnav.rig import load_rig, read_sensors, save_rig
from rvdnav.simulation.scenario_file import load_scenario
from rvdnav.target import load_target
from rvdnav.trajectory import read_tum

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SECONDS = 5.0
MEGABYTES = 500
LONGEST_MESSAGE = 420
_FRAMES = 2


@attrs.frozen
class Reader:
    """A reader of one file in a folder.

    good: what the file should be.  read: of the folder; raises InputError or ImageError for a file at fault.
    """

    name: str
    folder: Path
    file: str
    good: bytes
    read: Callable[[Path], Any]
    is_text: bool = True

    def outcome(self, data: bytes) -> str:
        """Read the file with these contents: empty if that gave a value, else the message of the refusal.

        Raises AssertionError for a refusal that isn't one printable line and for what takes too much time or memory,
        and whatever else the reader raises.
        """
        path = self.folder / self.file
        if path.is_symlink() or not path.is_dir():
            path.unlink(missing_ok=True)
        path.write_bytes(data)
        return self.outcome_now()

    def outcome_now(self) -> str:
        """As `outcome`, of the file as it stands."""
        start, memory = time.process_time(), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        message = ""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", RuntimeWarning)  # of numpy, which would be further lines
                self.read(self.folder)
        except (InputError, ImageError) as error:
            message = str(error)
            assert message.isprintable(), message
            assert 0 < len(message) <= LONGEST_MESSAGE, message
        grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - memory) >> 10
        assert grown < MEGABYTES - 150, f"{grown} MB"  # the interpreter and the libraries take 150
        seconds = time.process_time() - start
        assert seconds < SECONDS, f"{seconds:.1f} s"
        return message


def make_readers(folder: Path) -> dict[str, Reader]:
    """All of them, by name, each in a folder of its own below `folder`."""
    made: dict[str, Reader] = {}

    def add(name: str, file: str, read: Callable[[Path], Any], *, base: Path | None = None, **options: Any) -> None:
        place = folder / name.replace(" ", "_")
        if base is None:
            place.mkdir(parents=True)
        else:
            shutil.copytree(base, place)
        good = options.pop("good", None)
        made[name] = Reader(name, place, file, (place / file).read_bytes() if good is None else good, read, **options)

    sequence, box = _sequence(folder / "sequence"), folder / "box"
    recorded = _record(sequence, box)
    example = EXAMPLES / "approach"
    rig_files = folder / "rig_files"
    rig_files.mkdir()
    save_rig(recorded.rig, rig_files)
    add("camchain", "camchain.yaml", load_rig, good=(example / "camchain.yaml").read_bytes())
    add("rig", "rig.yaml", load_rig, base=rig_files)
    add("sensor", "sensor.yaml", lambda place: read_sensors([place / "sensor.yaml"]), good=_SENSOR)
    add("target", "target.yaml", lambda place: load_target(place / "target.yaml"), base=sequence)
    add("scenario", "close.yaml", lambda place: load_scenario(place / "close.yaml"), base=EXAMPLES / "scenarios")
    add("plan", "c.yaml", lambda place: load_plan(place / "c.yaml"), base=_campaign(folder / "campaign", sequence))
    add("csv", "cam0/data.csv", lambda place: list(open_sequence(place)), base=sequence)
    add("tum", "groundtruth.tum", lambda place: read_tum(place / "groundtruth.tum"), base=sequence)
    add("solutions", "solutions.jsonl", read_solutions, base=box)
    add("poses", "poses.tum", read_solutions, base=box)
    add("box memory", "memory.json", _replayed, base=box)
    add("box frames", "frames.csv", _replayed, base=box)
    add("box solutions", "solutions.jsonl", _replayed, base=box)
    add("box digests", "SHA256SUMS", replay, base=box)
    for ending, data in _storages(folder, recorded.rig).items():
        add(f"opencv {ending}", f"a.{ending}", _file_reader(load_opencv, f"a.{ending}"), good=data)
    for ending, data in _LISTS.items():
        add(f"list {ending}", f"l.{ending}", _list_reader(f"l.{ending}"), good=data)
    for ending, data in _images().items():
        name = f"image.{ending}"
        add(f"image {ending}", name, _file_reader(_image, name), good=data, is_text=False)
    return made


def _sequence(folder: Path) -> Path:
    """The example's first frames."""
    example = EXAMPLES / "approach"
    for camera in ("cam0", "cam1"):
        (folder / camera / "data").mkdir(parents=True)
        images = sorted((example / camera / "data").iterdir())[:_FRAMES]
        for image in images:
            shutil.copy(image, folder / camera / "data")
        rows = "".join(f"{image.stem},{image.name}\n" for image in images)
        (folder / camera / "data.csv").write_text("#timestamp [ns],filename\n" + rows)
    for name in ("camchain.yaml", "rig.yaml", "target.yaml", "groundtruth.tum"):
        shutil.copy(example / name, folder)
    return folder


def _record(folder: Path, box: Path) -> Any:
    sequence = open_sequence(folder)
    recorder = Recorder(Navigator(sequence.rig, sequence.target), sequence.rig, sequence.target)
    for frame in sequence:
        recorder.process(frame)
    recorder.write(box)
    return sequence


def _campaign(folder: Path, sequence: Path) -> Path:
    shutil.copytree(EXAMPLES / "scenarios", folder / "scenarios")
    shutil.copytree(sequence, folder / "approach")
    (folder / "c.yaml").write_text(
        "name: c\nsequences: [approach]\nscenarios:\n- scenarios/paper.yaml\n- scenarios/box.yaml\n"
        "seeds: {first: 0, count: 3}\nfaults: [none, 'black_left:3-5', 'swapped:all dropped:1']\n"
    )
    return folder


def _replayed(box: Path) -> Any:
    """With digests that hold, for a stranger can reckon them too."""
    if (box / "memory.json").is_file():
        write_digests(box)
    return replay(box)


def _storages(folder: Path, rig: Any) -> dict[str, bytes]:
    """The rig as a FileStorage: as we write it, and as OpenCV does."""
    save_opencv(rig, folder / "a.yaml")
    made = {"yaml": (folder / "a.yaml").read_bytes()}
    source = cv2.FileStorage(str(folder / "a.yaml"), cv2.FILE_STORAGE_READ)
    for ending in ("xml", "json"):
        target = cv2.FileStorage(str(folder / f"a.{ending}"), cv2.FILE_STORAGE_WRITE)
        for key in ("image_width", "image_height"):
            target.write(key, int(source.getNode(key).real()))
        for key in ("M1", "D1", "M2", "D2", "R", "T"):
            target.write(key, source.getNode(key).mat())
        target.release()
        made[ending] = (folder / f"a.{ending}").read_bytes()
    return made


_SENSOR = b"""sensor_type: camera
T_BS:
  cols: 4
  rows: 4
  data: [0.0, -1.0, 0.0, -0.02,
         1.0, 0.0, 0.0, -0.06,
         0.0, 0.0, 1.0, 0.01,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 20
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.654, 457.296, 367.215, 248.375] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]
"""

_LISTS = {
    "xml": b'<?xml version="1.0"?>\n<opencv_storage>\n<imagelist>\n"a.png"\n"b.png"\n</imagelist>\n</opencv_storage>\n',
    "yaml": b'%YAML:1.0\n---\nimagelist:\n   - "a.png"\n   - b.png\n',
}


def _images() -> dict[str, bytes]:
    grey = np.random.default_rng(3).integers(0, 256, (24, 32)).astype(np.uint8)
    deep = np.random.default_rng(3).integers(0, 65536, (24, 32)).astype(np.uint16)
    colour = np.dstack([grey, grey.T[:24].repeat(2, 1)[:, :32], grey])
    made = {ending: cv2.imencode(f".{ending}", grey)[1].tobytes() for ending in ("png", "jpg", "tif", "bmp", "pgm")}
    made |= {f"deep.{ending}": cv2.imencode(f".{ending}", deep)[1].tobytes() for ending in ("png", "tif", "pgm")}
    made |= {f"colour.{ending}": cv2.imencode(f".{ending}", colour)[1].tobytes() for ending in ("png", "jpg", "tif")}
    made["plain.pgm"] = b"P2\n# plain\n4 3\n255\n" + b"7 " * 12
    return made


def _image(path: Path) -> None:
    image_size(path)
    read_image(path)


def _file_reader(read: Callable[[Path], Any], name: str) -> Callable[[Path], Any]:
    return lambda place: read(place / name)


def _list_reader(name: str) -> Callable[[Path], Any]:
    return lambda place: list(read_pairs(place / name))
