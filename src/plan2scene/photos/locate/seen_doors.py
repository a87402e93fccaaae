"""Doors that a located photo shows, and the pixels of their leaves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from plan2scene.photos.labels.palette import CEILING, FLOOR, WALL
from plan2scene.photos.locate.plan_view import Hole, RoomShape, look
from plan2scene.photos.locate.pose import Pose


@dataclass(frozen=True)
class DoorSettings:
    """When a photo shows a door leaf. Chosen by looking at real homes (development)."""

    #: Share of the opening's width and height left out on each side: frame, handle, a pose that is
    #: not exact.
    margin: float = 0.15
    #: Points along and up the leaf that are looked at.
    points: tuple[int, int] = (48, 96)
    #: Least share of them in the photo and in sight.
    least_seen: float = 0.33
    #: Least share of those that no floor, wall or ceiling covers, and most that a floor does: an
    #: open door shows the next room.
    least_other: float = 0.65
    most_floor: float = 0.05
    #: Least mean probability of a door: furniture before a wrong place of a photo has .00 to .04.
    least_door: float = 0.05


DOORS = DoorSettings()


def seen_doors(
    labels: np.ndarray, doors: np.ndarray, pose: Pose, shapes: Mapping[str, RoomShape]
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield (opening id, pixels (n, 2) int of row and column) of the leaves of a photo's doors.

    Parameters
    ----------
    labels : (h, w) uint8
        Labels of :mod:`plan2scene.photos.labels.palette`.
    doors : (h', w') float
        How likely each pixel is of a door, at any resolution.
    pose : Pose
        Of a located photo.
    shapes
        Of :func:`plan2scene.photos.locate.plan_view.room_shapes`.
    """
    shape = shapes[pose.room_id]
    camera = replace(pose.camera, position=pose.position)
    for index, hole in enumerate(shape.holes):
        if hole.kind != "door":
            continue
        points = _leaf_points(shape, hole)
        pixels = camera.project(points)
        inside = (pixels >= 0) & (pixels <= np.array([camera.width - 1, camera.height - 1]))
        shown = inside.all(axis=1) & _in_sight(pose, shapes, points, index)
        if shown.mean() < DOORS.least_seen:
            continue
        places = np.unique(np.rint(pixels[shown]).astype(int), axis=0)[:, ::-1]
        found = labels[tuple(places.T)]
        likely = doors[tuple((places * doors.shape / labels.shape).astype(int).T)]
        other = ~np.isin(found, (FLOOR, WALL, CEILING))
        if (
            other.mean() >= DOORS.least_other
            and (found == FLOOR).mean() <= DOORS.most_floor
            and likely.mean() >= DOORS.least_door
        ):
            # Of what is no leaf (an open door, things before it) the network is less sure.
            yield hole.opening_id, places[other & (likely >= likely[other].mean())]


def _leaf_points(shape: RoomShape, hole: Hole) -> np.ndarray:
    """Return points (n, 3) of a door leaf off its borders, in the plan's frame."""
    part = np.linspace(DOORS.margin, 1.0 - DOORS.margin, max(DOORS.points))
    along = hole.start + (hole.end - hole.start) * part[:: len(part) // DOORS.points[0]]
    up = hole.bottom + (hole.top - hole.bottom) * part
    at, height = np.meshgrid(along, up)
    floor = shape.start[hole.edge] + at.reshape(-1, 1) * shape.along[hole.edge]
    return np.stack([floor[:, 0], height.ravel(), floor[:, 1]], axis=1)


def _in_sight(
    pose: Pose, shapes: Mapping[str, RoomShape], points: np.ndarray, hole: int
) -> np.ndarray:
    """Return which points (n, 3) of an opening no wall of the room hides, (n,) bool."""
    eye = np.array([pose.position[0], pose.position[2]])
    away = points[:, [0, 2]] - eye
    azimuth = np.arctan2(away[:, 0], away[:, 1])
    sight = look(shapes, pose.room_id, np.tile(eye, (len(points), 1)), azimuth)
    return np.asarray(sight.hole == hole)
