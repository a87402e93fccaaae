"""Chairs, sofas and beds of drawn rooms; the back of each is at -z of its spot."""

from __future__ import annotations

import numpy as np

from plan2scene_workshop.segmentation.bodies import (
    Body,
    Paint,
    plain,
)
from plan2scene_workshop.segmentation.paints import Paints
from plan2scene_workshop.segmentation.spots import Spot
from plan2scene_workshop.segmentation.stencils import bars, disc, rag

Rng = np.random.Generator


def legs(spot: Spot, w: float, d: float, h: float, paint: Paint, rng: Rng) -> list[Body]:
    """Return what carries a top of w x d at height h: legs, two frames, or one foot."""
    t = float(rng.uniform(0.02, 0.08))
    kind = rng.random()
    if kind < 0.7:
        return [
            spot.part((sx * (w - t) / 2, h / 2, sz * (d - t) / 2), (t, h, t), paint)
            for sx in (-1, 1)
            for sz in (-1, 1)
        ]
    if kind < 0.88:
        ends = []
        for side in (-1, 1):
            x = side * (w / 2 - t)
            if rng.random() < 0.5:
                ends.append(spot.part((x, h / 2, 0), (t, h, d * 0.9), paint))
            else:
                ends.append(spot.part((x, h / 2, 0), (t, h, t), paint))
                ends.append(spot.part((x, 0.02, 0), (t, 0.04, d * 0.9), paint))
        return ends
    return [
        spot.part((0, h / 2, 0), (2 * t, h, 2 * t), paint),
        spot.part((0, 0.02, 0), (w / 2, 0.04, d / 2), paint),
    ]


def chair(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a chair with a solid or barred back, or a stool."""
    w, h, paint = rng.uniform(0.38, 0.52), rng.uniform(0.4, 0.5), paints.hard(rng)
    seat = paint if rng.random() < 0.5 else paints.cloth(rng)
    top = (w, rng.uniform(0.02, 0.1), w)
    if rng.random() < 0.15:
        high = h * rng.uniform(0.9, 1.6)
        return [
            spot.part((0, high, 0), (w * 0.8, 0.012, w * 0.8), seat, stencil=disc()),
            *legs(spot, w * 0.6, w * 0.6, high, paint, rng),
        ]
    back, tilt = rng.uniform(0.3, 0.6), rng.uniform(0, 0.2)
    shape = bars(rng) if rng.random() < 0.4 else None
    things = [
        spot.part((0, h, 0), top, seat),
        spot.part(
            (0, h + back / 2 + 0.05, -w / 2), (w, back, 0.03), paint, tilt=-tilt, stencil=shape
        ),
    ]
    if rng.random() < 0.2:
        things += [spot.part((s * w / 2, h + 0.2, 0), (0.05, 0.04, w), paint) for s in (-1, 1)]
    return things + legs(spot, w, w, h, paint, rng)


def office_chair(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a swivel chair on a star of castors."""
    cloth = plain(np.exp(rng.uniform(-4, -1.5, 3).mean() + rng.normal(0, 0.3, 3)))
    dark = plain(np.ones(3) * rng.uniform(0.01, 0.4), 0.4)
    h, back = rng.uniform(0.42, 0.52), rng.uniform(0.4, 0.7)
    if rng.random() < 0.3:
        cloth = paints.cloth(rng)
    things = [
        spot.part((0, h, 0), (0.48, 0.09, 0.46), cloth),
        spot.part((0, h + 0.12 + back / 2, -0.23), (0.44, back, 0.06), cloth, tilt=-0.15),
        spot.part((0, h / 2, 0), (0.05, h, 0.05), dark),
    ]
    for k in range(3):
        turn = float(k * np.pi / 3)
        things.append(spot.part((0, 0.07, 0), (0.62, 0.04, 0.05), dark, turn=turn))
        for side in (-1, 1):
            wheel = (side * 0.29 * np.cos(turn), 0.03, -side * 0.29 * np.sin(turn))
            things.append(spot.part(wheel, (0.06, 0.06, 0.06), dark, round=True))
    if rng.random() < 0.6:
        for side in (-1, 1):
            things.append(spot.part((side * 0.27, h + 0.2, 0), (0.05, 0.03, 0.28), dark))
            things.append(spot.part((side * 0.27, h + 0.1, 0), (0.03, 0.2, 0.04), dark))
    return things


def sofa(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return an armchair or sofa, at times with an L, on legs, with cushions and a throw."""
    w, d, paint = rng.uniform(0.7, 2.7), rng.uniform(0.75, 1.0), paints.cloth(rng)
    seat, back, arm = rng.uniform(0.35, 0.48), rng.uniform(0.65, 1.0), rng.uniform(0.08, 0.25)
    foot = float(rng.choice([0.0, 0.08, 0.15]))
    things = [
        spot.part((0, (seat + foot) / 2, 0), (w, seat - foot, d), paint),
        spot.part((0, (back + foot) / 2, -d / 2 + 0.1), (w, back - foot, 0.2), paint, tilt=-0.08),
    ]
    if foot:
        things += legs(spot, w * 0.95, d * 0.9, foot, paints.hard(rng), rng)[:4]
    for side in (-1, 1) if rng.random() < 0.8 else ():
        high = seat + rng.uniform(0.1, 0.25)
        things.append(spot.part((side * w / 2, (high + foot) / 2, 0), (arm, high - foot, d), paint))
    if w > 1.7 and rng.random() < 0.4:
        side = rng.choice([-1, 1])
        place = (side * (w / 2 - 0.4), (seat + foot) / 2, d * 0.8)
        things.append(spot.part(place, (0.8, seat - foot, d), paint))
    gap = w / max(1, round(w / 0.7))
    for x in np.arange(-w / 2 + gap / 2, w / 2, gap):
        things.append(spot.part((x, seat + 0.04, 0.06), (gap - 0.03, 0.12, d - 0.15), paint))
    for _ in range(int(rng.integers(0, 5))):
        place = (rng.uniform(-0.4, 0.4) * w, seat + 0.24, -d / 4)
        soft = rng.random() < 0.5
        tilt = rng.uniform(-0.7, -0.2)
        size = (0.45, 0.4, 0.16)
        things.append(spot.part(place, size, paints.cloth(rng), round=soft, tilt=tilt))
    if rng.random() < 0.25:
        size = (0.7, 0.01, 0.8)
        things.append(spot.part((0, seat + 0.11, 0.1), size, paints.cloth(rng), stencil=rag(rng)))
    return things


def bed(spot: Spot, paints: Paints, rng: Rng) -> list[Body]:
    """Return a bed with a cover of any pattern, pillows, a headboard, at times a bunk or posts."""
    w, h, cover = rng.uniform(0.8, 1.9), rng.uniform(0.3, 0.65), paints.cloth(rng)
    sheet = paints.cloth(rng) if rng.random() < 0.4 else plain(rng.uniform(0.4, 0.95) * np.ones(3))
    frame = paints.hard(rng)
    long = rng.uniform(1.1, 1.9)
    hang = rng.uniform(0.05, h)
    things = [
        spot.part((0, h * 0.3, 0), (w, h * 0.4, 2.0), frame),
        spot.part((0, h * 0.75, 0), (w * 0.98, h / 2, 1.98), sheet),
        spot.part(
            (0, h + 0.05 - hang / 2, 1.0 - long / 2), (w + 0.06, hang + 0.1, long + 0.04), cover
        ),
    ]
    if rng.random() < 0.75:
        high, shape = rng.uniform(0.2, 0.9), bars(rng) if rng.random() < 0.3 else None
        size = (w + rng.uniform(0, 0.4), high + h, 0.05)
        paint = paints.cloth(rng) if rng.random() < 0.4 else frame
        things.append(spot.part((0, (h + high) / 2, -1.02), size, paint, stencil=shape))
    for row in range(int(rng.integers(1, 4))):
        pillow = sheet if rng.random() < 0.5 else paints.cloth(rng)
        for side in (-1, 1) if w > 1.2 else (0,):
            place = (side * w / 4, h + 0.1 + 0.06 * row, -0.8 + 0.22 * row)
            size = (min(w * 0.45, 0.7), 0.2, 0.42)
            tilt = rng.uniform(-0.9, 0)
            things.append(spot.part(place, size, pillow, round=True, tilt=tilt))
    for _ in range(int(rng.integers(0, 4))):  # folds, clothes, throws on the cover
        place = (rng.uniform(-0.4, 0.4) * w, h + 0.1, rng.uniform(-0.2, 0.9))
        fold = (rng.uniform(0.2, 0.9), rng.uniform(0.03, 0.16), rng.uniform(0.2, 0.7))
        paint = cover if rng.random() < 0.6 else paints.cloth(rng)
        things.append(spot.part(place, fold, paint, round=True, turn=rng.uniform(0, 3)))
    if rng.random() < 0.12:
        high = h + rng.uniform(0.8, 1.1)
        things.append(spot.part((0, high, 0), (w, 0.2, 2.0), cover))
        things += legs(spot, w, 2.0, high, frame, rng)
    return things
