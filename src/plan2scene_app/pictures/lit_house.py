"""house_lit.glb: the house with its light baked into unlit textures (KHR_materials_unlit).

Every surface gets one image: its texture times its light (:mod:`.baked_light`). Any viewer, also on
a phone, can show it without computing light.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from plan2scene.colour import linear_to_srgb, srgb_to_linear
from plan2scene.house import House, SurfaceKey
from plan2scene.images import image_from_bytes, jpeg_bytes
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.glb import write_glb
from plan2scene.mesh.parts import MeshPart
from plan2scene.mesh.texture_files import TileTexture, textured
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.plans.surface_areas import Area, surface_areas
from plan2scene_app.pictures.baked_light import Light, bake_light, compressed, mean_colours


@dataclass(frozen=True)
class LitSettings:
    """Settings of images of surfaces with baked light, about as sharp as a phone shows them."""

    px_per_m: float = 128.0
    most_px: int = 4096  #: largest width and height of an image
    texel_m: float = 0.08  #: side of the light's texels
    quality: int = 88  #: of JPEG


SETTINGS = LitSettings()
_BAND = 512  # number of image rows that are processed at once


def build_lit_house(
    scene_json: str | Path,
    textures_dir: str | Path,
    glb: str | Path,
    *,
    house_id: str,
    objects: bool = True,
) -> None:
    """Write a house with baked light as GLB.

    Parameters
    ----------
    scene_json, textures_dir, house_id, objects
        As in :func:`plan2scene.mesh.build.build_house`.
    glb : path
    """
    house, textures = textured(textures_dir, read_scene_json(scene_json, house_id))
    house = house if objects else replace(house, icons=())
    parts = assemble(house).parts
    light = bake_light(house, parts, mean_colours(textures), SETTINGS.texel_m)
    if light is None:
        logging.getLogger("plan2scene").warning("house %s: no light to bake", house_id)
        write_glb(house, textures, glb, parts)
        return
    lit = lit_textures(house, parts, textures, light)
    write_glb(house, lit, glb, [lit_part(part, light) for part in parts], unlit=True)


def lit_textures(
    house: House,
    parts: Sequence[MeshPart],
    textures: Mapping[SurfaceKey, TileTexture],
    light: Light,
) -> dict[SurfaceKey, TileTexture]:
    """Return an image of each surface: its texture times its light."""
    areas = surface_areas(house)
    lit_by_key: dict[SurfaceKey, TileTexture] = {}
    for key in house.surface_keys():
        if key in textures and key in areas:
            lit_parts = [
                part for part in parts if part.surface == key and part.name in light.charts
            ]
            lit_by_key[key] = _lit(textures[key], areas[key], lit_parts, light)
    return lit_by_key


def _lit(tile: TileTexture, area: Area, parts: Sequence[MeshPart], light: Light) -> TileTexture:
    """Return one surface's image: its texture times its light."""
    scale = min(SETTINGS.px_per_m, SETTINGS.most_px / max(area.size))
    width, height = (max(2, round(side * scale)) for side in area.size)
    shade = _shade(area, (height, width), scale, parts, light)
    picture = srgb_to_linear(image_from_bytes(tile.image)).astype(np.float32)
    texels = picture.shape[1] / tile.sides_m[0]
    if texels > scale:
        size = (round(picture.shape[1] * scale / texels), round(picture.shape[0] * scale / texels))
        picture = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
    pixels = np.empty((height, width, 3), np.uint8)
    for top in range(0, height, _BAND):
        rows, columns = np.mgrid[top : min(top + _BAND, height), :width]
        uv = np.stack([columns, rows], axis=-1) + 0.5
        turns = tile.turns(uv / scale + np.array(area.low))
        at = ((turns - np.floor(turns)) * picture.shape[1::-1] - 0.5).astype(np.float32)
        colour = cv2.remap(
            picture, at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP
        )
        pixels[top : top + _BAND] = developed(colour * shade[top : top + _BAND])
    return replace(
        tile,
        origin_m=area.low,
        jpeg=jpeg_bytes(pixels, quality=SETTINGS.quality),
        extent_m=(width / scale, height / scale),
        pattern="",
    )


def _shade(
    area: Area, size: tuple[int, int], scale: float, parts: Sequence[MeshPart], light: Light
) -> np.ndarray:
    """Return the light at a surface image's pixels, (h, w, 3) float32; the mean off the parts."""
    shade = np.full((*size, 3), np.nan, np.float32)
    for part in parts:
        uv = np.asarray(part.uv)
        low = np.floor((uv.min(axis=0) - area.low) * scale).astype(int)
        high = np.ceil((uv.max(axis=0) - area.low) * scale).astype(int) + 1
        rows, columns = np.mgrid[
            max(low[1], 0) : min(high[1], size[0]), low[0] : min(high[0], size[1])
        ]
        at = np.stack([columns, rows], axis=-1) + 0.5
        texels = light.charts[part.name].texels(at / scale + np.array(area.low)) - 0.5
        x, y = (texels[..., k].astype(np.float32) for k in (0, 1))
        shade[rows, columns] = cv2.remap(light.image, x, y, cv2.INTER_LINEAR)
    known = np.isfinite(shade[..., 0])
    shade[~known] = shade[known].mean(axis=0) if known.any() else 1.0
    return shade


def developed(linear: np.ndarray) -> np.ndarray:
    """Return linear values as uint8 sRGB, with compressed highlights."""
    steps = np.clip(compressed(linear) * 4095, 0, 4095).astype(np.uint16)
    return np.asarray(_SRGB[steps])


_SRGB = np.round(255 * linear_to_srgb(np.arange(4096) / 4095)).astype(np.uint8)


def lit_part(part: MeshPart, light: Light) -> MeshPart:
    """Return a part with its vertex colours times the light of walls near it; others unchanged."""
    if part.colours is None:
        return part
    linear = srgb_to_linear(part.colours) * light.of_plain(part)
    return replace(part, colours=developed(linear))
