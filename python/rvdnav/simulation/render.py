"""Images as light: rays through the exact lens, path-traced."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from rvdnav.pose.arrays import BoolArray, FloatArray
from rvdnav.simulation.camera_path import CameraPath
from rvdnav.simulation.lens import RayTable
from rvdnav.simulation.lights import irradiance
from rvdnav.simulation.patterns import PixelPatterns
from rvdnav.simulation.scenario import Scenario
from rvdnav.simulation.scene import SceneBuilder
from rvdnav.simulation.spacecraft import BRACKET_REFLECTANCE

_MAX_DEPTH = 4
_CLIP_LEVELS = 6.0
"""A single ray counts no more than this many times the reference surface: a rare glint would be a speck of noise."""
_NO_LIGHT = 1e-12
_CHUNK_RAYS = 2_000_000


@attrs.frozen(eq=False)
class LightImage:
    """signal (h, w): light in units of the reference surface's, a matte one of the bracket's reflectance held towards
    the cameras at the target; not yet blurred.  sky (h, w): the part of each pixel that no object covers."""

    signal: FloatArray
    sky: FloatArray


class Renderer:
    """Renders the frames of a scenario.

    columns, rows: the part of the image that is wanted, px; all of it by default.
    """

    def __init__(
        self, mitsuba: Any, scenario: Scenario, *, columns: slice | None = None, rows: slice | None = None
    ) -> None:
        self._mi = mitsuba
        self._scenario = scenario
        self._builder = SceneBuilder(mitsuba, scenario)
        rig = scenario.rig
        columns, rows = columns or slice(0, rig.width), rows or slice(0, rig.height)
        self._first_row = rows.start
        self._tables = [RayTable(camera, columns, rows) for camera in rig.cameras]
        self._integrator = mitsuba.load_dict({"type": "path", "max_depth": _MAX_DEPTH})
        self._scene: tuple[int, Any] | None = None

    def render(self, frame: int, camera: int) -> LightImage:
        """What a camera gets in a frame: it follows from the scenario, the two numbers and Mitsuba's variant alone."""
        if self._scene is None or self._scene[0] != frame:
            self._scene = frame, self._builder.build(frame)
        scene = self._scene[1]
        place = CameraPath(self._scenario, frame, camera)
        rng = np.random.default_rng([self._scenario.seed, 1, frame, camera])
        meter = irradiance(self._scenario.rig, self._scenario.lights, self._scenario.target_middle(frame))
        reference = max(BRACKET_REFLECTANCE / np.pi * meter.total, _NO_LIGHT)
        patterns = PixelPatterns(self._scenario.samples, rng)
        table = self._tables[camera]
        height, width = table.shape
        signal, sky = np.empty(table.shape), np.empty(table.shape)
        band = max(1, _CHUNK_RAYS // (width * self._scenario.samples))
        for first in range(0, height, band):
            rows = slice(first, min(first + band, height))
            rays = table.rays(rows, *patterns.draw((rows.stop - first, width), rng))
            seed = int(rng.integers(2**31))
            origins, directions = place.rays_in_target(rays, self._first_row + first, rng)
            light, hit = self._trace(scene, origins, directions, seed)
            signal[rows] = np.minimum(light / reference, _CLIP_LEVELS).mean(axis=2)
            sky[rows] = 1.0 - hit.mean(axis=2)
        return LightImage(signal, sky)

    def _trace(
        self, scene: Any, origins: FloatArray, directions: FloatArray, seed: int
    ) -> tuple[FloatArray, BoolArray]:
        """Radiance and whether anything was hit, each (...), along rays from origins (..., 3), or from one (3,), in
        directions (..., 3), in C."""
        mi = self._mi
        shape, samples = directions.shape[:-1], directions.shape[-2]
        along, start = directions.reshape(-1, 3).T, origins.reshape(-1, 3).T
        along = along / np.sqrt(np.einsum("ij,ij->j", along, along))
        sampler = mi.load_dict({"type": "multijitter", "sample_count": samples})
        if mi.variant().startswith("scalar"):
            start = np.broadcast_to(start, along.shape)
            light, hit = self._trace_one_by_one(scene, sampler, seed, samples, along.T, start.T)
        else:
            sampler.set_samples_per_wavefront(samples)
            sampler.seed(seed, along.shape[1])
            origin = start[:, 0].tolist() if start.shape[1] == 1 else start.astype(np.float32)
            bundle = mi.Ray3f(mi.Point3f(origin), mi.Vector3f(along.astype(np.float32)))
            radiance, _, _ = self._integrator.sample(scene, sampler, bundle)
            light = np.array(radiance, dtype=np.float64).ravel()
            hit = np.array(scene.ray_test(bundle))
        return light.reshape(shape), hit.reshape(shape)

    def _trace_one_by_one(
        self, scene: Any, sampler: Any, seed: int, samples: int, directions: FloatArray, origins: FloatArray
    ) -> tuple[FloatArray, BoolArray]:
        light, hit = np.empty(len(directions)), np.empty(len(directions), dtype=bool)
        for index, (origin, direction) in enumerate(zip(origins.tolist(), directions.tolist(), strict=True)):
            if index % samples == 0:
                sampler.seed(seed + index)
            ray = self._mi.Ray3f(origin, direction)
            light[index] = self._integrator.sample(scene, sampler, ray)[0][0]  # grey: all channels are alike
            hit[index] = scene.ray_test(ray)
            sampler.advance()
        return light, hit
