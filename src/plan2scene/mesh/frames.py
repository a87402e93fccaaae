"""Where a wall stands: the side of each room, the face's local axes, its place along the room.

A face's local axes are s (metres to the right as seen from inside the room) and y (up).
"""

from __future__ import annotations

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


def local_interval(wall: Wall, frame: Frame, opening: Opening) -> tuple[float, float]:
    """Return an opening's (s0, s1) on a frame of its wall, clipped to the wall."""
    low, high = max(opening.start, 0.0), min(opening.end, wall.length)
    from_start = np.allclose(frame.plan(0.0), wall.start, atol=1e-9) or (
        np.array(wall.start) @ frame.right <= np.array(wall.end) @ frame.right
    )
    return (low, high) if from_start else (wall.length - high, wall.length - low)


def arc_offset(room: Room, frame: Frame) -> float:
    """Return where a face's left end lies along its room's outline, metres.

    Outlines are walked to the right as seen from inside, so a texture runs on over the corner.
    """
    middle = Point(*frame.plan(frame.length / 2))
    rings = [Polygon(ring) for ring in room.rings]
    ring = min(rings, key=lambda polygon: polygon.exterior.distance(middle))
    # To the right as seen from inside: an outline runs from x to z, a hole the other way round.
    line = LineString(_walked(ring, counter_clockwise=ring is rings[0]))
    return float(line.project(middle)) - frame.length / 2


def _walked(polygon: Polygon, *, counter_clockwise: bool) -> np.ndarray:
    """Return a ring's closed coordinates in the given turn of the (x, z) plane."""
    coordinates = np.asarray(polygon.exterior.coords)
    return coordinates if polygon.exterior.is_ccw == counter_clockwise else coordinates[::-1]
