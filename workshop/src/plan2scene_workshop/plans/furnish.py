"""Furniture and fixtures of a drawn plan: where they stand, and how they are drawn."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry import Polygon

from plan2scene.plans.geometry import ring_edges
from plan2scene_workshop.plans.sheet import Sheet
from plan2scene_workshop.plans.structure import Structure
from plan2scene_workshop.plans.style import PlanStyle
from plan2scene_workshop.plans.symbols import PIECES, SYMBOLS, Symbol

_TRIES = 6


def furnish(sheet: Sheet, plan: Structure, style: PlanStyle, rng: np.random.Generator) -> None:
    """Draw pieces in the rooms, clear of doors and of one another."""
    clear = [Polygon(gap.corners(gap.depth + 1.1)) for gap in plan.gaps if gap.kind != "window"]
    for room, types in zip(plan.rooms, plan.types, strict=True):
        free = room.buffer(-plan.inner_depth / 2 - 0.02).difference(shapely.union_all(clear))
        names = [name for kind in types for name in PIECES[kind]]
        for name in names:
            if rng.random() < 0.25:
                continue
            placed = place(SYMBOLS[name], room, free, plan.inner_depth / 2 + 0.03, rng)
            if placed is None:
                continue
            piece, (width, depth), frame = placed
            free = free.difference(piece.buffer(0.05))
            if style.furniture == "filled":
                sheet.fill(np.array(piece.exterior.coords)[:-1], style.tint)
            for line in SYMBOLS[name].draw(rng, width, depth):
                sheet.line(line @ frame[:2] + frame[2], style.pen, style.thin)


def place(
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
