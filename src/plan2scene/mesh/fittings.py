"""Fixed objects: where the plan has icons, simple models of baths, stoves, stairs at the wall.

An icon's box says what stands where; sizes that it does not give are those of ordinary fittings.
Local axes of a model: x along the wall to the right as seen from the room, y up, z into the room.
"""

from __future__ import annotations

import logging
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from shapely.geometry import Point, Polygon, box
from shapely.geometry.base import BaseGeometry

from plan2scene.house import House, IconBox, Room
from plan2scene.mesh.parts import Colour, Corner, MeshPart, PartBuilder
from plan2scene.plans.levels import STAIRS
from plan2scene.plans.wall_sides import Frame, Side

Block = tuple[Corner, Corner, Colour]  #: a box: two opposite corners, its colour
CERAMIC: Colour = (243, 243, 240)
WATER: Colour = (214, 224, 226)
METAL: Colour = (168, 170, 172)
FRONT: Colour = (222, 216, 206)
SIDE: Colour = (196, 190, 180)
WOOD: Colour = (176, 146, 112)
TOP: Colour = (92, 88, 84)
DARK: Colour = (42, 42, 44)
#: An object whose icon is farther than this from every wall of its room stands free, metres.
NEAR_WALL = 0.6
OFF = 0.02  #: Objects stand this far off the wall, metres: clear of its skirting
#: An icon is built if at least this share of its box lies in a room.
LEAST_INSIDE = 0.3
_log = logging.getLogger("plan2scene")


def toilet(w: float, d: float, h: float) -> list[Block]:
    """Return a cistern at the wall, a bowl and its lid."""
    tank = min(0.18, 0.3 * d)
    return [
        ((0, 0.38 * h, 0), (w, h, tank), CERAMIC),
        ((0.18 * w, 0, tank), (0.82 * w, 0.45 * h, 0.85 * d), CERAMIC),
        ((0.05 * w, 0.45 * h, tank), (0.95 * w, 0.53 * h, d), CERAMIC),
    ]


def sink(w: float, d: float, h: float) -> list[Block]:
    """Return a basin on a pedestal with a tap."""
    middle = w / 2
    return [
        ((middle - 0.09, 0, 0.05), (middle + 0.09, h - 0.16, 0.05 + 0.4 * d), CERAMIC),
        *_basin(w, d, h - 0.16, h, 0.04),
        ((middle - 0.015, h, 0.02), (middle + 0.015, h + 0.14, 0.05), METAL),
        ((middle - 0.015, h + 0.12, 0.05), (middle + 0.015, h + 0.14, 0.16), METAL),
    ]


def bath(w: float, d: float, h: float) -> list[Block]:
    """Return a tub and its tap."""
    return [
        *_basin(w, d, 0.0, h, 0.06, floor=0.12),
        ((0.06, h, d / 2 - 0.02), (0.2, h + 0.1, d / 2 + 0.02), METAL),
    ]


def shower(w: float, d: float, h: float) -> list[Block]:
    """Return a tray, a rail and the head."""
    middle = w / 2
    return [
        *_basin(w, d, 0.0, 0.1, 0.05, floor=0.05),
        ((middle - 0.012, 1.0, 0.01), (middle + 0.012, h, 0.035), METAL),
        ((middle - 0.012, h - 0.03, 0.035), (middle + 0.012, h, 0.3), METAL),
        ((middle - 0.1, h - 0.05, 0.2), (middle + 0.1, h - 0.03, 0.4), METAL),
    ]


def stove(w: float, d: float, h: float) -> list[Block]:
    """Return a counter with plinth and top; in its middle an oven under four plates."""
    middle, half = w / 2, min(0.28, 0.45 * w)
    plates = [
        ((x - 0.09, h, z - 0.09), (x + 0.09, h + 0.006, z + 0.09), DARK)
        for x in (middle - half / 2, middle + half / 2)
        for z in (0.3 * d, 0.7 * d)
    ]
    return [
        ((0, 0.1, 0), (w, h - 0.04, d - 0.03), FRONT),
        ((0, 0, 0), (w, 0.1, d - 0.08), TOP),
        ((0, h - 0.04, 0), (w, h, d), TOP),
        ((middle - half, 0.16, d - 0.03), (middle + half, h - 0.1, d - 0.015), DARK),
        ((middle - half + 0.03, h - 0.17, d - 0.015), (middle + half - 0.03, h - 0.15, d), METAL),
        *plates,
    ]


def counter(w: float, d: float, h: float) -> list[Block]:
    """Return a worktop on cupboards with doors about half a metre wide."""
    count = max(1, round(w / 0.5))
    fronts = [
        (
            (w * k / count + 0.003, 0.12, d - 0.035),
            (w * (k + 1) / count - 0.003, h - 0.06, d - 0.02),
            FRONT,
        )
        for k in range(count)
    ]
    return [
        ((0, 0.1, 0), (w, h - 0.04, d - 0.035), SIDE),
        ((0, 0, 0), (w, 0.1, d - 0.08), TOP),
        ((0, h - 0.04, 0), (w, h, d), TOP),
        *fronts,
    ]


def sink_unit(w: float, d: float, h: float) -> list[Block]:
    """Return a counter with a basin set on it and a tap."""
    left, right, front = 0.1 * w, 0.9 * w, d - 0.07
    bowl = [
        ((left + a[0], h + a[1], 0.1 + a[2]), (left + b[0], h + b[1], 0.1 + b[2]), colour)
        for a, b, colour in _basin(right - left, front - 0.1, 0.0, 0.03, 0.03, floor=0.008)
    ]
    middle = w / 2
    tap = [
        ((middle - 0.015, h, 0.04), (middle + 0.015, h + 0.14, 0.07), METAL),
        ((middle - 0.015, h + 0.12, 0.07), (middle + 0.015, h + 0.14, 0.2), METAL),
    ]
    return [*counter(w, d, h), *bowl, *tap]


def wardrobe(w: float, d: float, h: float) -> list[Block]:
    """Return a case with doors about half a metre wide, and their handles."""
    count = max(1, round(w / 0.5))
    blocks: list[Block] = [((0, 0, 0), (w, h, d - 0.02), WOOD)]
    for k in range(count):
        left, right = w * k / count + 0.004, w * (k + 1) / count - 0.004
        grip = right - 0.05 if k % 2 == 0 else left + 0.04
        blocks.append(((left, 0.06, d - 0.02), (right, h - 0.01, d - 0.005), WOOD))
        blocks.append(((grip, 0.95, d - 0.005), (grip + 0.01, 1.15, d), METAL))
    return blocks


def stairs(w: float, d: float, h: float) -> list[Block]:
    """Return a straight flight of closed steps, upwards along x."""
    count = max(2, int(np.ceil(h / STAIRS.riser)))
    return [
        ((w * k / count, 0, 0), (w * (k + 1) / count, h * (k + 1) / count, d), WOOD)
        for k in range(count)
    ]


def _basin(
    w: float, d: float, low: float, high: float, rim: float, floor: float = 0.04
) -> list[Block]:
    """Return an open vessel: four sides and a bottom."""
    return [
        ((0, low, 0), (rim, high, d), CERAMIC),
        ((w - rim, low, 0), (w, high, d), CERAMIC),
        ((rim, low, 0), (w - rim, high, rim), CERAMIC),
        ((rim, low, d - rim), (w - rim, high, d), CERAMIC),
        ((rim, low, rim), (w - rim, low + floor, d - rim), WATER),
    ]


@dataclass(frozen=True)
class Kind:
    """What an object is."""

    words: frozenset[str]  #: words in an icon's type that mean this kind, lower case
    #: returns the boxes of a model for its (width along the wall, depth, height), metres
    blocks: Callable[[float, float, float], list[Block]]
    size: tuple[float, float, float]  #: ordinary width, depth and height, metres
    stretch: float = 0.0  #: a model is as wide as its icon, at most this, metres; 0: ordinary width
    deep: float = 0.0  #: a model is as deep as its icon, at most this, metres; 0: ordinary depth


KINDS: Mapping[str, Kind] = {
    "toilet": Kind(frozenset({"toilet", "wc"}), toilet, (0.38, 0.68, 0.78)),
    "sink_unit": Kind(frozenset({"unit"}), sink_unit, (0.8, 0.6, 0.9), 4.0, 1.3),
    "sink": Kind(frozenset({"sink", "basin", "washbasin"}), sink, (0.6, 0.48, 0.86)),
    "bath": Kind(frozenset({"bath", "bathtub", "tub"}), bath, (1.7, 0.75, 0.56), 1.9),
    "shower": Kind(frozenset({"shower", "douche"}), shower, (0.9, 0.9, 2.1)),
    "stove": Kind(
        frozenset({"stove", "cooker", "cooking", "hob", "oven"}), stove, (0.6, 0.6, 0.9), 4.0
    ),
    "counter": Kind(frozenset({"counter", "worktop"}), counter, (1.0, 0.6, 0.9), 6.0, 1.3),
    "wardrobe": Kind(frozenset({"wardrobe", "closet", "cupboard"}), wardrobe, (1.0, 0.6, 2.1), 4.0),
    "stairs": Kind(frozenset({"stairs", "staircase", "stair"}), stairs, (3.0, 0.9, 2.5)),
}


def category_of(icon: IconBox) -> str | None:
    """Return the name in :data:`KINDS` of an icon; None if it is of no such kind."""
    words = set(re.findall(r"[a-z]+", re.sub(r"([a-z])([A-Z])", r"\1 \2", icon.type).lower()))
    return next((name for name, kind in KINDS.items() if kind.words & words), None)


def objects(
    house: House, sides: Iterable[Side], polygons: Mapping[str, BaseGeometry]
) -> list[MeshPart]:
    """Return a part ``{room}/object/{category}`` for each icon of a known kind.

    `sides` are the faces of all rooms' walls, `polygons` the rooms' plan areas by id. An icon that
    is not in a room is left out, with a warning in the log.
    """
    faces = list(sides)
    parts = []
    for icon in house.icons:
        category = category_of(icon)
        area = box(*icon.p1, *icon.p2)
        if category is None or area.area < 1e-4:
            continue
        room = max(house.rooms, key=lambda r: polygons[r.id].intersection(area).area)
        polygon = polygons[room.id]
        if polygon.intersection(area).area < LEAST_INSIDE * area.area:
            found = f"from {icon.p1} to {icon.p2}"
            _log.warning("house %s: %s %s stands in no room, left out", house.id, icon.type, found)
            continue
        room_faces = [face for face in faces if face.room_id == room.id]
        parts.append(_placed(category, area, room, polygon, room_faces))
    return parts


def _placed(
    category: str, area: Polygon, room: Room, polygon: BaseGeometry, sides: list[Side]
) -> MeshPart:
    """Return an object at the wall that its icon is nearest to, within its room."""
    kind = KINDS[category]
    frame = _wall_of(area, sides, along=kind.stretch > 0 or category == "stairs")
    low, high = _extent(area, frame)
    width, depth, height = kind.size
    height = min(height, room.height - 0.05)
    if category == "stairs":
        width, depth, height = high[0] - low[0], high[1] - low[1], room.height
    elif kind.stretch:
        width = min(max(high[0] - low[0], 0.5 * width), kind.stretch)
    if kind.deep:
        depth = min(max(high[1] - max(low[1], OFF), 0.5 * depth), kind.deep)
    back = OFF if low[1] < NEAR_WALL and category != "stairs" else low[1]
    left = (low[0] + high[0] - width) / 2
    if back == OFF:
        width = min(width, frame.length - 2 * OFF)
        left = float(np.clip(left, OFF, max(frame.length - OFF - width, OFF)))
        depth = min(depth, _free_depth(frame, polygon, left + width / 2))
    builder = PartBuilder()
    axes = frame.axes(left, back)
    for first, second, colour in kind.blocks(width, depth, height):
        builder.box(axes, first, second, colour)
    walked = "stairs" if category == "stairs" else "object"
    extras = {"kind": walked, "category": category, "room_id": room.id}
    return builder.build(f"{room.id}/object/{category}", extras=extras)


def _wall_of(area: Polygon, sides: list[Side], *, along: bool) -> Frame:
    """Return the wall face nearest to an icon, or a face along its longer side if none is near.

    Of walls about as near, prefer one along the icon's longer side if `along`, else across it.
    """
    x0, z0, x1, z1 = area.bounds

    def cost(side: Side) -> float:
        frame = side.frame
        low, high = _extent(area, frame)
        beside = max(0.0, low[0] - frame.length, -high[0])
        runs = high[0] - low[0] >= high[1] - low[1]
        return abs(low[1]) + beside + (0.0 if runs == along else 0.25)

    best = min(sides, key=cost, default=None)
    if best is not None and cost(best) < NEAR_WALL + 0.25:
        return best.frame
    if x1 - x0 >= z1 - z0:
        return Frame(np.array([x0, z0]), np.array([1.0, 0.0]), np.array([0.0, 1.0]), x1 - x0)
    return Frame(np.array([x0, z1]), np.array([0.0, -1.0]), np.array([1.0, 0.0]), z1 - z0)


def _extent(area: Polygon, frame: Frame) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and greatest (along, out) of an icon in a face's axes, metres."""
    corners = np.asarray(area.exterior.coords) - frame.left
    local = np.stack([corners @ frame.right, corners @ frame.normal], axis=1)
    return local.min(axis=0), local.max(axis=0)


def _free_depth(frame: Frame, polygon: BaseGeometry, s: float) -> float:
    """Return how deep the room is in front of a point `s` of a wall, metres, from 0.1 to 1."""
    reach = 0.1
    while reach < 1.0 and polygon.contains(Point(*frame.plan(s, OFF + reach + 0.02))):
        reach += 0.02
    return reach
