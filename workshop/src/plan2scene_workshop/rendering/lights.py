"""Light of a scene: the view outside the windows, and lamps with their colours and strengths."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import shapely
from numpy.typing import NDArray

from plan2scene.house import Room
from plan2scene.plans.geometry import room_polygon
from plan2scene_workshop.rendering.geometry import (
    Geometry,
    Solid,
    box,
    cylinder,
    lathe,
    merge,
    superquadric,
)
from plan2scene_workshop.rendering.tracer import Finish

#: Daylight: radiance of the windows per (floor area / window area), and its range. With it, or
#: with lamps at full strength, white walls of a room have a radiance of about 1.
DAY_PER_AREA = 2.2
DAY_RADIANCE = (5.0, 60.0)
#: Elevation of the panorama's first row, radians.
PANORAMA_TOP = 0.9


@dataclass(frozen=True)
class LightPlan:
    """Light of a photographed room; colours are linear RGB of mean 1."""

    sky: float  #: radiance of the windows
    lamps: float  #: strength of the lamps; 1 is enough without windows
    sky_colour: tuple[float, float, float]
    lamp_colour: tuple[float, float, float]


def black_body(kelvin: float) -> tuple[float, float, float]:
    """Return linear sRGB with mean 1 of a black body between 2000 and 12000 K.

    Piecewise linear between values of the Planckian locus (rounded).
    """
    at = [2000, 2700, 3500, 4500, 5500, 6500, 8000, 12000]
    table = np.array(
        [
            [2.05, 0.8, 0.15],
            [1.72, 0.93, 0.35],
            [1.43, 1.0, 0.57],
            [1.2, 1.03, 0.77],
            [1.06, 1.02, 0.92],
            [0.98, 1.0, 1.02],
            [0.9, 0.99, 1.11],
            [0.79, 0.96, 1.25],
        ]
    )
    red, green, blue = (float(np.interp(kelvin, at, table[:, c])) for c in range(3))
    return (red, green, blue)


def draw_light(rng: np.random.Generator, floor: float, windows: float) -> LightPlan:
    """Draw the light: by day, by day with lamps, or in the evening; lamps if there is no window.

    `floor` and `windows` are areas in square metres. A photographer exposes for the room, so
    smaller windows appear brighter.
    """
    day = float(np.clip(DAY_PER_AREA * floor / max(windows, 0.1), *DAY_RADIANCE))
    lamp_colour = black_body(float(rng.uniform(2700, 5000)))
    evening = rng.random() < 0.12
    sky_colour = black_body(float(rng.uniform(5500, 7600)))
    if windows == 0.0:
        return LightPlan(0.05 if evening else 10.0, 1.0, sky_colour, lamp_colour)
    if evening:
        sky_colour = black_body(float(rng.uniform(8000, 12000)))
        return LightPlan(float(rng.uniform(0.03, 0.3)), 1.0, sky_colour, lamp_colour)
    lamps = 0.0 if rng.random() < 0.35 else float(rng.uniform(0.2, 1.0))
    return LightPlan(day * float(rng.uniform(0.7, 1.4)), lamps, sky_colour, lamp_colour)


def view_outside(rng: np.random.Generator) -> NDArray[np.float32]:
    """Return the view outside: a blurred panorama (256, 1024, 3) of linear RGB, sky about 1.

    Columns are headings over 360 degrees, rows are elevations from :data:`PANORAMA_TOP` down to
    its negative. It shows sky above, trees and houses on the horizon, ground below.
    """
    height, width = 256, 1024
    y = np.linspace(0, 1, height)[:, None, None]
    blue = np.array([rng.uniform(0.5, 1.0), rng.uniform(0.75, 1.0), 1.0])
    image = np.broadcast_to(blue + (1 - blue) * np.minimum(2 * y, 1), (height, width, 3)).copy()
    horizon = height // 2 + int(rng.integers(0, 12))
    for _ in range(int(rng.integers(25, 70))):
        x, top = int(rng.integers(0, width)), horizon - int(rng.integers(5, 70))
        if rng.random() < 0.6:
            colour = np.array([0.5, 0.75, 0.3]) * rng.uniform(0.08, 0.4)
            radius = int(rng.integers(8, 30))
            cv2.circle(image, (x, top + radius), radius, colour.tolist(), -1)
            cv2.rectangle(image, (x - 2, top + radius), (x + 2, horizon), colour.tolist(), -1)
        else:
            colour = np.array([1, 0.93, 0.85]) * rng.uniform(0.15, 0.8)
            right = x + int(rng.integers(20, 90))
            cv2.rectangle(image, (x, top), (right, height), colour.tolist(), -1)
    image[horizon:] *= 0.5
    image[horizon:] += np.array([0.8, 0.95, 0.6]) * rng.uniform(0.05, 0.25)
    return cv2.GaussianBlur(image, (0, 0), 1.5).astype(np.float32)


def add_balcony(
    panorama: NDArray[np.float32],
    floor: NDArray[np.uint8],
    wall: NDArray[np.uint8],
    rng: np.random.Generator,
) -> NDArray[np.float32]:
    """Return a panorama with a balcony in front: floor and parapet or bars, of albedo tiles."""
    rows, columns = panorama.shape[:2]
    elevation = PANORAMA_TOP * (1 - 2 * np.arange(rows)[:, None] / (rows - 1))
    heading = 2 * np.pi * np.arange(columns)[None] / columns
    # The balcony is a square about the camera: its edge is `far` away, its corners are farther.
    far, eye, high = rng.uniform(1.2, 3.5), 1.4, rng.uniform(0.8, 1.3)
    reach = far / np.maximum(np.abs(np.cos(heading)), np.abs(np.sin(heading)))
    along = reach * np.sin(heading - np.pi / 2 * np.round(heading / (np.pi / 2)))
    height = eye + reach * np.tan(elevation)
    down = np.minimum(eye / np.maximum(np.tan(-elevation), 1e-3), 99.0)
    ground = _tiled(floor, down * np.sin(heading), down * np.cos(heading))
    border = _tiled(wall, along + 0 * height, height)
    bars = (along / rng.uniform(0.08, 0.2)) % 1 < rng.uniform(0.1, 0.4)
    solid = (height < high) & (bars | (height > high - 0.06) | (rng.random() < 0.5))
    view = np.where(solid[..., None], border, panorama)
    view = np.where((height < 0)[..., None], ground, view) * 1.0
    return np.asarray(view, np.float32)


def _tiled(tile: NDArray[np.uint8], x: NDArray[np.float64], y: NDArray[np.float64]) -> Any:
    """Return a tile's linear colours in daylight, at points in metres; the tile is 1 m wide."""
    size = tile.shape[0]
    i, j = ((np.asarray(at) * size).astype(int) % size for at in (y, x))
    return 0.8 * (tile[i, j % tile.shape[1]] / 255.0) ** 2.2


def look_outside(
    panorama: NDArray[np.float32], position: NDArray[np.float32], camera: tuple[float, ...]
) -> NDArray[np.float32]:
    """Return the panorama (h, w, 3) in the directions from the camera to `position` (h, w, 3)."""
    ray = position - np.array(camera, np.float32)
    heading = np.arctan2(ray[..., 0], ray[..., 2]) / (2 * np.pi) + 0.5
    elevation = np.arctan2(ray[..., 1], np.hypot(ray[..., 0], ray[..., 2]))
    rows, columns = panorama.shape[:2]
    row = (0.5 - elevation / (2 * PANORAMA_TOP)) * (rows - 1)
    column = heading * (columns - 1)
    return cv2.remap(
        panorama,
        column.astype(np.float32),
        row.astype(np.float32),
        cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_REPLICATE,
    )


def sky_finish(plan: LightPlan) -> Finish:
    """Return the uniform emitter that fills the windows (the view is multiplied in afterwards)."""
    return Finish(emission=plan.sky, light=plan.sky_colour)


def lamp_finish(plan: LightPlan, room: Room, area: float) -> Finish:
    """Return the emitter of the lamps of a room with `area` square metres of lamp."""
    if plan.lamps == 0.0:
        return Finish(np.full((2, 2, 3), 225, np.uint8))
    floor = room_polygon(room).area
    radiance = plan.lamps * 0.75 * (floor + 4.0) / max(area, 1e-3)
    return Finish(emission=radiance, light=plan.lamp_colour)


def add_lamps(geometry: Geometry, room: Room, material: str, rng: np.random.Generator) -> float:
    """Add ceiling lamps of one kind; return their emitting area in square metres."""
    polygon = room_polygon(room)
    spots = _spots(polygon, 1 if polygon.area < 14 else 2)
    kind = rng.choice(["dome", "disc", "pendant", "downlights", "panel"])
    if kind == "downlights":
        spots = _grid(polygon, rng.uniform(1.1, 1.7)) or spots
    solids: list[Solid] = []
    for x, z in spots:
        solids.append(_lamp(geometry, str(kind), x, room.height, z, rng))
    merged = merge(solids)
    geometry.add(material, merged)
    a, b, c = (merged.vertices[merged.faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def _lamp(
    geometry: Geometry, kind: str, x: float, ceiling: float, z: float, rng: np.random.Generator
) -> Solid:
    """Add the holder of a lamp and return its emitting solid."""
    white = (0.8, 0.8, 0.8)
    if kind == "dome":
        radius = rng.uniform(0.14, 0.22)
        geometry.add("paint", cylinder((x, ceiling - 0.03, z), radius + 0.01, 0.03), colour=white)
        return superquadric((x, ceiling - 0.03, z), (radius, 0.08, radius), steps=(6, 14))
    if kind == "disc":
        radius = rng.uniform(0.12, 0.25)
        return cylinder((x, ceiling - 0.05, z), radius, 0.045)
    if kind == "pendant":
        drop = min(rng.uniform(0.4, 0.8), ceiling - 1.75)
        radius = rng.uniform(0.1, 0.18)
        geometry.add("paint", cylinder((x, ceiling - drop, z), 0.006, drop, 6), colour=(0.02,) * 3)
        if rng.random() < 0.5:
            shade = lathe((x, ceiling - drop, z), [(radius * 1.3, -0.12), (0.04, 0.06)])
            geometry.add("paint", shade, colour=tuple(rng.uniform(0.05, 0.8, 3)))
            return superquadric((x, ceiling - drop - 0.1, z), (0.06, 0.06, 0.06), steps=(6, 10))
        return superquadric((x, ceiling - drop - radius, z), (radius,) * 3, steps=(8, 14))
    if kind == "panel":
        half = np.array([rng.uniform(0.1, 0.35), rng.uniform(0.1, 0.35)])
        return box((x - half[0], ceiling - 0.04, z - half[1]), (x + half[0], ceiling, z + half[1]))
    geometry.add("metal", lathe((x, ceiling, z), [(0.05, -0.004), (0.06, -0.004), (0.06, 0)], 14))
    return cylinder((x, ceiling - 0.003, z), 0.045, 0.002, 12)


def _spots(polygon: shapely.Polygon, count: int) -> list[tuple[float, float]]:
    """Return the middle of the room, or two points along its longer side."""
    x0, z0, x1, z1 = polygon.bounds
    points = []
    for k in range(count):
        share = (k + 0.5) / count
        if x1 - x0 > z1 - z0:
            point = shapely.Point(x0 + (x1 - x0) * share, (z0 + z1) / 2)
        else:
            point = shapely.Point((x0 + x1) / 2, z0 + (z1 - z0) * share)
        if not polygon.buffer(-0.3).contains(point):
            point = polygon.representative_point()
        points.append((float(point.x), float(point.y)))
    return points


def _grid(polygon: shapely.Polygon, spacing: float) -> list[tuple[float, float]]:
    """Return the points of a centred grid that lie 0.35 m inside the room."""
    x0, z0, x1, z1 = polygon.bounds
    inner = polygon.buffer(-0.35)
    columns, rows = (max(1, round(side / spacing)) for side in (x1 - x0, z1 - z0))
    grid = [
        (x0 + (x1 - x0) * (i + 0.5) / columns, z0 + (z1 - z0) * (j + 0.5) / rows)
        for i in range(columns)
        for j in range(rows)
    ]
    return [point for point in grid if inner.contains(shapely.Point(*point))]
