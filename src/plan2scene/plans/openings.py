"""Openings given as segments in the plan: which walls they lie on, and where."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plan2scene.house import Opening, Point, Wall
from plan2scene.plans.parse import Source

#: A segment and its wall may differ in direction by this angle (radians).
MAX_ANGLE = math.radians(20.0)
MIN_SHARE = 0.5  #: A wall that holds less than this share of an opening does not match


@dataclass(frozen=True)
class Segment:
    """An opening as drawn: a segment (x, z) in metres with heights above the floor."""

    id: str
    kind: str
    start: Point
    end: Point
    bottom: float
    top: float


@dataclass(frozen=True)
class _Match:
    """Where a segment falls on a wall: metres along it (uncut) and the mean distance from it."""

    wall: int
    start: float
    end: float
    distance: float


def place_openings(
    source: Source,
    walls: Sequence[Wall],
    segments: Sequence[Segment],
    *,
    tolerance: float = 0.2,
    both_sides: bool = True,
) -> list[Wall]:
    """Return the walls with the segments' openings on them.

    A segment goes to the nearest wall within `tolerance` metres that has its direction and holds at
    least half of it. With `both_sides`, if two rooms each have a wall of their own there, both
    walls get the hole, with one id. A part beyond the wall's end is cut off with a warning.

    Raises InputError for a segment without length or without a wall.
    """
    placed: dict[int, list[Opening]] = {}
    lines = np.array([(*wall.start, *wall.end, wall.length) for wall in walls]).reshape(-1, 5)
    for segment in segments:
        matches = _matches(lines, segment)
        near = sorted((m for m in matches if m.distance <= tolerance), key=lambda m: m.distance)
        if not near:
            nearest = min((m.distance for m in matches), default=math.inf)
            found = f"the nearest at {nearest:.2f} m" if matches else "none along it"
            raise source.fault(f"a wall within {tolerance:g} m of opening {segment.id}", found)
        for match in _one_per_side(walls, near) if both_sides else near[:1]:
            wall = walls[match.wall]
            start, end = max(match.start, 0.0), min(match.end, wall.length)
            if max(start - match.start, match.end - end) > 1e-3:
                source.warn(
                    f"opening {segment.id} within its wall {wall.id} of {wall.length:.3f} m",
                    f"{match.start:.3f} to {match.end:.3f} m, cut",
                    wall.room_ids[0],
                )
            opening = Opening(segment.id, segment.kind, start, end, segment.bottom, segment.top)
            placed.setdefault(match.wall, []).append(opening)
    return [
        replace(wall, openings=wall.openings + tuple(placed[k])) if k in placed else wall
        for k, wall in enumerate(walls)
    ]


def _matches(lines: np.ndarray, segment: Segment) -> list[_Match]:
    """Return where a segment lies on each of the walls that have its direction.

    `lines` is (n, 5) float: x and z of a wall's start and of its end, and its length, metres.
    """
    x0, z0, x1, z1, length = lines.T
    ux, uz = (x1 - x0) / length, (z1 - z0) / length
    along, across = [], []
    for x, z in (segment.start, segment.end):
        dx, dz = x - x0, z - z0
        along.append(dx * ux + dz * uz)
        across.append(dx * -uz + dz * ux)
    low, high = np.minimum(*along), np.maximum(*along)
    straight = np.abs(across[1] - across[0]) <= math.tan(MAX_ANGLE) * (high - low)
    inside = np.minimum(high, length) - np.maximum(low, 0.0)
    distance = np.abs(across[0] + across[1]) / 2
    is_match = straight & (high > low) & (inside >= MIN_SHARE * (high - low))
    return [
        _Match(int(k), float(low[k]), float(high[k]), float(distance[k]))
        for k in np.flatnonzero(is_match)
    ]


def _one_per_side(walls: Sequence[Wall], near: list[_Match]) -> list[_Match]:
    """Return the nearest match, and the nearest of another room if both have their own walls."""
    chosen = [near[0]]
    if len(walls[near[0].wall].room_ids) == 1:
        first = walls[near[0].wall].room_ids
        others = (m for m in near[1:] if len(walls[m.wall].room_ids) == 1)
        chosen += [m for m in others if walls[m.wall].room_ids != first][:1]
    return chosen
