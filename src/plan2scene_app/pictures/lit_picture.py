"""Pictures from inside a house: with its baked light, or by path tracing."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.colour import linear_to_srgb
from plan2scene.house import House, SurfaceKey
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.texture_files import TileTexture
from plan2scene_app.pictures.baked_light import (
    Light,
    bake_light,
    compressed,
    even_light,
    mean_colours,
)
from plan2scene_app.pictures.path_tracing import TracedScene, load_mitsuba
from plan2scene_app.pictures.renderer import Triangles, sample

#: Function that draws a camera's picture, (height, width, 3) uint8 sRGB.
Painter = Callable[[Camera], np.ndarray]


@dataclass(frozen=True)
class PictureSettings:
    """How pictures from inside a house are drawn."""

    finer: float = 1.25  #: pictures are drawn this many times larger and averaged down
    texel_m: float = 0.2  #: side of a texel of the baked light, metres
    sky: tuple[float, float, float] = (0.55, 0.70, 0.95)  #: linear RGB overhead
    horizon: tuple[float, float, float] = (0.90, 0.93, 0.97)  #: linear RGB
    ground: tuple[float, float, float] = (0.38, 0.40, 0.33)  #: linear RGB below the horizon
    haze: float = 0.12  #: sine of the angle over which the ground fades into the horizon
    tint: float = 0.15  #: share of the light's colour (log) that is kept: eyes balance white
    white: float = 0.86  #: linear value of a white surface in a picture's median light
    #: Largest light (95th percentile) over the median: a picture with more is exposed darker. It is
    #: 1.3 to 1.9 in 66 pictures of the demo, 3.7 in a dark corridor whose lit end was burnt.
    brightest: float = 2.0


SETTINGS = PictureSettings()


def painter_of(
    house: House,
    textures: Mapping[SurfaceKey, TileTexture],
    parts: Sequence[MeshPart],
    *,
    traced: bool = False,
    light: Light | None = None,
) -> Painter:
    """Return a function that draws a house from inside.

    If `traced` and Mitsuba is installed, it uses path tracing (:mod:`.path_tracing`). Otherwise it
    uses `light`, which is baked if it is not given; if it cannot be baked, the light is even.
    """
    mi = load_mitsuba() if traced else None
    if mi is not None:
        scene = TracedScene(mi, house, parts, textures)
        return lambda camera: _developed(scene.draw(_larger(camera)), camera)
    light = light or bake_light(house, parts, mean_colours(textures), SETTINGS.texel_m)
    baked = _LitTriangles(parts, textures, light or even_light())
    return lambda camera: _developed(baked.draw(_larger(camera)), camera)


def _larger(camera: Camera) -> Camera:
    return camera.resized(
        (round(camera.height * SETTINGS.finer), round(camera.width * SETTINGS.finer))
    )


class _LitTriangles:
    """The opaque triangles of a house with their light; the sky is seen through the windows."""

    def __init__(
        self,
        parts: Sequence[MeshPart],
        textures: Mapping[SurfaceKey, TileTexture],
        light: Light,
    ) -> None:
        opaque = [part for part in parts if part.material != "glass"]
        self.triangles, self.light = Triangles.of(opaque, textures), light
        lights, uv = [], []
        for part in opaque:
            faces, chart = part.mesh.faces, light.charts.get(part.name)
            lights.append(
                np.full((*faces.shape, 3), np.nan) if chart else light.of_plain(part)[faces]
            )
            uv.append(light.uv(part)[faces] if chart else np.zeros((len(faces), 3, 2)))
        self.plain, self.light_uv = np.concatenate(lights), np.concatenate(uv)

    def draw(self, camera: Camera) -> np.ndarray:
        """Return a picture, (h, w, 3) float32 linear RGB, exposed by its light."""
        fragments = self.triangles.visible(camera, np.ones(len(self.plain), dtype=bool))
        upward = directions(camera)[..., 1:2]
        horizon, sky, ground = map(np.array, (SETTINGS.horizon, SETTINGS.sky, SETTINGS.ground))
        image = horizon + (sky - horizon) * np.clip(upward, 0, 1)
        image += (ground - horizon) * np.clip(-upward / SETTINGS.haze, 0, 1)
        image = image.astype(np.float32)
        light = fragments.at(self.plain)
        baked = np.isnan(light[:, 0])
        at = fragments.at(self.light_uv)[baked]
        light[baked] = sample([self.light.image], at, np.ones(len(at)))
        light = np.maximum(light, 0.0)  # it is extrapolated at the edges of thin faces
        grey = np.maximum(light.mean(axis=1, keepdims=True), 1e-6)
        light = grey * (light / grey) ** SETTINGS.tint
        light *= SETTINGS.white / _usual(light)
        image.reshape(-1, 3)[fragments.pixels] = self.triangles.looks(camera, fragments) * light
        return image


def _usual(light: np.ndarray) -> float:
    """Return the light by which a picture of lights (n, 3) is exposed: about the median."""
    if not len(light):
        return 1.0
    bright = float(np.quantile(light.mean(axis=1), 0.95))
    return max(float(np.median(light)), bright / SETTINGS.brightest, 1e-6)


def directions(camera: Camera, step: int = 1) -> np.ndarray:
    """Return the unit directions (rows, columns, 3) of every `step`-th pixel's ray."""
    rows, columns = np.mgrid[step // 2 : camera.height : step, step // 2 : camera.width : step]
    return camera.rays(np.stack([columns, rows], axis=-1))


def _developed(image: np.ndarray, camera: Camera) -> np.ndarray:
    """Return a linear picture as uint8 sRGB at the camera's size, with compressed highlights."""
    image = cv2.resize(image, (camera.width, camera.height), interpolation=cv2.INTER_AREA)
    return np.asarray(np.round(linear_to_srgb(compressed(image).clip(0, 1)) * 255).astype(np.uint8))
