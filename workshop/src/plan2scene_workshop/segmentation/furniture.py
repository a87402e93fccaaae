"""Which things stand in a drawn room, and where; all of it is labelled other."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from plan2scene_workshop.segmentation.bodies import (
    Array,
    Body,
)
from plan2scene_workshop.segmentation.paints import Paints
from plan2scene_workshop.segmentation.seating import bed, chair, office_chair, sofa
from plan2scene_workshop.segmentation.spots import Spot
from plan2scene_workshop.segmentation.storage import cabinet, desk, kitchen, shelf, table
from plan2scene_workshop.segmentation.sundries import (
    bath,
    floor_lamp,
    heap,
    plant,
    rug,
    somebody,
)

Rng = np.random.Generator
Maker = Callable[[Spot, Paints, Rng], list[Body]]
#: Pieces by kind of room with their weights; "any" mixes everything.
_ROOMS: Mapping[str, Mapping[Maker, float]] = {
    "any": {
        table: 2,
        desk: 1,
        chair: 2,
        office_chair: 1,
        sofa: 1.5,
        bed: 1,
        cabinet: 2.5,
        shelf: 1,
        plant: 1,
        floor_lamp: 0.7,
        heap: 1.5,
        rug: 1,
        somebody: 0.3,
        bath: 0.4,
        kitchen: 0.4,
    },
    "living": {
        sofa: 3,
        table: 2,
        cabinet: 1.5,
        shelf: 1,
        plant: 1,
        floor_lamp: 1,
        rug: 1,
        chair: 1,
    },
    "bed": {
        bed: 3,
        cabinet: 2,
        chair: 0.7,
        desk: 0.7,
        heap: 1,
        rug: 1,
        floor_lamp: 0.5,
        shelf: 0.5,
    },
    "office": {
        desk: 4,
        office_chair: 2,
        shelf: 1.5,
        cabinet: 1.5,
        plant: 0.5,
        heap: 0.7,
        table: 0.5,
    },
    "kitchen": {kitchen: 3, table: 2, chair: 2, cabinet: 1, heap: 0.5, rug: 0.3},
    "bath": {bath: 4, cabinet: 1, heap: 0.5, rug: 0.7},
}
_SHARES = {"any": 0.32, "living": 0.18, "bed": 0.16, "office": 0.12, "kitchen": 0.08, "bath": 0.06}
#: Most pieces of a kind of room.
_MOST = {"any": 18, "living": 14, "bed": 12, "office": 13, "kitchen": 11, "bath": 8}


def furnish(half: Array, paints: Paints, rng: Rng) -> list[Body]:
    """Return furniture: rows of desks or chairs, or pieces of which most stand along a wall.

    Parameters
    ----------
    half : (3,) float64
        Half the room's size in metres; the room is centred on x = z = 0, its floor at y = 0.
    """
    kinds, shares = list(_SHARES), np.array(list(_SHARES.values()))
    if rng.random() > shares.sum():
        return _rows(half, paints, rng)
    kind = str(rng.choice(kinds, p=shares / shares.sum()))
    makers, weights = list(_ROOMS[kind]), np.array(list(_ROOMS[kind].values()), float)
    bodies: list[Body] = []
    for _ in range(int(rng.integers(0 if kind == "any" else 3, _MOST[kind]))):
        make = makers[int(rng.choice(len(makers), p=weights / weights.sum()))]
        against = make not in (rug, somebody, office_chair) and rng.random() < 0.72
        bodies += make(_place(half, against, rng), paints, rng)
    return bodies


def _place(half: Array, against_wall: bool, rng: Rng) -> Spot:
    """Return a random place; against a wall the back, at -z, is to it."""
    place = rng.uniform(-0.85, 0.85, 2) * half[[0, 2]]
    yaw = float(rng.uniform(0, 2 * np.pi))
    if rng.random() < 0.4:
        yaw = float(rng.integers(4)) * np.pi / 2
    if against_wall:
        axis, sign = int(rng.integers(2)), int(rng.choice([-1, 1]))
        place[axis] = sign * (half[2 * axis] - rng.uniform(0.25, 0.55))
        yaw = [-sign * np.pi / 2, np.pi * (sign > 0)][axis] + rng.normal(0, 0.02)
    return Spot(float(place[0]), float(place[1]), float(yaw))


def _rows(half: Array, paints: Paints, rng: Rng) -> list[Body]:
    """Return rows of desks with chairs, or of chairs alone, mostly alike: class rooms, offices."""
    make = [desk, table, chair, office_chair][int(rng.choice(4, p=[0.35, 0.2, 0.3, 0.15]))]
    small = make in (chair, office_chair)
    step_x = rng.uniform(0.5, 0.8) if small else rng.uniform(1.3, 2.2)
    step_z = rng.uniform(0.8, 1.2) if small else rng.uniform(1.3, 2.0)
    look = int(rng.integers(2**62))
    turn = float(rng.integers(4)) * np.pi / 2
    bodies: list[Body] = []
    for x in np.arange(-half[0] + 0.7, half[0] - 0.5, step_x):
        for z in np.arange(-half[2] + 0.9, half[2] - 0.6, step_z):
            if rng.random() < 0.15 or len(bodies) > 250:
                continue
            alike = np.random.default_rng(look) if rng.random() < 0.8 else rng
            yaw = turn + rng.normal(0, 0.1 if small else 0.02)
            spot = Spot(float(x + rng.normal(0, 0.04)), float(z + rng.normal(0, 0.04)), float(yaw))
            bodies += make(spot, paints, alike)
    return bodies
