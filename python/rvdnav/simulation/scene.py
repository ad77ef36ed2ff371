"""The scene as Mitsuba's: the target at rest in its frame C, cameras and lights around it."""

from __future__ import annotations

from typing import Any

import numpy as np

from rvdnav.pose.arrays import FloatArray
from rvdnav.pose.so3 import inverse_T, make_T
from rvdnav.simulation import sky
from rvdnav.simulation.lights import STRIP_SIZE_M, SUN_RADIUS_RAD, Strip, irradiance, led_radiance, led_strips, middle
from rvdnav.simulation.mesh import Material, Part, polygon
from rvdnav.simulation.scenario import Background, Scenario
from rvdnav.simulation.solids import printed_parts
from rvdnav.simulation.spacecraft import bracket_parts, satellite_parts
from rvdnav.simulation.textures import Rng, wall

_SUN_DISTANCE_M = 200.0
_WALL_SIZE_M = (9.0, 6.75)


def target_parts(scenario: Scenario, rng: Rng) -> list[Part]:
    """The target's own parts, in C: bracket and satellite, or a printed solid."""
    bracket = scenario.target.bracket
    if bracket is None:
        return printed_parts(scenario.target, rng)
    return [*bracket_parts(bracket, scenario.target.edge_radius, rng), *satellite_parts(bracket, rng)]


class SceneBuilder:
    """Scenes of one scenario, a frame at a time; the parts are built once."""

    def __init__(self, mitsuba: Any, scenario: Scenario) -> None:
        self._mi = mitsuba
        self._scenario = scenario
        rng = np.random.default_rng([scenario.seed, 0])
        self._target = [self._shape(part) for part in target_parts(scenario, rng)]
        self._wall_texture = wall(rng) if scenario.background is Background.WALL else None
        self._surroundings = mitsuba.Bitmap(_surroundings(scenario, rng)[..., None])

    def build(self, frame: int) -> Any:
        """The scene (mitsuba.Scene) of a frame, in C."""
        T_C_W = inverse_T(self._scenario.T_world_target(frame))
        lights = self._scenario.lights
        rig = self._scenario.rig
        scene: dict[str, Any] = {"type": "scene"}
        scene |= {f"target{index}": shape for index, shape in enumerate(self._target)}
        # The lamps' chances to be sampled are their parts of the light.  The surroundings are even enough to be left to
        # the rays that happen to reach them; every sample spent on them would be missing, as noise, on the lamps.
        meter = irradiance(rig, lights, self._scenario.target_middle(frame))
        rotation = make_T(T_C_W[:3, :3], np.zeros(3))
        scene["surroundings"] = {
            "type": "envmap",
            "bitmap": self._surroundings,
            "to_world": self._transform(rotation),
            "sampling_weight": 0.0 if lights.led + lights.sun > 0.0 else 1.0,
        }
        if lights.led > 0.0:
            radiance = led_radiance(rig, lights)
            for index, strip in enumerate(led_strips(rig)):
                scene[f"led{index}"] = self._led(strip, T_C_W, self._area(radiance, meter.led / 2))
        if lights.sun > 0.0:
            scene["sun"] = self._sun(T_C_W, meter.sun)
        if self._wall_texture is not None:
            scene["wall"] = self._wall(T_C_W)
        return self._mi.load_dict(scene)

    def _led(self, strip: Strip, T_C_W: FloatArray, emitter: dict[str, Any]) -> dict[str, Any]:
        half = np.diag([STRIP_SIZE_M[0] / 2, STRIP_SIZE_M[1] / 2, 1.0])
        T = T_C_W @ make_T(strip.axes, strip.center) @ make_T(half, np.zeros(3))
        return {"type": "rectangle", "to_world": self._transform(T), "emitter": emitter}

    def _sun(self, T_C_W: FloatArray, weight: float) -> dict[str, Any]:
        """A disc of the sun's true angular size, so that shadows have their penumbra."""
        towards = T_C_W[:3, :3] @ self._scenario.lights.towards_sun_W
        helper = np.eye(3)[np.argmin(np.abs(towards))]
        across = np.cross(helper, towards) / np.linalg.norm(np.cross(helper, towards))
        axes = np.stack([across, np.cross(-towards, across), -towards], axis=1)
        radius = _SUN_DISTANCE_M * np.tan(SUN_RADIUS_RAD)
        T = make_T(axes * (radius, radius, 1.0), _SUN_DISTANCE_M * towards)
        radiance = self._scenario.lights.sun / (np.pi * np.sin(SUN_RADIUS_RAD) ** 2)
        return {"type": "disk", "to_world": self._transform(T), "emitter": self._area(radiance, weight)}

    def _wall(self, T_C_W: FloatArray) -> Any:
        rig = self._scenario.rig
        axes = T_C_W[:3, :3] @ rig.R_world_rect
        center = T_C_W[:3, :3] @ middle(rig) + T_C_W[:3, 3] + self._scenario.wall_distance * axes[:, 2]
        x, y = np.multiply(_WALL_SIZE_M, 0.5)
        corners = [center + a * axes[:, 0] + b * axes[:, 1] for a, b in ((-x, -y), (-x, y), (x, y), (x, -y))]
        assert self._wall_texture is not None
        mesh = polygon(corners, [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)])
        return self._shape(Part(mesh, Material(self._wall_texture)))

    def _shape(self, part: Part) -> Any:
        mi = self._mi
        properties = mi.Properties()
        properties["bsdf"] = mi.load_dict(self._bsdf(part.material))
        mesh = part.mesh
        shape = mi.Mesh(
            "part",
            len(mesh.vertices),
            len(mesh.triangles),
            has_vertex_texcoords=True,
            has_vertex_normals=mesh.smooth,
            props=properties,
        )
        parameters = mi.traverse(shape)
        for name, values, kind in (
            ("vertex_positions", mesh.vertices, np.float32),
            ("vertex_texcoords", mesh.uv, np.float32),
            ("faces", mesh.triangles, np.uint32),
        ):
            parameters[name] = type(parameters[name])(np.ravel(values).astype(kind))
        parameters.update()
        if mesh.smooth:
            shape.recompute_vertex_normals()
        return shape

    def _bsdf(self, material: Material) -> dict[str, Any]:
        if isinstance(material.reflectance, float):
            reflectance = self._grey(material.reflectance)
        else:
            # Mitsuba's v points up an image; here the first row is at v = 0.
            bitmap = self._mi.Bitmap(np.ascontiguousarray(material.reflectance[::-1, :, None]))
            reflectance = {"type": "bitmap", "bitmap": bitmap, "raw": True}
        if material.roughness is None:
            surface: dict[str, Any] = {"type": "diffuse", "reflectance": reflectance}
        else:
            surface = {
                "type": "roughconductor",
                "material": "none",
                "distribution": "ggx",
                "alpha": material.roughness,
                "specular_reflectance": reflectance,
            }
        return {"type": "twosided", "surface": surface}

    def _area(self, radiance: float, weight: float) -> dict[str, Any]:
        return {"type": "area", "radiance": self._grey(radiance), "sampling_weight": weight}

    def _transform(self, T: FloatArray) -> Any:
        return self._mi.ScalarTransform4f(T)

    @staticmethod
    def _grey(value: float) -> dict[str, Any]:
        return {"type": "rgb", "value": [float(value)] * 3}


def _surroundings(scenario: Scenario, rng: Rng) -> FloatArray:
    """Radiance (h, w) from all around, in W: ambient light from the chaser's side or everywhere, and the Earth."""
    lights = scenario.lights
    directions = sky.map_directions()
    radiance = np.full(sky.MAP_SHAPE, lights.ambient / np.pi)
    if scenario.background is Background.WALL:
        return radiance
    # What the cameras see past the target must stay dark.
    radiance[directions @ scenario.rig.R_world_rect[:, 2] > 0.0] = 0.0
    if scenario.background is Background.EARTH:
        sun = max(lights.sun, lights.led) / np.pi
        radiance += sun * sky.earth(directions, scenario.nadir_W, lights.towards_sun_W, rng)
    return radiance
