"""Replaces some doors of a plan by open passages, at most as wide as the wall allows."""

from __future__ import annotations

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon

from plan2scene_workshop.homes.openings import OPEN_AIR

#: Metres of wall between a passage and corners or other openings; largest width of a passage.
_FREE, _WIDEST = 0.15, 5.0
#: Probability that a passage takes all the free wall (up to `_WIDEST`).
_WHOLE = 0.3


def opened_doors(
    spans: list[tuple[str, LineString]],
    rooms: list[Polygon],
    types: tuple[tuple[str, ...], ...],
    rng: np.random.Generator,
    chance: float,
) -> list[tuple[str, LineString]]:
    """Return openings (kind, line); each door between indoor rooms is a passage with `chance`."""
    found = list(spans)
    for index, (kind, line) in enumerate(spans):
        if kind != "door" or rng.random() >= chance:
            continue
        shared = _shared_wall(line, rooms, types)
        if shared is None:
            continue
        others = [other for k, (_, other) in enumerate(found) if k != index]
        free = shared.difference(shapely.union_all(others).buffer(_FREE)) if others else shared
        middle = line.centroid
        pieces = [p for p in shapely.get_parts(free) if p.distance(middle) < 0.01]
        if not pieces:
            continue
        ends = np.array(pieces[0].coords)[[0, -1]]
        length = float(np.linalg.norm(ends[1] - ends[0])) - 2 * _FREE
        if length < line.length:
            continue
        way = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        width = min(length, _WIDEST)
        if rng.random() >= _WHOLE:
            width = float(rng.uniform(line.length, width))
        start = ends[0] + way * (_FREE + float(rng.uniform(0, length - width)))
        found[index] = ("passage", LineString([start, start + way * width]))
    return found


def _shared_wall(
    line: LineString, rooms: list[Polygon], types: tuple[tuple[str, ...], ...]
) -> LineString | None:
    """Return the straight wall that the two rooms of a door share; None unless both are indoor."""
    middle = line.centroid
    beside = [
        room
        for room, kinds in zip(rooms, types, strict=True)
        if kinds[0] not in OPEN_AIR and room.exterior.distance(middle) < 0.02
    ]
    if len(beside) != 2:
        return None
    band = beside[0].exterior.intersection(beside[1].exterior.buffer(0.02, cap_style="flat"))
    way = np.diff(np.array(line.coords), axis=0)[0] / line.length
    start = np.array(line.coords)[0]
    for piece in shapely.get_parts(band):
        places = (
            np.array(piece.coords) - start if isinstance(piece, LineString) else np.zeros((0, 2))
        )
        if len(places) < 2:
            continue
        off = np.abs(places @ np.array([-way[1], way[0]]))
        along = (places @ way)[off < 0.03]
        if len(along) > 1 and along.min() < 0 and along.max() > line.length:
            return LineString([start + way * along.min(), start + way * along.max()])
    return None
