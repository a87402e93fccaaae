"""Windows that located photos show in outer walls of a house whose plan draws none."""

from __future__ import annotations

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
    look,
    searched_shapes,
)
from plan2scene.photos.locate.pose import Pose
from plan2scene.plans.openings import Segment, place_openings
from plan2scene.plans.parse import Source


@dataclass(frozen=True)
class SeenWindowSettings:
    """When photos show a window, metres. Usual sizes; `sure` was looked at on three listings."""

    cell: float = 0.05  #: side of the cells of a wall that are looked at
    highest: float = 2.4  #: above the floor
    sure: float = 0.65  #: mean probability of a window from which a cell is of one
    bridged: float = 0.25  #: mullions, curtains and things before it are no gap
    least: float = 0.4  #: width and height of a window
    door: float = 0.35  #: one that begins below this reaches the floor
    head: float = 1.5  #: least height of its top above the floor


SEEN_WINDOWS = SeenWindowSettings()


def with_seen_windows(house: House, shots: Mapping[str, Shot], poses: Mapping[str, Pose]) -> House:
    """Return a house whose guessed windows are those that its photos show, where they show any.

    `poses` are those of :func:`.locate_photos.locate_shots`; a room without a window in a located
    photo keeps its guesses.
    """
    shapes = searched_shapes(house)
    found: dict[str, list[Segment]] = {}
    for room_id, shape in shapes.items():
        views = [
            (shots[name], pose)
            for name, pose in poses.items()
            if pose.believed and pose.room_id == room_id
        ]
        for number, hole in enumerate(shape.holes) if views else ():
            if hole.kind == UNDRAWN:
                likely = _likely(shapes, shape, number, views)
                found.setdefault(room_id, []).extend(_segments(shape, hole, likely))
    walls = [
        replace(wall, openings=tuple(o for o in wall.openings if not o.guessed))
        if any(found.get(room) for room in wall.room_ids)
        else wall
        for wall in house.walls
    ]
    placed: dict[str, Wall] = {}
    for room_id, segments in found.items():
        own = [placed.get(wall.id, wall) for wall in walls if room_id in wall.room_ids]
        for number, segment in enumerate(segments):
            named = replace(segment, id=f"seen_window_{len(placed)}_{number}")
            # One beside no wall is left out: the edge of a room may have several, or none.
            with suppress(InputError):
                own = place_openings(Source("photos", house.id), own, [named], tolerance=0.5)
        placed |= {wall.id: wall for wall in own}
    return replace(house, walls=tuple(placed.get(wall.id, wall) for wall in walls))


def _likely(
    shapes: Mapping[str, RoomShape],
    shape: RoomShape,
    number: int,
    views: Sequence[tuple[Shot, Pose]],
) -> np.ndarray:
    """Return how likely each cell (up, along) of a stretch of wall is of a window; 0 if unseen."""
    hole = shape.holes[number]
    cell = SEEN_WINDOWS.cell
    along = np.arange(hole.start + cell / 2, hole.end, cell)
    up = np.arange(cell / 2, min(hole.top, SEEN_WINDOWS.highest), cell)
    at, height = (part.ravel() for part in np.meshgrid(along, up))
    floor = shape.start[hole.edge] + at[:, None] * shape.along[hole.edge]
    points = np.stack([floor[:, 0], height, floor[:, 1]], axis=1)
    total, count = np.zeros(len(points)), np.zeros(len(points))
    for shot, pose in views:
        camera = replace(pose.camera, position=pose.position)
        eye = pose.eye[[0, 2]]
        away = floor - eye
        azimuth = np.arctan2(away[:, 0], away[:, 1])
        sight = look(shapes, shape.room_id, np.tile(eye, (len(floor), 1)), azimuth)
        pixels = camera.project(points)
        inside = (pixels >= 0) & (pixels <= np.array([camera.width - 1, camera.height - 1]))
        shown = inside.all(axis=1) & (sight.hole == number)
        column, row = np.rint(pixels[shown]).astype(int).T
        total[shown] += _window(shot)[row, column]
        count[shown] += 1
    return (total / np.maximum(count, 1)).reshape(len(up), len(along))


def _window(shot: Shot) -> np.ndarray:
    """Return how likely each pixel of a photo (h, w) is of a window."""
    if shot.probabilities is None:
        return np.asarray(shot.labels == WINDOW, dtype=np.float32)
    return cv2.resize(shot.probabilities[WINDOW], shot.labels.shape[::-1])


def _segments(shape: RoomShape, hole: Hole, likely: np.ndarray) -> Iterator[Segment]:
    """Yield the windows of a stretch of wall."""
    cell = SEEN_WINDOWS.cell
    sure = np.asarray(likely >= SEEN_WINDOWS.sure, np.uint8)
    kernel = np.ones((1 + round(SEEN_WINDOWS.bridged / cell),) * 2, np.uint8)
    pad = len(kernel)
    closed = cv2.morphologyEx(np.pad(sure, pad), cv2.MORPH_CLOSE, kernel)[pad:-pad, pad:-pad]
    _, _, boxes, _ = cv2.connectedComponentsWithStats(closed)
    for left, low, width, height, _ in boxes[1:]:
        top = (low + height) * cell
        if min(width, height) * cell < SEEN_WINDOWS.least or top < SEEN_WINDOWS.head:
            continue
        ends = hole.start + cell * np.array([left, left + width])
        start, end = (shape.start[hole.edge] + at * shape.along[hole.edge] for at in ends)
        bottom = 0.0 if low * cell < SEEN_WINDOWS.door else low * cell
        yield Segment("", "window", tuple(start.tolist()), tuple(end.tolist()), bottom, top)
