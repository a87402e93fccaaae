"""Find the windows that located photos show in outer walls of a house whose plan draws none."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import cv2
import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import House, Wall
from plan2scene.photos.labels.palette import WINDOW
from plan2scene.photos.locate.locate_photos import Shot
from plan2scene.photos.locate.plan_view import (
    UNDRAWN,
    Hole,
    RoomShape,
    searched_shapes,
)
from plan2scene.photos.locate.pose import Pose, points_shown
from plan2scene.plans.openings import Segment, place_openings
from plan2scene.plans.parse import Source


@dataclass(frozen=True)
class SeenWindowSettings:
    """When photos show a window, metres. Usual sizes; `sure` was checked by eye on 3 listings."""

    cell: float = 0.05  #: side of the cells into which a wall is divided
    highest: float = 2.4  #: height above the floor up to which cells are looked at
    sure: float = 0.65  #: least mean probability of a window in a cell that belongs to one
    bridged: float = 0.25  #: gaps up to about this size are closed (mullions, curtains, furniture)
    least: float = 0.4  #: least width and height of a window
    door: float = 0.3  #: a window that begins below this height reaches the floor
    head: float = 1.5  #: least height of a window's top above the floor


SEEN_WINDOWS = SeenWindowSettings()


def with_seen_windows(house: House, shots: Mapping[str, Shot], poses: Mapping[str, Pose]) -> House:
    """Return a house in which the windows that its photos show replace the guessed ones.

    `poses` are those of `locate_photos.locate_shots`. A room keeps its guesses if no located photo
    shows a window in it.
    """
    shapes = searched_shapes(house)
    segments_of_room: dict[str, list[Segment]] = {}
    for room_id, shape in shapes.items():
        views = [
            (shots[name], pose)
            for name, pose in poses.items()
            if pose.believed and pose.room_id == room_id
        ]
        for number, hole in enumerate(shape.holes) if views else ():
            if hole.kind == UNDRAWN:
                likely = _likely(shapes, shape, number, views)
                segments_of_room.setdefault(room_id, []).extend(_segments(shape, hole, likely))
    walls = [
        replace(wall, openings=tuple(o for o in wall.openings if not o.guessed))
        if any(segments_of_room.get(room) for room in wall.room_ids)
        else wall
        for wall in house.walls
    ]
    placed: dict[str, Wall] = {}
    for room_id, segments in segments_of_room.items():
        room_walls = [placed.get(wall.id, wall) for wall in walls if room_id in wall.room_ids]
        for number, segment in enumerate(segments):
            named = replace(segment, id=f"seen_window_{len(placed)}_{number}")
            # A window beside no wall is left out: an edge of a room may have several walls or none.
            with suppress(InputError):
                room_walls = place_openings(
                    Source("photos", house.id), room_walls, [named], tolerance=0.5
                )
        placed |= {wall.id: wall for wall in room_walls}
    return replace(house, walls=tuple(placed.get(wall.id, wall) for wall in walls))


def _likely(
    shapes: Mapping[str, RoomShape],
    shape: RoomShape,
    number: int,
    views: Sequence[tuple[Shot, Pose]],
) -> np.ndarray:
    """Return the mean window probability of a wall's cells (up, along); 0 where unseen."""
    hole = shape.holes[number]
    cell = SEEN_WINDOWS.cell
    along = np.arange(hole.start + cell / 2, hole.end, cell)
    up = np.arange(cell / 2, min(hole.top, SEEN_WINDOWS.highest), cell)
    at, height = (part.ravel() for part in np.meshgrid(along, up))
    floor = shape.start[hole.edge] + at[:, None] * shape.along[hole.edge]
    points = np.stack([floor[:, 0], height, floor[:, 1]], axis=1)
    total, count = np.zeros(len(points)), np.zeros(len(points))
    for shot, pose in views:
        pixels, shown = points_shown(points, pose, shapes, number)
        column, row = np.rint(pixels[shown]).astype(int).T
        total[shown] += _window(shot)[row, column]
        count[shown] += 1
    return (total / np.maximum(count, 1)).reshape(len(up), len(along))


def _window(shot: Shot) -> np.ndarray:
    """Return the window probability (h, w) of each pixel of a photo."""
    if shot.probabilities is None:
        return np.asarray(shot.labels == WINDOW, dtype=np.float32)
    return cv2.resize(shot.probabilities[WINDOW], shot.labels.shape[::-1])


def _segments(shape: RoomShape, hole: Hole, likely: np.ndarray) -> Iterator[Segment]:
    """Yield the windows of a stretch of wall beside its doors; `likely` is :func:`_likely`'s."""
    cell = SEEN_WINDOWS.cell
    sure = np.asarray(likely >= SEEN_WINDOWS.sure, np.uint8)
    side = 1 + 2 * math.ceil(SEEN_WINDOWS.bridged / cell / 2)  # odd: an even one moves the windows
    kernel = np.ones((side, side), np.uint8)
    pad = len(kernel)
    closed = cv2.morphologyEx(np.pad(sure, pad), cv2.MORPH_CLOSE, kernel)[pad:-pad, pad:-pad]
    along = hole.start + cell * (0.5 + np.arange(closed.shape[1]))
    for drawn in shape.holes:
        if drawn.edge == hole.edge and drawn.kind in ("door", "passage"):  # no window is drawn
            closed[:, (along > drawn.start - cell / 2) & (along < drawn.end + cell / 2)] = 0
    _, _, boxes, _ = cv2.connectedComponentsWithStats(closed)
    for left, low, width, height, _ in boxes[1:]:
        top = (low + height) * cell
        if min(width, height) * cell < SEEN_WINDOWS.least or top < SEEN_WINDOWS.head:
            continue
        ends = hole.start + cell * np.array([left, left + width])
        start, end = (shape.start[hole.edge] + at * shape.along[hole.edge] for at in ends)
        bottom = 0.0 if low * cell < SEEN_WINDOWS.door else low * cell
        yield Segment("", "window", tuple(start.tolist()), tuple(end.tolist()), bottom, top)
