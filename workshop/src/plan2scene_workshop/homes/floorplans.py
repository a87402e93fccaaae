"""Random apartments: rooms, doors, passages and windows like those of plans in listings."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import shapely

from plan2scene.house import Door, House, Opening, Point, Ring, Room, Wall
from plan2scene.plans.geometry import walls_of_rooms
from plan2scene.seeds import generator
from plan2scene_workshop.homes.layouts import OUTSIDE, GridPlan, draw_layout
from plan2scene_workshop.homes.openings import Border, Hole, draw_doors, draw_entrance, draw_windows

#: Numbers of rooms, each with its probability.
ROOM_COUNTS = {4: 0.1, 5: 0.17, 6: 0.2, 7: 0.19, 8: 0.15, 9: 0.11, 10: 0.08}
HEIGHT_M = (2.3, 3.0)
LEAST_WIDTH_M = 0.75  #: of every part of a room
_TRIES = 200


def generate_house(house_id: str, seed: int) -> House:
    """Return a random apartment of 4-10 rooms; the same arguments give the same house.

    Rooms partition the footprint (no gaps), every room can be reached through doors or passages
    and one door leads outside. There is one wall per room and polygon edge; an opening between
    two rooms is cut into both rooms' walls under one id.
    """
    rng = generator(seed, "plan", house_id)
    counts = np.array(list(ROOM_COUNTS.values()))
    rooms = int(rng.choice(list(ROOM_COUNTS), p=counts / counts.sum()))
    for _ in range(_TRIES):
        plan = draw_layout(rng, rooms)
        house = None if plan is None else _furnish(rng, house_id, plan)
        if house is not None:
            return house
    raise RuntimeError(f"no plan of {rooms} rooms for house {house_id} in {_TRIES} tries")


def _furnish(rng: np.random.Generator, house_id: str, plan: GridPlan) -> House | None:
    """Return a layout as a house with openings; None if a room is too narrow or unreachable."""
    scale = 0.1 * float(rng.uniform(0.94, 1.08))
    height = round(float(rng.uniform(*HEIGHT_M)), 2)
    rings = [_ring(plan.labels == k, scale) for k in range(len(plan.types))]
    if any(ring is None or _narrow(ring) for ring in rings):
        return None
    borders = _borders(plan.labels, scale)
    holes = draw_doors(rng, plan, borders, height)
    if holes is None:
        return None
    entrance = draw_entrance(rng, plan, borders, holes, height)
    if entrance is None:
        return None
    holes.append(entrance)
    holes += draw_windows(rng, plan, borders, holes, height)
    ids = _room_ids(plan)
    rooms = tuple(
        Room(ids[k], plan.types[k], (ring,), height) for k, ring in enumerate(rings) if ring
    )
    depth = round(float(rng.uniform(0.08, 0.14)), 3)
    walls = tuple(wall for k, room in enumerate(rooms) for wall in _walls(room, k, holes, depth))
    doors = tuple(
        Door(*_sides(hole, ids, number))
        for number, hole in enumerate(holes)
        if hole.kind != "window"
    )
    return House(house_id, rooms, walls, doors)


def _sides(hole: Hole, ids: list[str], number: int) -> tuple[str, str, str | None]:
    """Return (room, opening id, other room or None) of a door."""
    inner = [k for k in (hole.border.a, hole.border.b) if k != OUTSIDE]
    return ids[inner[0]], f"hole_{number}", ids[inner[1]] if len(inner) > 1 else None


def _room_ids(plan: GridPlan) -> list[str]:
    """Return ids like bedroom_2."""
    seen: dict[str, int] = {}
    ids = []
    for types in plan.types:
        seen[types[0]] = seen.get(types[0], 0) + 1
        ids.append(f"{types[0].lower()}_{seen[types[0]]}")
    return ids


def _narrow(ring: Ring) -> bool:
    """Return whether a room, or a part of it, is too narrow for a person."""
    inner = shapely.Polygon(ring).buffer(-LEAST_WIDTH_M / 2, join_style="mitre")
    return bool(inner.is_empty or inner.geom_type != "Polygon")


def _ring(mask: np.ndarray, scale: float) -> Ring | None:
    """Return the outline of a room in metres; None if it is not one region without holes."""
    boxes = []
    for z in np.flatnonzero(mask.any(1)):
        steps = np.flatnonzero(np.diff(np.r_[0, mask[z].astype(np.int8), 0]))
        boxes += [shapely.box(a, z, b, z + 1) for a, b in zip(steps[::2], steps[1::2], strict=True)]
    shape = shapely.unary_union(boxes) if boxes else shapely.Polygon()
    if shape.geom_type != "Polygon" or shape.is_empty or shape.interiors:
        return None
    points = list(shapely.geometry.polygon.orient(shape).exterior.coords)[:-1]
    corners = []
    for i, (x, z) in enumerate(points):
        (x0, z0), (x1, z1) = points[i - 1], points[(i + 1) % len(points)]
        if (x - x0) * (z1 - z) != (z - z0) * (x1 - x):
            corners.append((round(x * scale, 4), round(z * scale, 4)))
    return tuple(corners)


def _borders(labels: np.ndarray, scale: float) -> list[Border]:
    """Return every straight border between two rooms or between a room and the outside."""
    borders = []
    for axis, grid in ((0, labels), (1, labels.T)):
        for line in range(1, grid.shape[0]):
            before, after = grid[line - 1], grid[line]
            code = np.where(before == after, -1, (before.astype(int) + 1) * 10_000 + after + 1)
            cuts = np.r_[0, np.flatnonzero(np.diff(code)) + 1, len(code)]
            for low, high in pairwise(cuts):
                if code[low] >= 0:
                    ends = round(low * scale, 4), round(high * scale, 4)
                    sides = int(before[low]), int(after[low])
                    borders.append(Border(*sides, axis, round(line * scale, 4), *ends))
    return borders


def _walls(room: Room, index: int, holes: list[Hole], depth: float) -> list[Wall]:
    """Return the walls of a room, one per edge of its outline, with their openings."""
    walls = []
    for wall in walls_of_rooms([room], depth=depth, shared=False):
        openings = (
            _cut(hole, f"hole_{number}", wall.start, wall.end)
            for number, hole in enumerate(holes)
            if index in (hole.border.a, hole.border.b) and _on_edge(hole, wall.start, wall.end)
        )
        walls.append(replace(wall, openings=tuple(sorted(openings, key=lambda o: o.start))))
    return walls


def _on_edge(hole: Hole, start: Point, end: Point) -> bool:
    """Return whether an opening lies on an edge of a room's outline."""
    along, across = hole.border.axis, 1 - hole.border.axis
    if start[across] != end[across] or start[across] != hole.border.line:
        return False
    return min(start[along], end[along]) <= hole.low and hole.high <= max(start[along], end[along])


def _cut(hole: Hole, opening_id: str, start: Point, end: Point) -> Opening:
    """Return a hole in metres along the wall from `start`."""
    origin = start[hole.border.axis]
    forwards = end[hole.border.axis] > origin
    low, high = (hole.low, hole.high) if forwards else (hole.high, hole.low)
    near, far = round(abs(low - origin), 4), round(abs(high - origin), 4)
    return Opening(opening_id, hole.kind, near, far, hole.bottom, hole.top)
