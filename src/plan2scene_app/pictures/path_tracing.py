"""Pictures of rooms by path tracing (Mitsuba 3, the extra `render`): lamps, sky in the windows.

Every part is a diffuse mesh with its texture or vertex colours. Windows emit the light of the sky,
and a room's lamp is a small sphere. Each pixel averages a few paths only; therefore the light is
smoothed, separately from the surfaces' colours, which stay sharp.
"""

from __future__ import annotations

import importlib
import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.colour import srgb_to_linear
from plan2scene.house import House, SurfaceKey
from plan2scene.images import image_from_bytes
from plan2scene.mesh.baking import LAMP, lamp_position
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.texture_files import UNTEXTURED, TileTexture
from plan2scene.plugins import pip_command
from plan2scene_app.pictures.baked_light import SKY

#: Mitsuba's variants in order of preference: the second is slower but needs nothing else installed.
VARIANTS = ("llvm_ad_rgb", "scalar_rgb")


@dataclass(frozen=True)
class TracingSettings:
    """How rooms are traced and smoothed: with few paths, so that a room takes seconds."""

    samples: int = 24  #: paths per pixel
    depth: int = 7  #: largest depth of a path (Mitsuba's `max_depth`)
    roulette: int = 4  #: depth from which Russian roulette may end a path
    lamp_radius_m: float = 0.09  #: radius of a lamp's sphere
    lamp_radiance: float = 28.0  #: in multiples of white
    sky_radiance: float = 2.2  #: in multiples of white
    middle: float = 0.36  #: median linear value of a picture (bright lamps hardly change a median)
    least_albedo: float = 0.02  #: pixels with a lower albedo (lamps, sky) are not divided by it
    steps: tuple[int, ...] = (1, 2, 4, 8)  #: step of each pass of the wavelet filter, pixels
    same_normal: float = 0.1  #: squared difference of unit normals that lowers a weight to 1/e
    same_place: float = 0.02  #: metres off the plane, near the scene's middle, that lower it to 1/e
    glare: float = 3.0  #: a pixel's light is limited to this times its 5 x 5 median (fireflies)


SETTINGS = TracingSettings()


_KERNEL = (3 / 8, 1 / 4, 1 / 16)


def load_mitsuba() -> Any | None:
    """Return Mitsuba with a variant that works here; None, with a warning, if there is none."""
    try:
        mi = importlib.import_module("mitsuba")
    except ImportError:
        logging.getLogger("plan2scene").warning(
            "no Mitsuba here (%s): rooms are drawn by baked light",
            pip_command("plan2scene[render]"),
        )
        return None
    for name in VARIANTS:
        try:
            mi.set_variant(name)
            if name.startswith("llvm"):  # test whether LLVM's library is there
                drjit = importlib.import_module("drjit")
                drjit.eval(drjit.llvm.Float(1.0) + drjit.llvm.Float([1.0, 2.0]))
        except (ImportError, RuntimeError, AttributeError):
            continue
        return mi
    logging.getLogger("plan2scene").warning("no variant of Mitsuba works: rooms by baked light")
    return None


class TracedScene:
    """A house as a Mitsuba scene, which can be drawn from any number of cameras."""

    def __init__(
        self,
        mi: Any,
        house: House,
        parts: Sequence[MeshPart],
        textures: Mapping[SurfaceKey, TileTexture],
    ) -> None:
        self._mi = mi
        scene: dict[str, Any] = {"type": "scene"}
        for number, part in enumerate(parts):
            scene[f"part{number}"] = self._mesh(f"part{number}", part, textures)
        for number, room in enumerate(house.rooms):
            if not room.open_air:
                scene[f"lamp{number}"] = self._lamp(lamp_position(house, room.id))
        scene["sky"] = {
            "type": "constant",
            "radiance": self._rgb(SETTINGS.sky_radiance * SKY / SKY.max()),
        }
        self._scene = mi.load_dict(scene, parallel=False)
        path = {"type": "path", "max_depth": SETTINGS.depth, "rr_depth": SETTINGS.roulette}
        aovs = "al:albedo,no:sh_normal,po:position"
        self._integrator = mi.load_dict({"type": "aov", "aovs": aovs, "img": path})

    def draw(self, camera: Camera) -> np.ndarray:
        """Return a picture, (h, w, 3) float32 linear RGB, of a fixed median. Deterministic."""
        sampler = {"type": "independent", "sample_count": SETTINGS.samples}
        image = self._mi.render(
            self._scene,
            sensor=sensor(self._mi, camera, sampler),
            integrator=self._integrator,
            spp=SETTINGS.samples,
            seed=0,
        )
        data = np.nan_to_num(np.asarray(image, dtype=np.float32))
        radiance, albedo, normal, place = (data[..., k : k + 3] for k in (0, 3, 6, 9))
        image = smoothed(radiance, albedo, normal, place)
        return image * (SETTINGS.middle / max(float(np.median(image)), 1e-6))

    def _rgb(self, colour: np.ndarray) -> dict[str, Any]:
        return {"type": "rgb", "value": [float(value) for value in colour]}

    def _lamp(self, place: np.ndarray) -> dict[str, Any]:
        radiance = self._rgb(SETTINGS.lamp_radiance * LAMP)
        return {
            "type": "sphere",
            "center": [float(value) for value in place],
            "radius": SETTINGS.lamp_radius_m,
            "emitter": {"type": "area", "radiance": radiance},
        }

    def _mesh(self, name: str, part: MeshPart, textures: Mapping[SurfaceKey, TileTexture]) -> Any:
        """Return a part as a Mitsuba mesh; a pane emits the light of the sky."""
        mi = self._mi
        tile = None if part.surface is None else textures.get(part.surface)
        properties = mi.Properties()
        look: dict[str, Any]
        if part.material == "glass":
            look = self._rgb(np.zeros(3))
            sky = {"type": "area", "radiance": self._rgb(SETTINGS.sky_radiance * SKY / SKY.max())}
            properties["mesh_emitter"] = mi.load_dict(sky)
        elif tile is not None and part.uv is not None:
            data = srgb_to_linear(image_from_bytes(tile.image)).astype(np.float32)
            look = {"type": "bitmap", "bitmap": mi.Bitmap(data), "raw": True}
        elif part.colours is not None:
            look = {"type": "mesh_attribute", "name": "vertex_color"}
        else:
            surface = "wall" if part.surface is None else part.surface.kind
            look = self._rgb(srgb_to_linear(np.array(UNTEXTURED[surface], np.uint8)))
        bsdf = {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": look}}
        properties["mesh_bsdf"] = mi.load_dict(bsdf)
        vertices, faces = part.mesh.vertices, part.mesh.faces
        mesh = mi.Mesh(name, len(vertices), len(faces), has_vertex_texcoords=True, props=properties)
        values = mi.traverse(mesh)
        values["vertex_positions"] = np.ascontiguousarray(vertices, np.float32).ravel()
        values["faces"] = np.ascontiguousarray(faces, np.uint32).ravel()
        uv = np.zeros((len(vertices), 2))
        if tile is not None and part.uv is not None:
            uv = tile.turns(part.uv)
        values["vertex_texcoords"] = uv.astype(np.float32).ravel()
        values.update()
        if part.colours is not None:
            linear = srgb_to_linear(part.colours).astype(np.float32)
            mesh.add_attribute("vertex_color", 3, linear.ravel())
        return mesh


def sensor(mi: Any, camera: Camera, sampler: Mapping[str, Any]) -> Any:
    """Return a Mitsuba pinhole sensor for a camera; `sampler` is the sampler's description."""
    to_world = np.eye(4)
    right, down, ahead = camera.matrix
    to_world[:3, :3] = np.stack([-right, -down, ahead], axis=1)
    to_world[:3, 3] = camera.position
    film = {
        "type": "hdrfilm",
        "height": camera.height,
        "width": camera.width,
        "rfilter": {"type": "box"},
        "pixel_format": "rgb",
        "component_format": "float32",
    }
    return mi.load_dict(
        {
            "type": "perspective",
            "fov": float(np.degrees(2 * math.atan(camera.width / 2 / camera.focal_px))),
            "fov_axis": "x",
            "near_clip": 0.02,
            "far_clip": 200.0,
            "to_world": mi.ScalarTransform4f(to_world.tolist()),
            "film": film,
            "sampler": dict(sampler),
        }
    )


def smoothed(
    radiance: np.ndarray, albedo: np.ndarray, normal: np.ndarray, place: np.ndarray
) -> np.ndarray:
    """Denoise a picture (h, w, 3): smooth the light within surfaces, keep their colours sharp.

    Radiance over albedo is filtered by an edge-avoiding wavelet (Dammertz et al. 2010).

    Parameters
    ----------
    radiance, albedo : (h, w, 3) float32
        Linear RGB.
    normal, place : (h, w, 3) float32
        Normal and position of the surface at each pixel, in world axes and metres.
    """
    lit = albedo.max(axis=2) > SETTINGS.least_albedo
    shade = np.where(lit[..., None], albedo, 1.0)
    light = np.minimum(radiance / shade, 8.0).astype(np.float32)
    grey = light.mean(axis=2)
    most = (
        SETTINGS.glare * cv2.medianBlur(np.where(lit, grey, 0).astype(np.float32), 5)
        + SETTINGS.least_albedo
    )
    light = np.where(
        lit[..., None], light * np.minimum(1, most / np.maximum(grey, 1e-6))[..., None], light
    )
    near = SETTINGS.same_place * np.maximum(
        np.linalg.norm(place - place.mean(axis=(0, 1)), axis=2), 1.0
    )
    for step in SETTINGS.steps:
        total, weights = light * _KERNEL[0] ** 2, np.full(lit.shape, _KERNEL[0] ** 2, np.float32)
        for dy in range(-2, 3):
            for dx in range(-2, 3):
                if dx or dy:
                    shifted = [
                        _shifted(a, step * dy, step * dx) for a in (light, normal, place, lit)
                    ]
                    weight = _KERNEL[abs(dy)] * _KERNEL[abs(dx)] * (shifted[3] == lit)
                    turned = ((shifted[1] - normal) ** 2).sum(axis=2)
                    off = np.abs(((shifted[2] - place) * normal).sum(axis=2)) / near
                    weight = weight * np.exp(-turned / SETTINGS.same_normal - off)
                    total, weights = total + weight[..., None] * shifted[0], weights + weight
        light = np.asarray(total / weights[..., None], dtype=np.float32)
    return np.asarray(light * shade, dtype=np.float32)


def _shifted(image: np.ndarray, dy: int, dx: int) -> np.ndarray:
    """Return an image shifted by whole pixels; border pixels are repeated."""
    matrix = np.array([[1, 0, -dx], [0, 1, -dy]], np.float32)
    size = image.shape[1::-1]
    values = image.astype(np.float32)
    return np.asarray(
        cv2.warpAffine(
            values, matrix, size, flags=cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE
        )
    )
