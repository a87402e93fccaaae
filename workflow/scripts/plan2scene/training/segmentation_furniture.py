"""What stands and hangs in a room of boxes; all of it is labelled other."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from plan2scene.training.segmentation_paints import Paints
from plan2scene.training.segmentation_raycast import Array, Body, Paint, plain
from plan2scene.training.segmentation_spots import Spot

Rng = np.random.Generator


def _legs(spot: Spot, w: float, d: float, h: float, paint: Paint, rng: Rng) -> list[Body]:
    """Return four legs under a top of w x d at height h."""
    t = rng.uniform(0.025, 0.08)
    return [
        spot.part((sx * (w - t) / 2, h / 2, sz * (d - t) / 2), (t, h, t), paint)
        for sx in (-1, 1)
        for sz in (-1, 1)
    ]


def _table(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    w, d, h = rng.uniform(0.4, 2.0), rng.uniform(0.4, 1.0), rng.uniform(0.35, 0.95)
    top = paints.thing(rng)
    things = [spot.part((0, h, 0), (w, rng.uniform(0.02, 0.06), d), top)]
    things += _legs(spot, w, d, h, top if rng.random() < 0.6 else paints.thing(rng), rng)
    return things + _clutter(spot, w, d, h, paints, rng)


def _clutter(spot: Spot, w: float, d: float, h: float, paints: Paints, rng: Rng) -> list[Body]:
    """Return small things on a top."""
    things = []
    for _ in range(int(rng.integers(0, 6))):
        size = rng.uniform(0.04, 0.35, 3)
        place = (rng.uniform(-0.4, 0.4) * w, h + size[1] / 2, rng.uniform(-0.4, 0.4) * d)
        things.append(spot.part(place, size, paints.thing(rng), round=rng.random() < 0.4))
    return things


def _chair(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    w, h, paint = rng.uniform(0.38, 0.55), rng.uniform(0.4, 0.5), paints.thing(rng)
    back = rng.uniform(0.3, 0.6)
    return [
        spot.part((0, h, 0), (w, rng.uniform(0.03, 0.12), w), paints.thing(rng)),
        spot.part((0, h + back / 2 + 0.1, -w / 2), (w, back, 0.04), paint),
        *_legs(spot, w, w, h, paint, rng),
    ]


def _sofa(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    w, d, paint = rng.uniform(0.8, 2.6), rng.uniform(0.75, 1.0), paints.thing(rng)
    seat, back, arm = rng.uniform(0.35, 0.48), rng.uniform(0.7, 1.0), rng.uniform(0.1, 0.25)
    things = [
        spot.part((0, seat / 2, 0), (w, seat, d), paint),
        spot.part((0, back / 2, -d / 2), (w, back, 0.2), paint),
    ]
    for side in (-1, 1):
        things.append(spot.part((side * w / 2, 0.3, 0), (arm, 0.6, d), paint))
    for _ in range(int(rng.integers(0, 4))):
        place = (rng.uniform(-0.4, 0.4) * w, seat + 0.18, -d / 4)
        things.append(spot.part(place, (0.45, 0.4, 0.2), paints.thing(rng), round=True))
    return things


def _bed(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    w, h, cover = rng.uniform(0.9, 1.9), rng.uniform(0.35, 0.6), paints.thing(rng)
    white = plain(rng.uniform(0.5, 0.95) * np.ones(3))
    things = [
        spot.part((0, h / 4, 0), (w, h / 2, 2.0), paints.thing(rng)),
        spot.part((0, h * 0.75, 0), (w, h / 2, 2.0), white),
        spot.part((0, h + 0.03, 0.25), (w + 0.06, 0.1, 1.5), cover),
        spot.part((0, h + 0.25, -1.0), (w, rng.uniform(0.3, 0.9), 0.06), paints.thing(rng)),
    ]
    for side in (-1, 1):
        things.append(
            spot.part((side * w / 4, h + 0.1, -0.75), (w * 0.45, 0.18, 0.4), white, round=True)
        )
    return things


def _cabinet(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    w, d = rng.uniform(0.4, 2.4), rng.uniform(0.3, 0.65)
    h = float(rng.choice([rng.uniform(0.4, 1.0), rng.uniform(1.4, 2.4)]))
    paint = paints.thing(rng)
    front = paint if rng.random() < 0.5 else paints.thing(rng)
    columns, rows = int(rng.integers(1, 5)), int(rng.integers(1, 5))
    things = [spot.part((0, h / 2, 0), (w, h, d), paint)]
    for i in range(columns):
        for j in range(rows):
            cell = (w / columns, h / rows)
            place = ((i + 0.5) * cell[0] - w / 2, (j + 0.5) * cell[1], d / 2)
            things.append(spot.part(place, (cell[0] - 0.02, cell[1] - 0.02, 0.025), front))
    return things + _clutter(spot, w, d, h, paints, rng)


def _shelf(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    w, d, h, paint = rng.uniform(0.5, 1.8), 0.3, rng.uniform(0.8, 2.2), paints.thing(rng)
    things = [spot.part((s * w / 2, h / 2, 0), (0.03, h, d), paint) for s in (-1, 1)]
    if rng.random() < 0.6:
        things.append(spot.part((0, h / 2, -d / 2), (w, h, 0.01), paints.thing(rng)))
    levels = int(rng.integers(2, 6))
    for j in range(levels + 1):
        y = h * j / levels
        things.append(spot.part((0, y, 0), (w, 0.03, d), paint))
        for _ in range(int(rng.integers(0, 5)) if j < levels else 0):
            size = (rng.uniform(0.05, 0.4) * w, rng.uniform(0.3, 0.9) * h / levels, 0.2)
            place = (rng.uniform(-0.3, 0.3) * w, y + size[1] / 2, 0)
            things.append(spot.part(place, size, paints.thing(rng)))
    return things


def _plant(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    things = [spot.part((0, 0.2, 0), (0.3, 0.4, 0.3), paints.thing(rng), round=rng.random() < 0.5)]
    h, spread = rng.uniform(0.6, 1.9), rng.uniform(0.15, 0.45)
    for _ in range(int(rng.integers(8, 22))):
        green = np.array([0.1, 0.25, 0.06]) * np.exp(rng.normal(0, 0.4, 3))
        place = (rng.normal(0, spread), rng.uniform(0.35, h), rng.normal(0, spread))
        things.append(spot.part(place, rng.uniform(0.06, 0.35, 3), plain(green), round=True))
    return things


def _floor_lamp(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    h, paint = rng.uniform(1.2, 1.8), paints.thing(rng)
    return [
        spot.part((0, 0.015, 0), (0.3, 0.03, 0.3), paint),
        spot.part((0, h / 2, 0), (0.03, h, 0.03), paint),
        spot.part(
            (0, h, 0),
            (0.4, 0.35, 0.4),
            plain(np.array([0.9, 0.85, 0.7])),
            round=True,
            glow=float(rng.choice([0.0, 2.0])),
        ),
    ]


def _heap(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a heap of anything: boxes and ellipsoids of all sizes."""
    things, y = [], 0.0
    for _ in range(int(rng.integers(1, 5))):
        size = rng.uniform(0.1, 0.9, 3)
        place = (rng.normal(0, 0.2), y + size[1] / 2, rng.normal(0, 0.2))
        things.append(spot.part(place, size, paints.thing(rng), round=rng.random() < 0.35))
        y += float(size[1]) * 0.9
    return things


def _rug(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    size = (rng.uniform(0.8, 3.0), 0.015, rng.uniform(0.6, 2.2))
    paint = paints.of("carpet", rng) if rng.random() < 0.6 else paints.thing(rng)
    border = spot.part((0, 0.004, 0), (size[0] + 0.12, 0.012, size[2] + 0.12), paints.thing(rng))
    return [spot.part((0, 0.008, 0), size, paint), *([border] if rng.random() < 0.5 else [])]


_MAKERS: Sequence[tuple[float, Callable[[Spot, Paints, Rng], list[Body]]]] = (
    (2.0, _table),
    (2.5, _chair),
    (1.5, _sofa),
    (1.0, _bed),
    (2.5, _cabinet),
    (1.0, _shelf),
    (0.8, _plant),
    (0.8, _floor_lamp),
    (1.5, _heap),
    (1.0, _rug),
)


def furnish(half: Array, paints: Paints, rng: Rng) -> list[Body]:
    """Return up to fifteen pieces of furniture; most stand along a wall and face the room.

    Parameters
    ----------
    half : (3,) float64
        Half the room's size in metres; the room is centred on x = z = 0, its floor at y = 0.
    """
    weights = np.array([weight for weight, _ in _MAKERS])
    bodies: list[Body] = []
    for _ in range(int(rng.integers(1, 16))):
        make = _MAKERS[int(rng.choice(len(_MAKERS), p=weights / weights.sum()))][1]
        place = rng.uniform(-0.85, 0.85, 2) * half[[0, 2]]
        yaw = rng.uniform(0, 2 * np.pi)
        if rng.random() < 0.7:
            axis, sign = int(rng.integers(2)), int(rng.choice([-1, 1]))
            place[axis] = sign * (half[2 * axis] - rng.uniform(0.2, 0.5))
            # The back is at -z of the piece's frame and stands against the wall.
            yaw = [-sign * np.pi / 2, np.pi * (sign > 0)][axis] + rng.normal(0, 0.02)
        bodies += make(Spot(float(place[0]), float(place[1]), float(yaw)), paints, rng)
    return bodies
