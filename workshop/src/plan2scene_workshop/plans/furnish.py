"""Furniture and fixtures of a drawn plan: what stands where, and how it is drawn."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import shapely
from shapely.geometry import Polygon

from plan2scene.plans.geometry import ring_edges
from plan2scene_workshop.plans.sheet import Sheet
from plan2scene_workshop.plans.structure import Structure
from plan2scene_workshop.plans.style import PlanStyle
from plan2scene_workshop.plans.symbols import PIECES, SYMBOLS, Symbol

_TRIES = 6
#: What stands at a wall and is solid: a chimney breast or pillar, the end of a wall; in metres.
_BREAST = Symbol("breast", (0.25, 1.4), (0.15, 0.5), lambda *_: [])
_STUB = Symbol("stub", (0.06, 0.16), (0.3, 1.6), lambda *_: [])


def with_blocks(plan: Structure, chance: float, rng: np.random.Generator) -> Structure:
    """Return a plan with a solid block in each room indoors by `chance`, clear of openings."""
    clear = shapely.union_all([Polygon(gap.corners(gap.depth + 1.1)) for gap in plan.gaps])
    blocks = []
    for index, room in enumerate(plan.rooms):
        if not plan.indoor(index) or rng.random() >= chance:
            continue
        kind = _BREAST if rng.random() < 0.6 else _STUB
        free = room.buffer(-plan.inner_depth / 2 + 0.01).difference(clear)
        placed = _place(kind, room, free, plan.inner_depth / 2, rng)
        if placed is not None:
            blocks.append(placed[0])
    return replace(plan, blocks=shapely.union_all(blocks))


def furnish(sheet: Sheet, plan: Structure, style: PlanStyle, rng: np.random.Generator) -> None:
    """Draw pieces in the rooms, clear of doors and of one another."""
    clear = [Polygon(gap.corners(gap.depth + 1.1)) for gap in plan.gaps if gap.kind != "window"]
    taken = shapely.union_all([*clear, plan.blocks])
    for room, types in zip(plan.rooms, plan.types, strict=True):
        free = room.buffer(-plan.inner_depth / 2 - 0.02).difference(taken)
        names = [name for kind in types for name in PIECES[kind]]
        for name in names:
            if rng.random() < 0.25:
                continue
            placed = _place(SYMBOLS[name], room, free, plan.inner_depth / 2 + 0.03, rng)
            if placed is None:
                continue
            piece, (width, depth), frame = placed
            free = free.difference(piece.buffer(0.05))
            outline = np.array(piece.exterior.coords)[:-1]
            if style.furniture == "filled":
                sheet.fill(outline, style.tint)
            elif style.furniture == "shaded":
                _shaded(sheet, outline, rng)
            for line in SYMBOLS[name].draw(rng, width, depth):
                sheet.line(line @ frame[:2] + frame[2], style.pen, style.thin)


def _shaded(sheet: Sheet, outline: np.ndarray, rng: np.random.Generator) -> None:
    """Fill a piece (4, 2) in a colour of its own with a lighter middle, on its shadow."""
    colour = rng.integers(60, 240) + rng.integers(-30, 31, 3)
    shadow = outline + rng.uniform(0.02, 0.08)
    place = sheet.window(Polygon(shadow))
    before = sheet.image[place].copy()
    sheet.fill(shadow, (0, 0, 0))
    sheet.image[place] = cv2.addWeighted(before, 0.7, sheet.image[place], 0.3, 0)
    middle = outline.mean(0)
    for share, gain in ((1.0, 1.0), (0.8, 1.07), (0.5, 1.12)):
        tone = np.clip(colour * gain, 0, 255)
        sheet.fill(middle + share * (outline - middle), tuple(int(v) for v in tone))


def _place(
    symbol: Symbol, room: Polygon, free: shapely.Geometry, gap: float, rng: np.random.Generator
) -> tuple[Polygon, tuple[float, float], np.ndarray] | None:
    """Return outline, size and frame (rows: x axis, y axis, origin) of a piece that fits."""
    edges = ring_edges(tuple(room.exterior.coords[:-1]))
    for _ in range(_TRIES):
        width, depth = float(rng.uniform(*symbol.width)), float(rng.uniform(*symbol.depth))
        start, end = (np.array(p) for p in edges[int(rng.integers(len(edges)))])
        length = float(np.linalg.norm(end - start))
        if length < width + 2 * gap:
            continue
        along = (end - start) / length
        inward = np.array([-along[1], along[0]])
        if not room.contains(shapely.Point((start + end) / 2 + 0.05 * inward)):
            inward = -inward
        offset = float(rng.uniform(gap, length - width - gap))
        if rng.random() < 0.5:
            offset = gap if rng.random() < 0.5 else length - width - gap
        back = gap + (float(rng.uniform(0.3, 1.5)) if symbol.free else 0.0)
        origin = start + offset * along + back * inward
        frame = np.array([along, inward, origin])
        corners = np.array([(0, 0), (width, 0), (width, depth), (0, depth)]) @ frame[:2] + origin
        piece = Polygon(corners)
        if free.contains(piece):
            return piece, (width, depth), frame
    return None
