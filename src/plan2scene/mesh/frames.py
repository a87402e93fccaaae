"""Where a wall stands: the side of each room, the face's local axes, its place along the room.

A face's local axes are s (metres to the right as seen from inside the room) and y (up).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from shapely.geometry import LineString, Point, Polygon
from shapely.geometry.base import BaseGeometry

from plan2scene.house import Opening, Room, Wall

#: Distances from the wall line at which a room is looked for, metres.
_PROBES = (0.01, 0.05, 0.2)


@dataclass(frozen=True)
class Frame:
    """A vertical rectangle seen from its visible side.

    Attributes
    ----------
    left : (2,) float64
        Plan point (x, z) of the lower left corner.
    right : (2,) float64
        Unit vector along the rectangle, to the right.
    normal : (2,) float64
        Unit vector towards the viewer; ``right = (normal_z, -normal_x)``.
    length : float
        Metres.
    """

    left: np.ndarray
    right: np.ndarray
    normal: np.ndarray
    length: float

    def plan(self, s: np.ndarray | float, out: float = 0.0) -> np.ndarray:
        """Return plan points at `s` along the face and `out` metres in front of it."""
        along = np.asarray(s, dtype=np.float64)[..., None] * self.right
        return self.left + along + out * self.normal

    def world(self, sy: np.ndarray, out: float = 0.0) -> np.ndarray:
        """Return (n, 3) world points of (n, 2) local points (s, y)."""
        plan = self.plan(sy[:, 0], out)
        return np.stack([plan[:, 0], sy[:, 1], plan[:, 1]], axis=1)

    def moved(self, out: float) -> Frame:
        """Return the same rectangle `out` metres nearer to the viewer."""
        return Frame(self.left + out * self.normal, self.right, self.normal, self.length)

    def axes(self, s: float, out: float = 0.0) -> np.ndarray:
        """Return a (4, 3) box frame: right, up, normal, and the floor point at `s`."""
        x, z = self.plan(s, out)
        return np.array(
            [
                [self.right[0], 0.0, self.right[1]],
                [0.0, 1.0, 0.0],
                [self.normal[0], 0.0, self.normal[1]],
                [x, 0.0, z],
            ]
        )


@dataclass(frozen=True)
class FaceOpening:
    """An opening as seen on a face: metres from the face's left end, and above the floor."""

    opening: Opening
    left: float
    right: float
    bottom: float
    top: float


def frame_between(start: np.ndarray, end: np.ndarray, normal: np.ndarray) -> Frame:
    """Return the frame of a vertical face over a plan segment that looks along `normal`."""
    right = np.array([normal[1], -normal[0]])
    left = start if start @ right <= end @ right else end
    return Frame(left, right, normal, float(np.linalg.norm(end - start)))


def wall_frame(wall: Wall, normal: np.ndarray) -> Frame:
    """Return the frame of a wall's line seen from the side of `normal`."""
    return frame_between(np.array(wall.start), np.array(wall.end), normal)


def inner_normal(wall: Wall, polygon: BaseGeometry) -> np.ndarray:
    """Return the (2,) unit plan vector from a wall towards the room it bounds.

    Points on both sides of the line vote; when they cannot tell (a wall in the middle of its
    room, or off its outline) the room's centre decides, then the left of start-to-end.
    """
    start, end = np.array(wall.start), np.array(wall.end)
    along = (end - start) / wall.length
    normal = np.array([along[1], -along[0]])
    votes = 0
    for share in (0.5, 0.25, 0.75, 0.1, 0.9):
        middle = start + share * (end - start)
        for distance in _PROBES:
            votes += shapely.contains_xy(polygon, *(middle + distance * normal))
            votes -= shapely.contains_xy(polygon, *(middle - distance * normal))
    if votes == 0:
        centre = np.array(polygon.centroid.coords[0])
        votes = 1 if (centre - start) @ normal >= 0 else -1
    return normal if votes > 0 else -normal


def openings_on(wall: Wall, frame: Frame) -> Iterator[FaceOpening]:
    """Yield a wall's openings as seen on a frame of it, cut to the wall; none without an area."""
    from_start = np.array(wall.start) @ frame.right <= np.array(wall.end) @ frame.right
    for opening in wall.openings:
        low, high = max(opening.start, 0.0), min(opening.end, wall.length)
        left, right = (low, high) if from_start else (wall.length - high, wall.length - low)
        bottom, top = max(opening.bottom, 0.0), min(opening.top, wall.height)
        if right - left > 1e-6 and top - bottom > 1e-6:
            yield FaceOpening(opening, left, right, bottom, top)


def walked_rings(room: Room) -> list[np.ndarray]:
    """Return a room's rings, closed, (n + 1, 2), walked to the right as seen from inside.

    That turns an outline from x to z, and a hole the other way round.
    """
    rings = []
    for number, ring in enumerate(room.rings):
        exterior = Polygon(ring).exterior
        coordinates = np.asarray(exterior.coords)
        rings.append(coordinates if exterior.is_ccw == (number == 0) else coordinates[::-1])
    return rings


def arc_offset(room: Room, frame: Frame) -> float:
    """Return where a face's left end lies along its room's outline, metres.

    Outlines are walked to the right as seen from inside, so a texture runs on over the corner.
    """
    middle = Point(*frame.plan(frame.length / 2))
    line = min((LineString(ring) for ring in walked_rings(room)), key=middle.distance)
    return float(line.project(middle)) - frame.length / 2


def reveal_quads(
    frame: Frame, hole: FaceOpening, back: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return the left jamb, right jamb, head and sill of a hole, each (4, 3), facing inwards.

    Seen from the hole, corners run counter-clockwise. `back` is the (2, 2) plan points of the
    far edge, at the left and at the right.
    """

    def at(plan: np.ndarray, y: float) -> np.ndarray:
        return np.array([plan[0], y, plan[1]])

    (a, b), (c, d) = frame.plan(np.array([hole.left, hole.right])), back
    bottom, top = hole.bottom, hole.top
    left = np.array([at(a, bottom), at(c, bottom), at(c, top), at(a, top)])
    right = np.array([at(d, bottom), at(b, bottom), at(b, top), at(d, top)])
    head = np.array([at(a, top), at(c, top), at(d, top), at(b, top)])
    sill = np.array([at(a, bottom), at(b, bottom), at(d, bottom), at(c, bottom)])
    return left, right, head, sill
