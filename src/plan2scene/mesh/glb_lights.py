"""Lamps and a sun of a GLB (KHR_lights_punctual): a downlight in each room, and daylight aslant.

A viewer shows 1 candela at 1 m as it would at night, without adapting as eyes do: lamps as bright
as real ones would burn every surface out. So their light is scaled to add `LAMP_LUX` to a floor,
the sun's `SUN_LUX`, to what a viewer's own surroundings give, about pi lux. Most viewers cast no
shadows: lamps are cones that look down, off the ceiling that they hang below, and end where their
room ends.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from plan2scene.house import House, Room
from plan2scene.mesh.light import LAMP, LAMP_DROP_M, lamp_position
from plan2scene.plans.geometry import room_polygon

EXTENSION = "KHR_lights_punctual"
#: Mean light of a lamp on its room's floor, and of the sun on what faces it.
LAMP_LUX, SUN_LUX = 0.8, 0.6
#: Of the sun, linear RGB; the way its light goes comes from the upper west and south.
SUN = (1.0, 0.97, 0.9)
TO_SUN = np.array([-0.45, 0.78, 0.43])
#: Half angle of a lamp's cone; within the first its light is whole.
_INNER, _OUTER = math.radians(35.0), math.radians(82.0)
#: The lights' own way is along -z.
_AHEAD = np.array([0.0, 0.0, -1.0])
_DECIMALS = 5


def add_lights(tree: dict[str, Any], house: House) -> None:
    """Add a house's lights to a glTF header in place, below the node that has the house's name."""
    lights: list[dict[str, Any]] = []
    nodes: list[dict[str, Any]] = []
    for room in house.rooms:
        if not room.open_air:
            lights.append(_lamp(room))
            nodes.append(_node(f"{room.id}/lamp", lamp_position(house, room.id), [0, -1, 0]))
            nodes[-1]["extras"] = {"kind": "lamp", "room_id": room.id}
    lights.append({"type": "directional", "color": list(SUN), "intensity": SUN_LUX, "name": "sun"})
    nodes.append(_node("sun", _above(house), -TO_SUN))
    nodes[-1]["extras"] = {"kind": "sun"}
    for number, node in enumerate(nodes):
        node["extensions"] = {EXTENSION: {"light": number}}
    root = next(node for node in tree["nodes"] if node.get("name") == house.id)
    first = len(tree["nodes"])
    tree["nodes"].extend(nodes)
    root["children"] = [*root.get("children", []), *range(first, first + len(nodes))]
    tree.setdefault("extensions", {})[EXTENSION] = {"lights": lights}
    tree["extensionsUsed"] = [*tree.get("extensionsUsed", []), EXTENSION]


def candela(area_m2: float, height_m: float) -> float:
    """Return the intensity of a lamp that gives a floor `LAMP_LUX` in the mean.

    The floor is a disk of `area_m2` and the lamp, as bright each way, `height_m` above its middle.
    """
    square = area_m2 / math.pi
    share = 1 - height_m / math.sqrt(height_m**2 + square)
    return LAMP_LUX * square / (2 * share)


def _lamp(room: Room) -> dict[str, Any]:
    """Return the light of a room."""
    polygon = room_polygon(room)
    height = max(room.height - LAMP_DROP_M, 0.5)
    x0, z0, x1, z1 = polygon.bounds
    return {
        "type": "spot",
        "color": LAMP.tolist(),
        "intensity": round(candela(polygon.area, height), _DECIMALS),
        "range": round(math.hypot(x1 - x0, z1 - z0, height), _DECIMALS),
        "spot": {"innerConeAngle": _INNER, "outerConeAngle": _OUTER},
        "name": f"{room.id}/lamp",
    }


def _above(house: House) -> np.ndarray:
    """Return a place over a house, where programs draw its sun, (3,)."""
    points = np.array([point for room in house.rooms for point in room.rings[0]])
    x, z = (points.min(axis=0) + points.max(axis=0)) / 2
    return np.array([x, 0.0, z]) + 10.0 * TO_SUN


def _node(name: str, place: np.ndarray, way: ArrayLike) -> dict[str, Any]:
    """Return the node of a light at a place that shines along a way, (3,) both."""
    along = np.asarray(way, dtype=np.float64)
    along = along / np.linalg.norm(along)
    turn = np.append(np.cross(_AHEAD, along), 1.0 + _AHEAD @ along)  # half way between both
    turn /= np.linalg.norm(turn)
    return {
        "name": name,
        "translation": [round(float(value), _DECIMALS) for value in place],
        "rotation": [float(value) for value in turn],
    }
