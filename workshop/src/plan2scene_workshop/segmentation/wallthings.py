"""What hangs on or breaks the walls of drawn rooms: windows, doors, pictures, mirrors, curtains.

All of it is labelled other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from plan2scene_workshop.segmentation.bodies import (
    Body,
    Lamp,
    Paint,
    plain,
)
from plan2scene_workshop.segmentation.paints import Paints
from plan2scene_workshop.segmentation.spots import Spot, wall_spots

Rng = np.random.Generator
_KINDS = {
    "window": 0.24,
    "door": 0.16,
    "picture": 0.2,
    "board": 0.06,
    "mirror": 0.08,
    "radiator": 0.08,
    "cupboard": 0.07,
    "switch": 0.06,
    "clock": 0.03,
    "glass": 0.02,
}


@dataclass(frozen=True, eq=False)
class _Wall:
    """A wall to hang things on: its place, size, and the paint of frames in this room."""

    spot: Spot
    length: float
    height: float
    frame: Paint
    paints: Paints
    room: Body


@dataclass(frozen=True, eq=False)
class Hung:
    """Things, the lights that come in with them, and the panes that sun may pass."""

    bodies: list[Body]
    lamps: list[Lamp]
    panes: list[Body]


def hang_on_walls(
    room: Body, paints: Paints, rng: Rng
) -> tuple[list[Body], list[Lamp], list[Body]]:
    """Return things on walls, the light of windows, and the panes of windows.

    Parameters
    ----------
    room : Body
        The hollow box of the room, centred on x = z = 0, its floor at y = 0.
    """
    frame = plain(rng.uniform(0.03, 0.95) * np.exp(rng.normal(0, 0.05, 3)))
    found = Hung([], [], [])
    kinds, shares = list(_KINDS), np.array(list(_KINDS.values()))
    for spot, length in wall_spots(room.half):
        wall = _Wall(spot, length, 2 * float(room.half[1]), frame, paints, room)
        for _ in range(int(rng.integers(0, 6))):
            kind = str(rng.choice(kinds, p=shares / shares.sum()))
            u = float(rng.uniform(-0.47, 0.47)) * length
            if kind == "window":
                _window(wall, u, found, rng)
            elif kind == "glass":
                _glazing(wall, u, found, rng)
            elif kind == "door":
                found.bodies.extend(_door(wall, u, rng))
            else:
                found.bodies.extend(_flat(wall, kind, u, rng))
    return found.bodies, found.lamps, found.panes


def _door(wall: _Wall, u: float, rng: Rng) -> list[Body]:
    """Return a door in its frame: closed, glazed, or open on the next room."""
    w, h = rng.uniform(0.65, 1.0), min(2.0 + rng.uniform(0, 0.2), wall.height - 0.1)
    part, leaf = wall.spot.part, wall.paints.hard(rng)
    bodies = [part((u, h / 2, 0), (w + 0.16, h + 0.08, 0.05), wall.frame)]
    handle = plain(np.ones(3) * rng.uniform(0.05, 0.8), 0.8)
    if rng.random() < 0.65:
        bodies.append(part((u, h / 2 - 0.02, 0), (w, h - 0.06, 0.06), leaf))
        bodies.append(part((u + w * 0.4, 1.0, 0.06), (0.12, 0.03, 0.05), handle))
        panel = wall.paints.of("slats", rng, 0.0) if rng.random() < 0.2 else leaf
        rows, columns = int(rng.integers(1, 4)), int(rng.integers(1, 3))
        for i in range(rows if rng.random() < 0.6 else 0):
            for j in range(columns):
                place = (u + (j + 0.5) * w / columns - w / 2, (i + 0.5) * h / rows, 0.03)
                size = (w / columns - 0.14, h / rows - 0.16, 0.02)
                bodies.append(part(place, size, panel))
        return bodies
    opening = part((u, h / 2 - 0.02, 0), (w, h - 0.04, 0.06), plain(np.zeros(3)))
    beyond = _next_room(wall, u, w, h, rng)
    bodies += [replace(opening, beyond=beyond), beyond]
    if rng.random() < 0.7:
        hinge = wall.spot.at(u - w / 2, 0.03, float(rng.uniform(-2.4, -0.6)))
        bodies.append(hinge.part((w / 2, h / 2, 0), (w, h - 0.06, 0.04), leaf))
    return bodies


def _next_room(wall: _Wall, u: float, w: float, h: float, rng: Rng) -> Body:
    """Return the hollow box of an empty room behind a door of size (w, h) at u."""
    size = np.array([w + rng.uniform(0.3, 4), max(h + 0.1, wall.height), rng.uniform(0.8, 5)])
    middle = u + rng.uniform(-0.5, 0.5) * (size[0] - w)
    paint, room = wall.paints.wall(rng), wall.room
    if rng.random() < 0.5:
        paint = room.paints[0]
    floor = room.paints[2] if rng.random() < 0.6 else wall.paints.floor(rng)
    sides = (paint, paint, floor, room.paints[3], paint, paint)
    # Its front is the opening's front, so that every ray that enters is inside.
    box = wall.spot.part((middle, size[1] / 2, 0.03 - size[2] / 2), size, paint)
    return replace(box, paints=sides, labels=room.labels, hollow=True)


def _flat(wall: _Wall, kind: str, u: float, rng: Rng) -> list[Body]:
    """Return a flat thing on a wall."""
    part, paints = wall.spot.part, wall.paints
    if kind == "mirror":
        w, h = rng.uniform(0.3, 1.4), rng.uniform(0.4, 1.5)
        y = max(rng.uniform(1.0, 1.7), h / 2 + 0.05)
        glass = plain(np.ones(3) * 0.05)
        bodies = [part((u, y, 0), (w, h, 0.04), glass, mirror=rng.uniform(0.75, 0.97))]
        if rng.random() < 0.7:
            bodies.append(part((u, y, 0), (w + 0.08, h + 0.08, 0.03), paints.thing(rng)))
        return bodies
    if kind == "radiator":
        w, h = rng.uniform(0.4, 1.6), rng.uniform(0.3, 0.7)
        white = plain(rng.uniform(0.4, 0.95) * np.exp(rng.normal(0, 0.03, 3)), 0.2)
        ribs = np.arange(-w / 2 + 0.05, w / 2, rng.uniform(0.05, 0.12))
        bodies = [part((u, 0.12 + h / 2, 0.05), (w, h, 0.06), white)]
        return bodies + [part((u + x, 0.12 + h / 2, 0.08), (0.03, h, 0.04), white) for x in ribs]
    if kind == "board":
        w, h = rng.uniform(1.0, 3.0), rng.uniform(0.8, 1.3)
        dark = plain(np.array([0.03, 0.06, 0.04]))
        white = plain(np.ones(3) * rng.uniform(0.6, 0.95), 0.5)
        top = [dark, white, paints.of("poster", rng, 0.0)][int(rng.integers(3))]
        return [
            part((u, 1.5, 0), (w + 0.06, h + 0.06, 0.03), wall.frame),
            part((u, 1.5, 0), (w, h, 0.04), top),
        ]
    if kind == "cupboard":
        return _cupboard(wall, u, rng)
    if kind == "switch":
        y = float(rng.choice([0.3, 1.1]))
        white = plain(np.ones(3) * rng.uniform(0.5, 0.95))
        return [part((u, y, 0), (0.09 * rng.integers(1, 3), 0.09, 0.02), white)]
    if kind == "clock":
        r = rng.uniform(0.2, 0.4)
        return [part((u, rng.uniform(1.7, 2.1), 0), (r, r, 0.06), paints.thing(rng), round=True)]
    return _pictures(wall, u, rng)


def _cupboard(wall: _Wall, u: float, rng: Rng) -> list[Body]:
    """Return a row of wall cupboards, or an open shelf of books."""
    w, h, d = rng.uniform(0.4, 2.0), rng.uniform(0.2, 0.9), rng.uniform(0.15, 0.4)
    y, paint = rng.uniform(1.4, 1.9), wall.paints.hard(rng)
    front = wall.paints.of("books", rng, 0.0) if rng.random() < 0.4 else paint
    doors = max(1, round(w / 0.5))
    bodies = [wall.spot.part((u, y, d / 2), (w, h, d), paint)]
    for k in range(doors):
        place = (u + (k + 0.5) * w / doors - w / 2, y, d)
        bodies.append(wall.spot.part(place, (w / doors - 0.02, h - 0.03, 0.02), front))
    return bodies


def _pictures(wall: _Wall, u: float, rng: Rng) -> list[Body]:
    """Return one picture or a group of them, framed or bare."""
    bodies = []
    framed = rng.random() < 0.7
    w, h = rng.uniform(0.15, 1.2), rng.uniform(0.2, 0.9)
    y = rng.uniform(1.0, 1.9)
    for k in range(int(rng.choice([1, 1, 2, 3]))):
        x = u + k * (w + 0.15)
        paint = wall.paints.of("poster", rng, 0.0)
        if framed:
            size = (w + 0.06, h + 0.06, 0.03)
            bodies.append(wall.spot.part((x, y, 0), size, wall.paints.thing(rng)))
        bodies.append(wall.spot.part((x, y, 0), (w, h, 0.04), paint))
    return bodies


def _outside(paints: Paints, rng: Rng) -> tuple[Paint, float]:
    """Return what a window shows and how it glows: burnt out, sky, a view, or night."""
    kind = rng.random()
    glow = float(rng.choice([0.6, 2.0, 6.0, 15.0], p=[0.2, 0.25, 0.35, 0.2]))
    if kind < 0.12:
        return plain(np.exp(rng.uniform(-5, -3)) * np.ones(3), 0.8), 0.2
    if kind < 0.45:
        return paints.of("poster", rng, 0.0), glow
    return plain(np.clip(rng.uniform(0.3, 1.0) * np.array([0.9, 0.97, 1.05]), 0, 1)), glow


def _window(wall: _Wall, u: float, found: Hung, rng: Rng) -> None:
    """Add a window with panes, often curtains or a blind, and its daylight."""
    part, paints = wall.spot.part, wall.paints
    w = min(rng.uniform(0.5, 3.2), 0.9 * wall.length)
    h = min(rng.uniform(0.6, 2.0), wall.height - 0.3)
    low = 0.1 if h > 1.6 else rng.uniform(0.5, 1.1)
    y = min(low + h / 2, wall.height - 0.05 - h / 2)
    outside, glow = _outside(paints, rng)
    pane = part((u, y, 0), (w, h, 0.07), outside, glow=glow)
    found.panes.append(pane)
    found.bodies.append(part((u, y, 0), (w + 0.14, h + 0.14, 0.06), wall.frame))
    found.bodies.append(pane)
    bar = rng.uniform(0.03, 0.08)
    columns, rows = int(rng.integers(1, 5)), int(rng.integers(1, 4))
    for i in range(1, columns):
        found.bodies.append(part((u - w / 2 + i * w / columns, y, 0), (bar, h, 0.1), wall.frame))
    for i in range(1, rows):
        found.bodies.append(part((u, y - h / 2 + i * h / rows, 0), (w, bar, 0.1), wall.frame))
    if rng.random() < 0.4:
        found.bodies.append(part((u, y - h / 2 - 0.05, 0), (w + 0.2, 0.04, 0.4), wall.frame))
    dressing = rng.random()
    if dressing < 0.45:
        found.bodies.extend(_curtains(wall, u, y, w, h, rng))
    elif dressing < 0.65:
        drop = h * rng.uniform(0.2, 1.0)
        slats = paints.of("slats", rng, 0.0)
        place, size = (u, y + h / 2 - drop / 2, 0.05), (w, drop, 0.03)
        found.bodies.append(part(place, size, slats, glow=glow * rng.uniform(0, 0.3)))
    centre = wall.spot.world((u, y, 0.35))
    strength = np.exp(rng.normal(0.5, 0.8)) * min(glow, 2.0)
    found.lamps.append(Lamp(centre, strength * np.array([0.95, 1.0, 1.05]), 0.6))


def _curtains(wall: _Wall, u: float, y: float, w: float, h: float, rng: Rng) -> list[Body]:
    """Return two curtains with folds, or a net curtain over the whole window."""
    cloth = wall.paints.of("folds", rng, 0.0)
    bottom = float(rng.choice([0.02, max(0.05, y - h / 2 - 0.15)]))
    top = min(y + h / 2 + rng.uniform(0.05, 0.3), wall.height - 0.02)
    middle, drop = (top + bottom) / 2, top - bottom
    if rng.random() < 0.25:
        glow = float(rng.choice([0.0, 0.8, 2.0]))
        return [wall.spot.part((u, middle, 0.1), (w * 1.1, drop, 0.05), cloth, glow=glow)]
    bodies = [wall.spot.part((u, top, 0.1), (w + 0.8, 0.03, 0.03), wall.paints.thing(rng))]
    for side in (-1, 1):
        wide = rng.uniform(0.15, 0.7)
        place = (u + side * (w / 2 + 0.05), middle, 0.1)
        bodies.append(wall.spot.part(place, (wide, drop, rng.uniform(0.05, 0.14)), cloth))
    return bodies


def _glazing(wall: _Wall, u: float, found: Hung, rng: Rng) -> None:
    """Add a glazed partition of several bays, from near the floor to near the ceiling."""
    low = float(rng.choice([0.05, 0.9]))
    high = wall.height - float(rng.choice([0.02, 0.4]))
    bays = int(rng.integers(2, 6))
    wide = min(wall.length, bays * rng.uniform(0.6, 1.2))
    u = float(np.clip(u, (wide - wall.length) / 2, (wall.length - wide) / 2))
    y, h = (low + high) / 2, high - low
    paint = wall.paints.of("poster", rng, 0.0)
    glass = wall.spot.part(
        (u, y, 0), (wide, h, 0.06), paint, glow=rng.uniform(0.1, 2.0), mirror=0.3
    )
    found.bodies.append(glass)
    for k in range(bays + 1):
        x = u - wide / 2 + k * wide / bays
        found.bodies.append(wall.spot.part((x, y, 0), (0.06, h + 0.1, 0.1), wall.frame))
    for edge in (low, high, low + 0.45 * h):
        found.bodies.append(wall.spot.part((u, edge, 0), (wide, 0.06, 0.1), wall.frame))
