"""A scenario made into a sequence folder, which appears when it is complete and not before."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from rvdnav.errors import InputError
from rvdnav.files import read_text, write_text_atomically
from rvdnav.images import ImageError, PixelArray, png_bytes, read_image
from rvdnav.rig import save_rig
from rvdnav.simulation import sky
from rvdnav.simulation.record import fingerprint, meta_text
from rvdnav.simulation.render import Renderer
from rvdnav.simulation.scenario import Background, Scenario
from rvdnav.simulation.sensor import expose, pixel_gains, point_images
from rvdnav.simulation.variant import load_mitsuba, renderer_name
from rvdnav.target_writer import save_target
from rvdnav.trajectory import write_tum
from rvdnav.yamlio import read_yaml

META = "meta.yaml"
_MARK = "fingerprint"


def simulate(
    scenario: Scenario,
    out: str | Path,
    *,
    variant: str | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> bool:
    """Render a scenario into the sequence folder `out`; False if it was there already, complete.

    Finished images are kept in `<out>.partial` beside it; run again after an interruption, it goes on where it
    stopped and gives the same bytes.  variant: of Mitsuba, by default the fastest that works here.  progress: called
    with the numbers of images finished and wanted.

    Raises InputError when `out` or the remains of an interrupted run are of something else, when either cannot be
    written, and when Mitsuba is missing.
    """
    out = Path(out)
    mitsuba = load_mitsuba(variant)
    renderer = renderer_name(mitsuba)
    mark = fingerprint(scenario, renderer)
    if _is_complete(out, mark):
        return False
    partial = out.absolute().with_name(f"{out.absolute().name}.partial")
    try:
        with _partial_folder(partial, mark):
            for camera in range(len(scenario.rig.cameras)):
                (partial / f"cam{camera}" / "data").mkdir(parents=True, exist_ok=True)
            _Producer(mitsuba, scenario, partial).run(progress)
            _write_texts(scenario, renderer, partial)
            os.rename(partial, out)
            (out / _MARK).unlink()
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {error.strerror}") from error
    return True


def _is_complete(out: Path, mark: str) -> bool:
    """Whether that run lies in `out`; anything else there is an error."""
    if not out.exists() or (out.is_dir() and not any(out.iterdir())):
        return False
    if not (out / META).is_file() or "fingerprint" not in read_yaml(out / META):
        raise InputError(f"{out}: exists and is no simulated sequence; name another folder")
    if read_yaml(out / META).text("fingerprint") != mark:
        raise InputError(f"{out}: holds a sequence of another scenario, variant or version; name another folder")
    return True


@contextmanager
def _partial_folder(partial: Path, mark: str) -> Iterator[None]:
    """Make or take up the folder of an unfinished run, for one process at a time."""
    partial.mkdir(parents=True, exist_ok=True)
    if (partial / _MARK).exists():
        if read_text(partial / _MARK).strip() != mark:
            raise InputError(f"{partial}: is an unfinished run of another scenario, variant or version; remove it")
    elif any(partial.iterdir()):
        raise InputError(f"{partial}: is in the way and no unfinished simulation; remove it")
    else:
        write_text_atomically(partial / _MARK, mark + "\n")
    with (partial / _MARK).open() as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(f"{partial}: another process is at work on it") from None
        yield


class _Producer:
    """Makes the images that are still missing."""

    def __init__(self, mitsuba: object, scenario: Scenario, folder: Path) -> None:
        self._mitsuba = mitsuba
        self._scenario = scenario
        self._folder = folder
        self._gains = [
            pixel_gains(scenario.sensor, camera, np.random.default_rng([scenario.seed, 2, index]))
            for index, camera in enumerate(scenario.rig.cameras)
        ]
        self._stars = [self._star_image(camera) for camera in range(len(scenario.rig.cameras))]

    def run(self, progress: Callable[[int, int], None]) -> None:
        images = [(f, c) for f in range(self._scenario.frames) for c in range(len(self._scenario.rig.cameras))]
        missing = [image for image in images if not self._is_there(*image)]
        progress(len(images) - len(missing), len(images))
        if not missing:
            return
        renderer = Renderer(self._mitsuba, self._scenario)
        for count, (frame, camera) in enumerate(missing, start=len(images) - len(missing) + 1):
            pixels = self._image(renderer, frame, camera)
            _write_png(self._path(frame, camera), pixels)
            progress(count, len(images))

    def _image(self, renderer: Renderer, frame: int, camera: int) -> PixelArray:
        rng = np.random.default_rng([self._scenario.seed, 3, frame, camera])
        light = renderer.render(frame, camera)
        return expose(self._scenario.sensor, light, self._stars[camera], self._gains[camera], rng)

    def _star_image(self, camera: int) -> np.ndarray:
        rig = self._scenario.rig
        if self._scenario.background is Background.WALL:
            return np.zeros((rig.height, rig.width))
        directions, brightness = sky.stars(np.random.default_rng([self._scenario.seed, 4]))
        if self._scenario.background is Background.EARTH:
            brightness = brightness * ~sky.behind_earth(directions, self._scenario.nadir_W)
        uv = rig.cameras[camera].project(directions @ rig.T_world_cam[camera][:3, :3])
        return point_images(self._scenario.sensor, uv, brightness, (rig.height, rig.width))

    def _path(self, frame: int, camera: int) -> Path:
        return self._folder / f"cam{camera}" / "data" / f"{self._scenario.timestamp_ns(frame)}.png"

    def _is_there(self, frame: int, camera: int) -> bool:
        try:
            pixels = read_image(self._path(frame, camera)).pixels
        except ImageError:
            return False
        return pixels.shape == (self._scenario.rig.height, self._scenario.rig.width)


def _write_png(path: Path, pixels: PixelArray) -> None:
    temporary = path.with_suffix(".part")
    temporary.write_bytes(png_bytes(pixels))
    os.replace(temporary, path)


def _write_texts(scenario: Scenario, renderer: str, folder: Path) -> None:
    stamps = [scenario.timestamp_ns(frame) for frame in range(scenario.frames)]
    for camera in range(len(scenario.rig.cameras)):
        rows = ["#timestamp [ns],filename", *(f"{stamp},{stamp}.png" for stamp in stamps), ""]
        write_text_atomically(folder / f"cam{camera}" / "data.csv", "\n".join(rows))
        for leftover in (folder / f"cam{camera}" / "data").glob("*.part"):
            leftover.unlink()
    save_rig(scenario.told_rig(), folder)
    save_target(scenario.told_target(), folder / "target.yaml")
    write_tum(
        folder / "groundtruth.tum",
        [(stamp, scenario.T_world_target(frame)) for frame, stamp in enumerate(stamps)],
    )
    write_text_atomically(folder / META, meta_text(scenario, renderer))
