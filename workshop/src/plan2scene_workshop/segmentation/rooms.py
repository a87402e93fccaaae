"""The shells of drawn rooms: floor, walls, ceilings flat, gridded or sloped, beams and dados."""

from __future__ import annotations

import numpy as np

from plan2scene.photos.labels.palette import CEILING, FLOOR, IGNORE, OTHER, WALL
from plan2scene_workshop.segmentation.bodies import (
    Array,
    Body,
    Lamp,
    Paint,
    plain,
)
from plan2scene_workshop.segmentation.paints import Paints
from plan2scene_workshop.segmentation.spots import Spot, wall_spots

Rng = np.random.Generator


def random_half(rng: Rng) -> Array:
    """Return half the size (3,) of a room: closets, homes, now and then a hall."""
    wide = (1.1, 3.5) if rng.random() < 0.85 else (2.5, 6.0)
    return np.array([rng.uniform(*wide), rng.uniform(1.12, 1.6), rng.uniform(1.1, wide[1])])


def shell(half: Array, paints: Paints, rng: Rng) -> Body:
    """Return the hollow box of the room: floor at y 0, walls, ceiling."""
    wall = paints.wall(rng)
    accent = paints.wall(rng) if rng.random() < 0.25 else wall
    kind = rng.random()
    if kind < 0.62:
        ceiling = plain(rng.uniform(0.5, 0.95) * np.exp(rng.normal(0, 0.03, 3)))
    elif kind < 0.8:
        ceiling = paints.of("grid", rng)
    else:
        ceiling = wall if kind < 0.88 else paints.wall(rng)
    sides = [wall, wall, paints.floor(rng), ceiling, wall, wall]
    sides[int(rng.choice([0, 1, 4, 5]))] = accent
    return Body(
        centre=np.array([0.0, half[1], 0.0]),
        half=half,
        yaw=0.0,
        labels=(WALL, WALL, FLOOR, CEILING, WALL, WALL),
        paints=tuple(sides),
        hollow=True,
    )


def polished(room: Body, rng: Rng) -> list[Body]:
    """Return a skin on the floor that mirrors a little, for some rooms; labelled floor."""
    if rng.random() > 0.25:
        return []
    half = np.array([room.half[0], 0.001, room.half[2]])
    floor = Body(
        np.array([0.0, 0.0, 0.0]),
        half,
        0.0,
        (FLOOR,),
        (room.paints[2],),
        mirror=rng.uniform(0.2, 0.6),
    )
    return [floor]


def wall_blocks(room: Body, rng: Rng) -> list[Body]:
    """Return chimney breasts, columns and corners of L-shaped rooms: wall from floor to ceiling."""
    blocks = []
    for _ in range(int(rng.choice([0, 1, 2, 3], p=[0.45, 0.3, 0.15, 0.1]))):
        half = np.array([rng.uniform(0.1, 1.0), room.half[1], rng.uniform(0.1, 1.0)])
        sign = rng.choice([-1, 1], 2)
        place = np.array([sign[0], 0, sign[1]]) * room.half
        free = int(rng.choice([0, 2, 1]))  # slide along x, along z, or stay in the corner
        if free != 1:
            place[free] = rng.uniform(-1, 1) * room.half[free]
        paint = room.paints[0] if rng.random() < 0.8 else room.paints[4]
        blocks.append(
            Body(np.array([place[0], room.half[1], place[2]]), half, 0.0, (WALL,), (paint,))
        )
    return blocks


def wall_trim(room: Body, paints: Paints, rng: Rng) -> list[Body]:
    """Return skirting, dados and panelling (labelled wall), and cornices (ignored)."""
    skirting = plain(rng.uniform(0.02, 0.95) * np.ones(3)) if rng.random() < 0.7 else None
    dado = paints.wall(rng) if rng.random() < 0.18 else None
    panels = rng.random() < 0.4
    top = rng.uniform(0.7, 1.4)
    cornice = rng.random() < 0.15
    high = rng.uniform(0.06, 0.22)
    trim = []
    for wall, length in wall_spots(room.half):
        if dado is not None:
            trim.append(wall.part((0, top / 2, 0), (length, top, 0.008), dado, label=WALL))
            rail = plain(rng.uniform(0.1, 0.9) * np.ones(3))
            trim.append(wall.part((0, top, 0), (length, 0.05, 0.03), rail, label=WALL))
            for u in np.arange(-length / 2, length / 2, 0.6) if panels else ():
                trim.append(wall.part((u, top / 2, 0), (0.04, top, 0.02), rail, label=WALL))
        if skirting:
            trim.append(wall.part((0, 0.0, 0), (length, high, 0.03), skirting, label=WALL))
        if cornice:
            y = 2 * room.half[1]
            paint = room.paints[3]
            trim.append(wall.part((0, y, 0), (length, 0.2, 0.2), paint, label=IGNORE))
    return trim


def above(room: Body, paints: Paints, rng: Rng) -> tuple[list[Body], list[Lamp]]:
    """Return what is overhead: slopes and beams (ceiling), lamp panels and lamps (other)."""
    half = room.half
    bodies: list[Body] = []
    lamps: list[Lamp] = []
    walls = wall_spots(half)
    if rng.random() < 0.12:
        for k in rng.permutation(4)[: int(rng.integers(1, 3))]:
            bodies.append(_slope(*walls[int(k)], float(half[1]), room, rng))
    elif rng.random() < 0.12:
        paint = room.paints[3] if rng.random() < 0.5 else paints.of("wood", rng)
        deep = rng.uniform(0.1, 0.3)
        for x in np.arange(-half[0] + rng.uniform(0.1, 0.8), half[0], rng.uniform(0.5, 1.5)):
            size = np.array([rng.uniform(0.04, 0.12), deep / 2, half[2]])
            centre = np.array([x, 2 * half[1] - deep / 2, 0])
            bodies.append(Body(centre, size, 0.0, (CEILING,), (paint,)))
    elif rng.random() < 0.35:
        panels, light = _panels(half, rng)
        bodies += panels
        lamps += light
    if rng.random() < 0.3:
        bodies += _pendant(half, paints, rng)
    return bodies, lamps


def _slope(wall: Spot, length: float, half_height: float, room: Body, rng: Rng) -> Body:
    """Return a sloped ceiling over one wall, from knee height up; its slope counts as ceiling."""
    angle = rng.uniform(0.5, 1.1)
    knee = rng.uniform(0.6, 1.8) * half_height
    normal = np.array([0.0, -np.cos(angle), np.sin(angle)])
    centre = np.array([0.0, knee, 0.0]) - 2.0 * normal
    paint: Paint = room.paints[3] if rng.random() < 0.6 else room.paints[0]
    size = (length + 0.2, 4.0, 12.0)
    return wall.part(centre.tolist(), size, paint, label=CEILING, tilt=-angle)


def _panels(half: Array, rng: Rng) -> tuple[list[Body], list[Lamp]]:
    """Return lamp panels in rows on the ceiling and their light."""
    size = np.array([[0.3, 0.003, 0.3], [0.6, 0.02, 0.1], [0.15, 0.02, 0.75], [0.06, 0.01, 0.06]])
    panel = size[int(rng.integers(len(size)))]
    step = rng.uniform(1.2, 2.6, 2)
    glow = float(rng.choice([0.0, 4.0, 10.0], p=[0.2, 0.5, 0.3]))
    white = plain(np.array([0.95, 0.97, 0.9]) * rng.uniform(0.7, 1))
    bodies: list[Body] = []
    lamps: list[Lamp] = []
    for x in np.arange(-half[0] + 0.6, half[0] - 0.3, step[0]):
        for z in np.arange(-half[2] + 0.6, half[2] - 0.3, step[1]):
            centre = np.array([x, 2 * half[1], z])
            bodies.append(Body(centre, panel, 0.0, (OTHER,), (white,), glow=glow))
            if glow and len(lamps) < 3 and rng.random() < 0.5:
                lamps.append(Lamp(centre - [0, 0.1, 0], np.ones(3) * rng.uniform(0.5, 2), 0.4))
    return bodies, lamps


def _pendant(half: Array, paints: Paints, rng: Rng) -> list[Body]:
    """Return a lamp that hangs from the ceiling."""
    x, z = rng.uniform(-0.5, 0.5, 2) * half[[0, 2]]
    spot = Spot(float(x), float(z), 0.0)
    drop, wide = rng.uniform(0.2, 0.8), rng.uniform(0.15, 0.6)
    top = 2 * half[1]
    shade = plain(np.array([0.9, 0.85, 0.7])) if rng.random() < 0.5 else paints.thing(rng)
    glow, size = float(rng.choice([0.0, 3.0])), (wide, rng.uniform(0.1, 0.4), wide)
    return [
        spot.part((0, top - drop / 2, 0), (0.015, drop, 0.015), paints.thing(rng)),
        spot.part((0, top - drop, 0), size, shade, round=True, glow=glow),
    ]
