"""The maps of a house's surfaces, from their tiles and the crops behind them."""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import cv2
import numpy as np

from plan2scene.colour import median_colour
from plan2scene.house import House, SurfaceKey
from plan2scene.images import jpeg_bytes
from plan2scene.mesh import build_parts
from plan2scene.mesh.areas import Area, areas_of
from plan2scene.paint.light import recoloured
from plan2scene.seeds import generator
from plan2scene.textures.maps.detail import Detail, detail_of_pattern, detail_of_tile
from plan2scene.textures.maps.patches import cut_patches
from plan2scene.textures.quilting import quilted
from plan2scene.textures.tiles import Tile

#: Largest side of a map, pixels: what every graphics processor takes.
MOST_PX = 4096
_QUALITY = 88  # of the JPEG files
_SPREAD = 2.5  # area of the rectangle around rooms of one material over theirs, at most


@dataclass(frozen=True)
class SurfaceMap:
    """One image for a whole surface.

    Attributes
    ----------
    jpeg : bytes
        sRGB.
    area : Area
        What it covers in the mesh's texture coordinates, metres.
    px_per_m, photo_px_per_m : float
        Its pixels per metre, and those that the photos have of the surface.
    """

    jpeg: bytes
    area: Area
    px_per_m: float
    photo_px_per_m: float

    def facts(self) -> dict[str, Any]:
        """Return what ``maps.json`` says about it."""
        return {
            "origin_m": [round(value, 6) for value in self.area.low],
            "extent_m": [round(value, 6) for value in self.area.size],
            "px_per_m": round(self.px_per_m, 2),
            "photo_px_per_m": round(self.photo_px_per_m, 2),
        }


@dataclass(frozen=True, eq=False)
class Wanted:
    """A surface that wants a map: its tile, where it lies, the material that it shares."""

    key: SurfaceKey
    tile: Tile
    area: Area
    material: str


def house_maps(
    house: House,
    tiles: Mapping[SurfaceKey, Tile],
    materials: Mapping[SurfaceKey, str],
    *,
    seed: int,
) -> dict[SurfaceKey, SurfaceMap]:
    """Return the maps of all surfaces that have faces.

    A map has the colour of its tile and is quilted from what the tile was quilted from, or from
    the tile itself.

    Parameters
    ----------
    house : House
    tiles : mapping of SurfaceKey to Tile
    materials : mapping of SurfaceKey to str
        Name of what a surface shares with other rooms, or empty.
    seed : int
        Patches are drawn by (seed, house, room, surface).
    """
    areas = areas_of(build_parts(house))
    wanted = [
        Wanted(key, tiles[key], areas[key], materials.get(key, ""))
        for key in house.surface_keys()
        if key in tiles and key in areas
    ]
    maps: dict[SurfaceKey, SurfaceMap] = {}
    details: dict[int, Detail] = {}
    for group in joined(wanted):
        detail = _detail(group[0].tile, details)
        rng = generator(seed, "maps", house.id, *group[0].key)
        maps |= dict(_maps(group, detail, rng))
    pixels = sum(m.area.square_m * m.px_per_m**2 for m in maps.values())
    _log = logging.getLogger("plan2scene")
    _log.info("house %s: %d surface maps, %.1f Mpx", house.id, len(maps), pixels / 1e6)
    return maps


def joined(wanted: Iterable[Wanted]) -> list[list[Wanted]]:
    """Return the surfaces by the map that they share: a floor or ceiling that runs on.

    They are of one material and pattern, and near each other. Walls are unrolled room by room and
    share nothing.
    """
    groups: list[list[Wanted]] = []
    for surface in wanted:
        for group in groups:
            if _runs_on(group[0], surface):
                areas = [member.area for member in (*group, surface)]
                whole = reduce(Area.union, areas)
                if whole.square_m <= _SPREAD * sum(area.square_m for area in areas):
                    group.append(surface)
                    break
        else:
            groups.append([surface])
    return groups


def _runs_on(first: Wanted, second: Wanted) -> bool:
    """Return whether two surfaces are of one material that runs through doors."""
    return (
        first.key.surface == second.key.surface != "wall"
        and first.material == second.material != ""
        and first.tile.pattern is second.tile.pattern is not None
    )


def _detail(tile: Tile, made: dict[int, Detail]) -> Detail:
    """Return the sources of a tile's map, worked out once for each pattern."""
    if tile.pattern is None:
        return detail_of_tile(tile.image, tile.size_m)
    if id(tile.pattern) not in made:
        made[id(tile.pattern)] = detail_of_pattern(tile.pattern, tile.size_m)
    return made[id(tile.pattern)]


def _maps(
    group: Sequence[Wanted], detail: Detail, rng: np.random.Generator
) -> Iterator[tuple[SurfaceKey, SurfaceMap]]:
    """Yield the maps of a group's surfaces, parts of one quilt."""
    whole = reduce(Area.union, (surface.area for surface in group))
    patches = cut_patches(detail, rng)
    if patches is None:  # no crop holds a patch, but the tile twice each way does
        tile = group[0].tile
        yield from _maps(group, detail_of_tile(tile.image, tile.size_m), rng)
        return
    scale = detail.px_per_m
    width, height = (int(np.ceil(side * scale)) for side in whole.size)
    canvas = quilted(patches, height, width, rng)
    median = median_colour(canvas[::3, ::3])
    for surface in group:
        image, area = _part(canvas, whole.low, surface.area, scale)
        image = _fitting(recoloured(image, median_colour(surface.tile.image), median))
        made = jpeg_bytes(image, quality=_QUALITY), area, image.shape[1] / area.size[0]
        yield surface.key, SurfaceMap(*made, detail.resolved)


def _part(
    canvas: np.ndarray, origin: tuple[float, float], area: Area, scale: float
) -> tuple[np.ndarray, Area]:
    """Return the pixels of a canvas that cover an area, and what they cover exactly."""
    low = [int((area.low[k] - origin[k]) * scale) for k in (0, 1)]
    size = [int(np.ceil(side * scale)) + 1 for side in area.size]
    part = canvas[low[1] : low[1] + size[1], low[0] : low[0] + size[0]]
    corner = (origin[0] + low[0] / scale, origin[1] + low[1] / scale)
    far = (corner[0] + part.shape[1] / scale, corner[1] + part.shape[0] / scale)
    return part, Area(corner, far)


def _fitting(image: np.ndarray) -> np.ndarray:
    """Return an image no larger than `MOST_PX`."""
    scale = MOST_PX / max(image.shape[:2])
    if scale >= 1.0:
        return image
    size = (max(1, int(image.shape[1] * scale)), max(1, int(image.shape[0] * scale)))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA))
