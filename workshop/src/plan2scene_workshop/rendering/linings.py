"""Ceilings and walls that are not plain: beams, slopes, lamp panels, panelling, office grids."""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from plan2scene.house import Room
from plan2scene.materials import Material
from plan2scene.photos.labels.palette import CEILING, WALL
from plan2scene.plans.geometry import room_polygon
from plan2scene_workshop.rendering.geometry import Colour, Geometry, Solid, box
from plan2scene_workshop.rendering.palette import linear
from plan2scene_workshop.rendering.shell import SKIRTING_DEPTH, WallFace

Tile = NDArray[np.uint8]


def grid_ceiling(rng: np.random.Generator) -> Material:
    """Return the material of an office ceiling: speckled plates in a grid of bars."""
    size, bar = 96, int(rng.integers(2, 5))
    image = np.full((size, size, 3), rng.uniform(150, 245)) + rng.normal(0, 5, 3)
    image[rng.random((size, size)) < rng.uniform(0, 0.2)] *= rng.uniform(0.4, 0.95)
    image = cv2.GaussianBlur(image, (0, 0), 0.7)
    image[:bar], image[:, :bar] = (rng.uniform(60, 250),) * 2
    tile = np.clip(image, 0, 255).astype(np.uint8)
    return Material(
        "office-grid", "plaster", "grid", tile, float(rng.choice([0.6, 0.62, 1.2])), 1.0
    )


def granite(rng: np.random.Generator) -> Tile:
    """Return a tile of polished stone with grains of four sizes, mostly grey, black or brown."""
    size, strong = 256, 0.5 if rng.random() < 0.2 else 0.15
    hue, other = rng.random(2) if strong > 0.3 else rng.uniform(0.03, 0.12, 2)
    plain = linear(hue, rng.uniform(0, strong), rng.uniform(0.15, 0.95))
    image = np.tile(255 * np.array(plain) ** (1 / 2.2), (size, size, 1))
    for sigma, amount in ((12, 0.3), (4, 0.5), (1, 1.0), (0.6, 1.0)):
        noise = cv2.GaussianBlur(rng.normal(size=(size, size)), (0, 0), sigma)
        grain = noise > np.quantile(noise, rng.uniform(0.6, 0.97))
        colour = linear(other, rng.uniform(0, strong), rng.uniform(0.05, 1))
        blend = amount * rng.uniform(0.2, 1.0)
        image[grain] *= 1 - blend
        image[grain] += blend * 255 * np.array(colour) ** (1 / 2.2)
    return np.clip(image, 3, 252).astype(np.uint8)


def panels(rng: np.random.Generator, base: Tile | None) -> Tile:
    """Return a tile of boards side by side, from the wood tile `base`, or painted."""
    size, count = 128, int(rng.choice([1, 2, 4, 8]))
    if base is None:
        colour = (
            255 * np.array(linear(rng.random(), rng.uniform(0, 0.3), rng.uniform(0.3, 1))) ** 0.45
        )
        image = np.tile(colour, (size, size, 1))
    else:
        image = cv2.resize(base, (size, size), interpolation=cv2.INTER_AREA).astype(np.float64)
    step, line = size // count, int(rng.integers(1, 4))
    for k in range(count):
        image[:, k * step : k * step + line] *= rng.uniform(0.2, 0.7)
        image[:, k * step + line : (k + 1) * step] *= rng.uniform(0.9, 1.05)
    return np.clip(image, 0, 255).astype(np.uint8)


def line_room(
    geometry: Geometry,
    room: Room,
    faces: tuple[WallFace, ...],
    rng: np.random.Generator,
    *,
    glow: str,
    panelling: str,
) -> None:
    """Add beams, a slope, lamp panels or panelling to some rooms.

    All but lamp panels have the label of the surface behind them. `glow` is the emitting material
    of lamp panels, `panelling` that of boards.
    """
    polygon = room_polygon(room)
    inside = polygon.buffer(-0.06, join_style="mitre")
    if inside.is_empty:
        return
    dull = linear(rng.uniform(0.03, 0.12), rng.uniform(0, 0.5), rng.uniform(0.15, 0.95))
    kind = rng.random()
    if kind < 0.14:
        _beams(geometry, inside, room.height, rng, panelling, dull)
    elif kind < 0.26:
        _slope(geometry, room, faces, rng)
    elif kind < 0.5:
        _lamp_panels(geometry, inside, room.height, rng, glow if rng.random() < 0.75 else "gloss")
    if rng.random() < 0.16:
        _panelling(geometry, faces, rng, panelling if rng.random() < 0.6 else "paint", dull)


def _beams(
    geometry: Geometry,
    inside: shapely.Polygon,
    height: float,
    rng: np.random.Generator,
    material: str,
    colour: Colour,
) -> None:
    """Add beams in one direction, or in both as coffers."""
    deep, wide, step = rng.uniform(0.05, 0.25), rng.uniform(0.06, 0.25), rng.uniform(0.5, 1.3)
    material = material if rng.random() < 0.6 else "paint"
    x0, z0, x1, z1 = inside.bounds
    ways = [0, 1] if rng.random() < 0.5 else [int(rng.integers(2))]
    for way in ways:
        for at in np.arange((x0, z0)[way] + step / 2, (x1, z1)[way], step):
            strip = (
                shapely.box(x0, at, x1, at + wide) if way else shapely.box(at, z0, at + wide, z1)
            )
            for part in shapely.get_parts(strip.intersection(inside)):
                a, b, c, d = part.bounds
                beam = box((a, height - deep, b), (c, height, d))
                geometry.add(material, beam, colour=colour, label=CEILING)


def _slope(
    geometry: Geometry, room: Room, faces: tuple[WallFace, ...], rng: np.random.Generator
) -> None:
    """Add the slope of a roof above a wall without openings."""
    plain = [face for face in faces if not face.openings and face.length > 1.5]
    if not plain:
        return
    face, low = plain[int(rng.integers(len(plain)))], rng.uniform(1.1, room.height - 0.4)
    reach = min(rng.uniform(0.7, 2.2), 0.7 * room_polygon(room).area / face.length)
    rise = face.height - low
    corners = [
        face.at(0, low, 0.002),
        face.at(face.length, low, 0.002),
        face.at(face.length, face.height - 0.003, reach),
        face.at(0, face.height - 0.003, reach),
    ]
    long = float(np.hypot(reach, rise))
    normal = np.array([face.plane.normal[0] * rise, -reach, face.plane.normal[1] * rise]) / long
    uv = np.array([[0, long], [face.length, long], [face.length, 0], [0, 0]], float)
    solid = Solid(np.array(corners), np.tile(normal, (4, 1)), uv, np.array([[0, 1, 2], [0, 2, 3]]))
    geometry.add(f"{room.id}/ceiling", solid, label=CEILING)


def _lamp_panels(
    geometry: Geometry,
    inside: shapely.Polygon,
    height: float,
    rng: np.random.Generator,
    material: str,
) -> None:
    """Add panels or small square lamps in rows to the ceiling; their label is other."""
    a, b = (0.6, float(rng.choice([0.15, 0.3, 0.6, 1.2])))
    a, b = (a, b) if rng.random() < 0.5 else (b, a)
    if rng.random() < 0.35:
        a = b = rng.uniform(0.08, 0.2)
    step = rng.uniform(1.3, 2.6, 2)
    x0, z0, x1, z1 = inside.bounds
    for x in np.arange(x0 + rng.uniform(0.2, 0.8), x1, step[0]):
        for z in np.arange(z0 + rng.uniform(0.2, 0.8), z1, step[1]):
            if inside.contains(shapely.box(x, z, x + a, z + b)):
                lamp = box((x, height - 0.012, z), (x + a, height - 0.002, z + b))
                geometry.add(material, lamp, colour=(0.85, 0.85, 0.85))


def _panelling(
    geometry: Geometry,
    faces: tuple[WallFace, ...],
    rng: np.random.Generator,
    material: str,
    colour: Colour,
) -> None:
    """Add boards in front of the walls, up to .7-1.3 m, 1.3-2 m, or the ceiling."""
    top = float(rng.choice([rng.uniform(0.7, 1.3), rng.uniform(1.3, 2.0), 9.0]))
    for face in faces:
        high = min(top, face.height - 0.002)
        wall = shapely.box(0.0, 0.0, face.length, high)
        holes = [
            shapely.box(o.left - 0.07, o.bottom - 0.05, o.right + 0.07, o.top + 0.07)
            for o in face.openings
        ]
        left = wall.difference(shapely.unary_union(holes))
        for a, b, c, d in _rectangles(left):
            board = box((a, b, 0.0), (c, d, SKIRTING_DEPTH + 0.004)).moved(face.frame(0))
            geometry.add(material, board, colour=colour, label=WALL)


def _rectangles(region: shapely.Geometry) -> list[tuple[float, float, float, float]]:
    """Return a region with right angles as vertical strips (x0, y0, x1, y1)."""
    corners = shapely.get_coordinates(region)
    if not len(corners):
        return []
    cuts, found = np.unique(corners[:, 0]), []
    low, high = corners[:, 1].min() - 1, corners[:, 1].max() + 1
    for a, b in pairwise(cuts):
        strip = region.intersection(shapely.box(a, low, b, high))
        found += [part.bounds for part in shapely.get_parts(strip) if part.area > 1e-6]
    return found
