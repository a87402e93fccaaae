"""What no real home is like: a wrong unit, heights of a doll's house, islands, names in the way."""

from __future__ import annotations

import math
import statistics
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator

import numpy as np
from shapely.strtree import STRtree

from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.plans.geometry import room_polygon

#: A plan wider than this, or with a usual room larger (metres, square metres), is in another unit.
MAX_EXTENT, MAX_USUAL_AREA = 300.0, 1000.0
#: Bounds of a height in metres: outside the first a fault, outside the second a warning.
HEIGHTS, USUAL_HEIGHTS = (0.5, 30.0), (1.8, 6.0)
#: Beyond these (metres, square metres) a plan gets a warning.
USUAL_EXTENT, USUAL_AREA = 100.0, (0.3, 60.0)
#: The usual door of a home is this wide (metres), and no hole is narrower than the last.
USUAL_DOOR, NARROW = (0.4, 1.6), 0.2
#: Rooms farther than this (metres) from all others stand for themselves.
APART = 5.0
#: Names that Windows keeps for devices, whatever follows a dot.
DEVICES = {"con", "prn", "aux", "nul", *(f"{d}{k}" for d in ("com", "lpt") for k in range(1, 10))}

_Fault = Callable[..., InputError]
#: (expected, found, room) of a warning.
_Line = tuple[str, str, str]


def unit_faults(house: House, fault: _Fault) -> Iterator[InputError]:
    """Yield what shows that a plan is not in metres; outlines are known to be sound."""
    extent, area = _extent(house), _usual_area(house)
    if extent > MAX_EXTENT or area > MAX_USUAL_AREA:
        expected = f"a home in metres, at most {MAX_EXTENT:g} m wide"
        found = f"{extent:.0f} m, its usual room {area:.0f} m2 (are these centimetres?)"
        yield fault(expected, found)
    low, high = HEIGHTS
    for room in house.rooms:
        if not low <= room.height <= high:
            yield fault(f"a height of {low:g} to {high:g} m", f"{room.height:g}", room.id)
    for wall in house.walls:
        if wall.height > high:
            expected = f"a wall {wall.id} of at most {high:g} m"
            yield fault(expected, f"{wall.height:g}", wall.room_ids[0])


def oddities(house: House) -> Iterator[_Line]:
    """Yield what is unlike a home but may be one: scale, heights, islands, holes, names."""
    extent, area = _extent(house), _usual_area(house)
    if extent > USUAL_EXTENT:
        yield f"a home of at most {USUAL_EXTENT:g} m", f"{extent:.0f} m", ""
    low, high = USUAL_AREA
    if not low <= area <= high:
        found = f"{area:.2f} m2 (is the plan's unit the metre?)"
        yield f"a usual room of {low:g} to {high:g} m2", found, ""
    low, high = USUAL_HEIGHTS
    for room in house.rooms:
        if not low <= room.height <= high:
            yield f"a height of {low:g} to {high:g} m", f"{room.height:g}", room.id
    yield from _holes(house)
    for _, storey in house.storeys():
        yield from _islands(storey)
    yield from name_oddities("room ids", [room.id for room in house.rooms])
    yield from name_oddities("a house name", [house.id])


def name_oddities(what: str, names: Iterable[str]) -> Iterator[_Line]:
    """Yield names that cannot be files of their own everywhere: by case only, of devices."""
    groups: dict[str, list[str]] = defaultdict(list)
    for name in names:
        groups[name.lower()].append(name)
    for lower, same in groups.items():
        if len(same) > 1:
            found = f"{same[0]} and {same[1]}"
            yield f"{what} that differ by more than upper and lower case", found, same[0]
        if lower.split(".")[0] in DEVICES:
            yield f"{what} that every system takes as a file name", same[0], same[0]


def _extent(house: House) -> float:
    """Return the longer side in metres of the rooms' box."""
    points = np.array([p for room in house.rooms for ring in room.rings for p in ring])
    return float(np.ptp(points, axis=0).max())


def _usual_area(house: House) -> float:
    return statistics.median(room_polygon(room).area for room in house.rooms)


def _holes(house: House) -> Iterator[_Line]:
    """Yield holes too narrow to go or look through, and doors of another unit."""
    doors = []
    for wall in house.walls:
        for opening in wall.openings:
            width = opening.end - opening.start
            doors += [width] if opening.kind == "door" else []
            if width < NARROW:
                expected = f"hole {opening.id} of at least {NARROW:g} m"
                yield expected, f"{width:.3f} m", wall.room_ids[0]
    low, high = USUAL_DOOR
    if doors and not low <= (usual := statistics.median(doors)) <= high:
        found = f"{usual:.2f} m (is the plan's unit the metre?)"
        yield f"a usual door of {low:g} to {high:g} m", found, ""


def _islands(house: House) -> Iterator[_Line]:
    """Yield rooms that stand apart from the first room's group."""
    polygons = [room_polygon(room) for room in house.rooms]
    pairs = STRtree(polygons).query(polygons, predicate="dwithin", distance=APART)
    near: dict[int, list[int]] = defaultdict(list)
    for i, j in zip(*pairs.tolist(), strict=True):
        near[i].append(j)
    seen, queue = {0}, [0]
    while queue:
        for j in near[queue.pop()]:
            if j not in seen:
                seen.add(j)
                queue.append(j)
    others = [i for i in range(len(polygons)) if i not in seen]
    if others:
        group = [polygons[i] for i in sorted(seen)]
        far = min((polygon.distance(polygons[others[0]]) for polygon in group), default=math.inf)
        found = f"{len(others)} apart from the others, the first by {far:.1f} m"
        yield f"rooms within {APART:g} m of each other", found, house.rooms[others[0]].id
