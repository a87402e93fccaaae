"""Panels of a contact sheet about a photo's place: the plan with its frustum, the plan over it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.drawing import PAPER
from plan2scene.photos.contact_sheet.panels import scaled_camera
from plan2scene.photos.locate.plan_view import Hole, RoomShape
from plan2scene.photos.locate.pose import Pose

#: sRGB of walls, doors and passages, windows, the frustum, and the room that a photo stands in.
WALL_INK, DOOR_INK, WINDOW_INK = (90, 90, 90), (220, 60, 50), (40, 140, 235)
FRUSTUM, OWN_ROOM = (240, 150, 30), (255, 243, 214)
#: Length of the frustum in the plan, metres, and the margin about the plan, pixels.
FRUSTUM_M, MARGIN = 2.5, 8
#: What is nearer to the camera's plane is cut off, metres.
NEAR_M = 0.05


def plan_panel(
    shapes: Mapping[str, RoomShape], pose: Pose | None, size: tuple[int, int]
) -> np.ndarray:
    """Return a picture of (height, width) of the plan, x to the right and z down.

    Of the level where the photo was taken, with its frustum; else of the lowest.
    """
    level = next(iter(shapes.values())).level if pose is None else shapes[pose.room_id].level
    shapes = {name: shape for name, shape in shapes.items() if shape.level == level}
    picture = np.full((*size, 3), PAPER, np.uint8)
    points = np.concatenate([shape.start for shape in shapes.values()])
    low, span = points.min(axis=0), np.maximum(np.ptp(points, axis=0), 0.1)
    scale = float(((np.array([size[1], size[0]]) - 2 * MARGIN) / span).min())

    def pixels(plan: np.ndarray) -> np.ndarray:
        return np.rint(((plan - low) * scale + MARGIN) * 8).astype(np.int32)

    if pose is not None:
        cv2.fillPoly(picture, [pixels(shapes[pose.room_id].start)], OWN_ROOM, cv2.LINE_AA, 3)
    for shape in shapes.values():
        ends = shape.start + shape.along * shape.length[:, None]
        for a, b in zip(shape.start, ends, strict=True):
            cv2.line(picture, pixels(a), pixels(b), WALL_INK, 1, cv2.LINE_AA, 3)
        for hole in shape.holes:
            a, b = (shape.start[hole.edge] + at * shape.along[hole.edge] for at in _ends(hole))
            cv2.line(picture, pixels(a), pixels(b), _ink(hole), 2, cv2.LINE_AA, 3)
    if pose is not None:
        rays = pose.camera.rays(
            np.array([[0.0, pose.camera.cy], [pose.camera.width - 1.0, pose.camera.cy]])
        )[:, [0, 2]]
        eye = pose.eye[[0, 2]]
        rim = eye + FRUSTUM_M * rays / np.linalg.norm(rays, axis=1, keepdims=True)
        corners = pixels(np.stack([eye, *rim]))
        layer = picture.copy()
        cv2.fillPoly(layer, [corners], FRUSTUM, cv2.LINE_AA, 3)
        picture = cv2.addWeighted(layer, 0.35, picture, 0.65, 0.0)
        cv2.circle(picture, corners[0], 3 * 8, FRUSTUM, -1, cv2.LINE_AA, 3)
    return picture


def edges_panel(image: np.ndarray, pose: Pose, shapes: Mapping[str, RoomShape]) -> np.ndarray:
    """Return a photo (h, w, 3) with the edges of its room in the plan drawn over it."""
    camera = scaled_camera(pose.camera, (image.shape[0], image.shape[1]))
    picture = np.clip(image * 0.7 + 255 * 0.3, 0, 255).astype(np.uint8)
    for line, ink in _room_lines(shapes[pose.room_id]):
        for a, b in _segments(camera, line - pose.eye):
            cv2.line(picture, a, b, ink, 2 if ink != WALL_INK else 1, cv2.LINE_AA, 3)
    return picture


def _room_lines(shape: RoomShape) -> Iterator[tuple[np.ndarray, tuple[int, int, int]]]:
    """Yield the room's edges and openings as world points (n, 3), metres, with their colours."""

    def at(plan: np.ndarray, y: float) -> np.ndarray:
        return np.array([plan[0], y, plan[1]])

    ends = shape.start + shape.along * shape.length[:, None]
    for a, b in zip(shape.start, ends, strict=True):
        ring = [at(a, 0.0), at(b, 0.0), at(b, shape.height), at(a, shape.height), at(a, 0.0)]
        yield np.array(ring), WALL_INK
    for hole in shape.holes:
        a, b = (shape.start[hole.edge] + s * shape.along[hole.edge] for s in _ends(hole))
        low, high = hole.bottom, hole.top
        yield np.array([at(a, low), at(b, low), at(b, high), at(a, high), at(a, low)]), _ink(hole)


def _segments(
    camera: Camera, points: np.ndarray
) -> Iterator[tuple[tuple[int, int], tuple[int, int]]]:
    """Yield the visible pieces of a line through points (n, 3), from the camera, in 1/8 pixels."""
    seen = points @ camera.matrix.T
    for a, b in pairwise(seen):
        if max(a[2], b[2]) <= NEAR_M:
            continue
        if min(a[2], b[2]) < NEAR_M:
            cut = a + (b - a) * (NEAR_M - a[2]) / (b[2] - a[2])
            a, b = (a, cut) if a[2] > b[2] else (cut, b)
        flat = np.stack([p[:2] / p[2] * camera.focal_px + (camera.cx, camera.cy) for p in (a, b)])
        flat = np.clip(np.rint(flat * 8), -1e7, 1e7).astype(int)
        yield (int(flat[0, 0]), int(flat[0, 1])), (int(flat[1, 0]), int(flat[1, 1]))


def _ends(hole: Hole) -> tuple[float, float]:
    return hole.start, hole.end


def _ink(hole: Hole) -> tuple[int, int, int]:
    return WINDOW_INK if hole.kind == "window" else DOOR_INK
