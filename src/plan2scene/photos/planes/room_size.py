"""What a room's size in the plan says about the scale of a photo."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plan2scene.house import Room
from plan2scene.photos.planes.wall_lines import WallLine

#: Share of its bounding rectangle that a room must fill for its extent to mean something.
MIN_FILLED = 0.9
#: Bins of azimuth in which a wall must be seen to count.
MIN_BINS = 8
#: A camera stands at least so far from the wall behind it, metres.
CLEARANCE_M = 0.3
#: Spread of the log ratio between a span seen and the plan's, and the cost's bound.
SPREAD = 0.06
BOUND = 9.0


@dataclass(frozen=True)
class RoomSize:
    """A room's height and extent (the sides of its rectangle, None where unknown), metres."""

    height_m: float
    extent_m: tuple[float, float] | None = None

    @classmethod
    def of(cls, room: Room) -> RoomSize:
        """Return the size of a room of the plan."""
        return cls(room.height, room_extent(room))


def room_extent(room: Room) -> tuple[float, float] | None:
    """Return the sides in metres of a room's rectangle; None for one that is no rectangle."""
    from plan2scene.plans.geometry import room_polygon

    outline = room_polygon(room)
    box = outline.minimum_rotated_rectangle
    if outline.area <= 0.0 or box.geom_type != "Polygon" or outline.area < MIN_FILLED * box.area:
        return None
    corners = np.array(box.exterior.coords)
    first, second = np.linalg.norm(np.diff(corners, axis=0), axis=1)[:2].tolist()
    return float(first), float(second)


def wall_spans(
    lines: Sequence[WallLine], path: np.ndarray, foot: np.ndarray
) -> list[tuple[float, bool]]:
    """Return per Manhattan axis how far the walls reach, and whether on both sides.

    `path` (b,) int is the wall, of `lines`, of each bin of azimuth; `foot` (b,) bool the bins that
    show a wall's foot: only those count. Returns the distance in metres between opposite walls and
    True, that of the only wall from the camera and False, or (0, False).
    """
    count = np.bincount(path[foot], minlength=len(lines))
    spans: list[tuple[float, bool]] = []
    for axis in (0, 1):
        sides = []
        for sign in (1.0, -1.0):
            seen = [
                (int(count[index]), line.distance)
                for index, line in enumerate(lines)
                if line.seen and line.outward[axis] == sign and count[index] >= MIN_BINS
            ]
            sides += [max(seen)[1]] if seen else []
        spans.append((float(sum(sides)), len(sides) == 2))
    return spans


def extent_misfit(
    spans: Sequence[tuple[float, bool]], extent_m: tuple[float, float], scale: float
) -> float:
    """Return how badly spans (`wall_spans`) times `scale` fit the sides of a room, 0 if they may.

    Two opposite walls must be as far apart as the plan says; a single one must be nearer than
    that by `CLEARANCE_M`, because the camera is inside. Which side lies along which axis is not
    known: the better way counts.
    """
    return min(
        sum(
            _misfit(scale * span, both, side) for (span, both), side in zip(spans, way, strict=True)
        )
        for way in (extent_m, extent_m[::-1])
    )


def _misfit(span: float, both: bool, side: float) -> float:
    """Return the bounded cost of a span against a side of the room."""
    limit = side if both else max(side - CLEARANCE_M, 0.1)
    if span <= 0.0 or (not both and span <= limit):
        return 0.0
    return min((float(np.log(span / limit)) / SPREAD) ** 2, BOUND)
