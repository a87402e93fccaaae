"""Find the doors that a photo shows, and the pixels of their leaves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import cv2
import numpy as np

from plan2scene.photos.labels.palette import CEILING, FLOOR, OTHER, WALL
from plan2scene.photos.locate.plan_view import Hole, RoomShape
from plan2scene.photos.locate.pose import Pose, points_shown


@dataclass(frozen=True)
class DoorSettings:
    """When a photo shows a door leaf. Chosen by looking at real homes (development)."""

    #: Share of the opening's width and height left out on each side (frame, errors of the pose).
    margin: float = 0.15
    #: Number of points along and up the leaf that are projected into the photo.
    points: tuple[int, int] = (48, 96)
    #: Least share of these points that lies in the photo and is not hidden by a wall of the room.
    least_seen: float = 0.33
    #: Limits for the visible pixels of an opening: least share that is not labelled floor, wall or
    #: ceiling, and largest share labelled floor (an open door shows the next room's floor).
    least_other: float = 0.65
    most_floor: float = 0.05
    #: Least mean probability of a door over these pixels. Where a photo's pose is wrong, furniture
    #: at the place of the door has .00 to .13.
    least_door: float = 0.16
    #: Pixels with at least this probability of a door lie surely on a leaf, open or shut: frames
    #: and what is seen behind an open door have less. Regions of such pixels are eroded with a
    #: square of side `border` (share of the photo's width) and kept if they then cover at least the
    #: share `least_leaf` of the photo.
    sure: float = 0.89
    border: float = 0.02
    least_leaf: float = 0.01


DOORS = DoorSettings()


def seen_doors(
    labels: np.ndarray,
    doors: np.ndarray,
    pose: Pose | None,
    shapes: Mapping[str, RoomShape],
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield (opening id, pixels (n, 2) int of row and column) of the leaves of a photo's doors.

    The id is empty if a leaf's opening is not known. `labels` (h, w) uint8 are those of
    `labels.palette`; `doors` (h', w') float is the door probability, at any resolution; `pose` is
    that of a located photo, or None; `shapes` are the house's rooms (`plan_view.room_shapes`).
    """
    holes = {} if pose is None else dict(_holes_in_sight(pose, shapes))
    opened: set[str] = set()
    for leaf in _sure_leaves(labels, doors):
        beside = {name: _gap(leaf, places) for name, places in holes.items() if name not in opened}
        name = min(beside, key=lambda name: beside[name], default="")
        name = name if name and beside[name] <= 0 else ""
        opened.add(name)
        yield name, leaf
    for name, places in holes.items():
        place_labels = labels[tuple(places.T)]
        likely = doors[tuple((places * doors.shape / labels.shape).astype(int).T)]
        other = ~np.isin(place_labels, (FLOOR, WALL, CEILING))
        if (
            name not in opened
            and other.mean() >= DOORS.least_other
            and (place_labels == FLOOR).mean() <= DOORS.most_floor
            and likely.mean() >= DOORS.least_door
        ):
            # The door probability is lower off the leaf: behind an open door, on things in front.
            yield name, places[other & (likely >= likely[other].mean())]


def _holes_in_sight(
    pose: Pose, shapes: Mapping[str, RoomShape]
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield (opening id, visible pixels (n, 2)) of the doors of the pose's room."""
    shape = shapes[pose.room_id]
    for index, hole in enumerate(shape.holes):
        if hole.kind != "door":
            continue
        pixels, shown = points_shown(_leaf_points(shape, hole), pose, shapes, index)
        if shown.mean() >= DOORS.least_seen:
            yield hole.opening_id, np.unique(np.rint(pixels[shown]).astype(int), axis=0)[:, ::-1]


def _sure_leaves(labels: np.ndarray, doors: np.ndarray) -> list[np.ndarray]:
    """Return the pixels (n, 2) of each region that is surely a door leaf, the largest first."""
    height, width = labels.shape
    likely = cv2.resize(np.asarray(doors, dtype=np.float32), (width, height))
    sure = (likely >= DOORS.sure) & (labels == OTHER)
    border = np.ones((max(1, round(DOORS.border * width)),) * 2, np.uint8)
    count, parts = cv2.connectedComponents(cv2.erode(sure.astype(np.uint8), border))
    leaves = [np.argwhere(parts == k) for k in range(1, count)]
    large = [leaf for leaf in leaves if len(leaf) >= DOORS.least_leaf * labels.size]
    return sorted(large, key=len, reverse=True)


def _gap(leaf: np.ndarray, places: np.ndarray) -> float:
    """Return the gap in columns between a leaf and an opening, minus the opening's width.

    It is at most 0 for a leaf that may belong to the opening: an open leaf stands beside it.
    """
    low, high = places[:, 1].min(), places[:, 1].max()
    between = max(leaf[:, 1].min() - high, low - leaf[:, 1].max(), 0)
    return float(between - (high - low))


def _leaf_points(shape: RoomShape, hole: Hole) -> np.ndarray:
    """Return points (n, 3) of a door leaf, away from its borders, in the plan's frame."""
    part = np.linspace(DOORS.margin, 1.0 - DOORS.margin, max(DOORS.points))
    along = hole.start + (hole.end - hole.start) * part[:: len(part) // DOORS.points[0]]
    up = hole.bottom + (hole.top - hole.bottom) * part
    at, height = np.meshgrid(along, up)
    floor = shape.start[hole.edge] + at.reshape(-1, 1) * shape.along[hole.edge]
    return np.stack([floor[:, 0], height.ravel(), floor[:, 1]], axis=1)
