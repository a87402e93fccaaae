"""A synthetic apartment as other programs would draw it, and whether a reader finds it again.

Walls stand on the apartment's outlines, half their thickness to either side; rooms end at their
faces.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from places import ROOT
from shapely.geometry import LineString, Point

from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import point_along, room_polygon
from plan2scene.plans.validate import house_faults

FLATS = sorted((ROOT / "resources/demo/archs_no_objects/test").glob("*.scene.json"))
#: Where the formats that list a room's openings have those of a kind.
LISTS = {"door": "doors", "window": "windows", "passage": "openings"}


def refusal(path, scale=None):
    """Return the one line by which a plan is refused, after its file and house."""
    with pytest.raises(InputError) as caught:
        read_plan(path, "h1", scale)
    line, head = str(caught.value), f"file {path}, house h1"
    assert line.startswith(head) and "\n" not in line
    return line.removeprefix(head)


@dataclass(frozen=True)
class Hole:
    """An opening on its wall's axis: kind, centre (x, z), direction (unit), sizes in metres."""

    kind: str
    centre: np.ndarray
    along: np.ndarray
    width: float
    bottom: float
    top: float

    @property
    def ends(self):
        return self.centre - self.along * self.width / 2, self.centre + self.along * self.width / 2


@dataclass(frozen=True)
class Drawn:
    """Rooms (id, types, polygon), axes (start, end), the walls' thickness and height, holes."""

    rooms: list
    axes: list
    thickness: float
    height: float
    holes: list
    adjacency: tuple

    def holes_of(self, area):
        """Return (list that it is in, hole) of those around a room: both rooms show a door."""
        near = [hole for hole in self.holes if area.distance(Point(hole.centre)) < 0.15]
        return [(LISTS[hole.kind], hole) for hole in near]


def drawn_flat(number):
    """Return a synthetic apartment of the demo as a drawing."""
    house = read_plan(FLATS[number], "h1")
    thickness, height = house.walls[0].depth, house.walls[0].height
    axes, rooms, holes = {}, [], {}
    for room in house.rooms:
        outline = room_polygon(room)
        points = [(round(x, 6), round(z, 6)) for x, z in outline.exterior.coords]
        axes.update(dict.fromkeys(tuple(sorted(pair)) for pair in pairwise(points)))
        inner = outline.buffer(-thickness / 2, join_style="mitre", mitre_limit=10)
        rooms.append((room.id, room.types, inner))
    for wall in house.walls:
        for o in wall.openings:
            a, b = (np.array(point_along(wall, at)) for at in (o.start, o.end))
            width = o.end - o.start
            holes.setdefault(
                o.id, Hole(o.kind, (a + b) / 2, (b - a) / width, width, o.bottom, o.top)
            )
    return Drawn(rooms, list(axes), thickness, height, list(holes.values()), house.adjacency())


def body(ends, thickness, cap="round"):
    return LineString(ends).buffer(thickness / 2, cap_style=cap)


def assert_found(plan, house, *, kinds=True, types=True, heights=True):
    """Rooms one to one with areas within .5 %, openings within 5 cm, doors between the same."""
    names = {}
    for name, room_types, polygon in plan.rooms:
        match = max(house.rooms, key=lambda r: room_polygon(r).intersection(polygon).area)
        area = room_polygon(match).area
        assert abs(area - polygon.area) <= 0.005 * polygon.area, (name, match.id)
        assert room_polygon(match).intersection(polygon).area >= 0.99 * polygon.area
        assert not types or match.types == room_types
        names[match.id] = name
    assert len(names) == len(house.rooms) == len(plan.rooms)
    left = {}
    for wall in house.walls:
        for o in wall.openings:
            left.setdefault(o.id, (wall, o))
    assert len(left) == len(plan.holes)
    for hole in plan.holes:
        assert_hole(hole, left, plan.thickness, kinds, heights)
    found = {tuple(sorted(names[room] for room in pair)) for pair in house.adjacency()}
    assert found == set(plan.adjacency)


def assert_storeys(plans, house, levels):
    """Every storey is as it was drawn; `levels` are their (id, metres above the ground)."""
    assert [level.id for level in house.levels] == [name for name, _ in levels]
    elevations = [level.elevation for level in house.levels]
    assert elevations == pytest.approx([metres for _, metres in levels])
    for plan, (_, storey) in zip(plans, house.storeys(), strict=True):
        assert_found(plan, storey)
    assert list(house_faults(house)) == []


def assert_hole(hole, left, thickness, kinds, heights):
    """Take the hole that is where it was drawn out of `left`."""

    def offset(item):
        wall, o = item[1]
        return np.array(point_along(wall, (o.start + o.end) / 2)) - hole.centre

    name, (_, o) = min(left.items(), key=lambda item: np.linalg.norm(offset(item)))
    away = offset((name, left.pop(name)))
    assert abs(away @ hole.along) < 0.05 and np.linalg.norm(away) < thickness / 2 + 0.05
    assert abs(o.end - o.start - hole.width) < 0.05
    assert not kinds or o.kind == hole.kind
    if heights:
        assert max(abs(o.bottom - hole.bottom), abs(o.top - hole.top)) < 0.05
