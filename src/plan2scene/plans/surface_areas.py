"""The rectangle of texture coordinates, in metres, that one image of each surface covers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from shapely.geometry import box

from plan2scene.house import House, SurfaceKey
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.wall_sides import (
    arc_offset,
    face_ends,
    find_openings,
    railing_sides,
    reveal_quads,
    room_sides,
)

MARGIN_M = 0.05  #: Margin around a surface, metres: texture filtering takes no far side's texels


@dataclass(frozen=True)
class Area:
    """A rectangle of texture coordinates, metres: lower and upper corner (u, v)."""

    low: tuple[float, float]
    high: tuple[float, float]

    @property
    def size(self) -> tuple[float, float]:
        """Return width and height, metres."""
        return self.high[0] - self.low[0], self.high[1] - self.low[1]

    @property
    def square_m(self) -> float:
        """Return its area."""
        return self.size[0] * self.size[1]

    def union(self, other: Area) -> Area:
        """Return the least rectangle that holds both."""
        low, high = np.minimum(self.low, other.low), np.maximum(self.high, other.high)
        return Area((float(low[0]), float(low[1])), (float(high[0]), float(high[1])))


def surface_areas(house: House) -> dict[SurfaceKey, Area]:
    """Return the area of every surface that has faces; a floor's includes its thresholds.

    Texture coordinates of floors and ceilings are (x, z); of walls u runs to the right along the
    room's outline, v down from the room's height.
    """
    areas: dict[SurfaceKey, Area] = {}

    def add(key: SurfaceKey, low: tuple[float, float], high: tuple[float, float]) -> None:
        least, most = np.array(low) - MARGIN_M, np.array(high) + MARGIN_M
        area = Area((float(least[0]), float(least[1])), (float(most[0]), float(most[1])))
        areas[key] = areas[key].union(area) if key in areas else area

    for _, storey in house.storeys():
        polygons = {room.id: room_polygon(room) for room in storey.rooms}
        for room in storey.rooms:
            for surface in ("floor",) if room.open_air else ("floor", "ceiling"):
                x0, z0, x1, z1 = polygons[room.id].bounds
                add(SurfaceKey(room.id, surface), (x0, z0), (x1, z1))
        sides = room_sides(storey, polygons)
        openings = find_openings(storey, sides, polygons)
        rails = railing_sides(storey, sides, polygons)
        for side in (side for side in sides if side not in rails):
            room = storey.room(side.room_id)
            left, right = face_ends(side.frame, polygons[room.id])
            face = box(left, 0.0, right, side.wall.height).difference(openings.hole(side))
            if not face.is_empty:
                s0, y0, s1, y1 = face.bounds
                offset = arc_offset(room, side.frame)
                key = storey.wall_key(room.id, side.wall.id)
                add(key, (s0 + offset, room.height - y1), (s1 + offset, room.height - y0))
        for portal in openings.portals:
            if portal.has_threshold:
                quad = reveal_quads(portal.side.frame, portal.hole, portal.back)[3][:, [0, 2]]
                add(SurfaceKey(portal.side.room_id, "floor"), quad.min(axis=0), quad.max(axis=0))
    return areas
