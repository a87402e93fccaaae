"""Planes of a photo: one floor, one ceiling, walls split by the direction they face.

Positions are metres from the camera centre in the photo's Manhattan frame (x, y up, z;
``docs/conventions.md``). A plane holds the points X with ``normal . X = offset``; normals point
into the room, so offsets are negative.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.photos.camera.lines import detect_segments
from plan2scene.photos.labels.palette import CEILING, FLOOR, WALL
from plan2scene.photos.planes.beyond import within_room
from plan2scene.photos.planes.room_size import RoomSize
from plan2scene.photos.planes.walls import TracedWalls, trace_walls

#: Walls kept per photo, the largest first (paper: the 10 largest planes).
MAX_WALLS = 10
#: Smallest plane, share of the photo's pixels.
MIN_SHARE = 0.002
DEFAULT_CAMERA_HEIGHT_M = 1.5
DEFAULT_ROOM_HEIGHT_M = 2.6


@dataclass(frozen=True)
class Plane:
    """One plane of a photo."""

    #: ``floor``, ``wall`` or ``ceiling``.
    surface: str
    #: Number within the surface: walls from the largest to the smallest, 0..9; floor and ceiling
    #: are 0, of a located photo also more where other rooms are seen.
    index: int
    #: (3,): Unit normal into the room, in the frame of the camera that it was split with.
    normal: tuple[float, float, float]
    #: ``normal . X`` of its points, metres from the camera centre.
    offset: float
    #: (h, w) bool: Its pixels.
    mask: np.ndarray
    #: What gave the distance: ``camera_height`` (prior), ``room_height`` (floor and ceiling seen
    #: with a known room height), ``room_extent`` (walls farther, or opposite ones farther apart or
    #: nearer, than the plan has them), ``plan`` (the photo is located), or ``prior`` (nothing seen
    #: that tells it).
    scale_source: str
    #: Height of the camera above the floor, metres.
    camera_height_m: float = DEFAULT_CAMERA_HEIGHT_M


def split_planes(
    labels: np.ndarray,
    camera: Camera,
    *,
    image: np.ndarray | None = None,
    camera_height_m: float = DEFAULT_CAMERA_HEIGHT_M,
    room_height_m: float | None = None,
    room_extent_m: tuple[float, float] | None = None,
) -> list[Plane]:
    """Return the planes of a photo: floor, ceiling, then walls by size.

    Parameters
    ----------
    labels : (h, w) uint8
        0 other, 1 floor, 2 wall, 3 ceiling, 255 ignore; the camera's size.
    camera : Camera
        Rotation and focal length of the photo.
    image : (h, w, 3) uint8, optional
        The photo, sRGB: its lines tell which way a wall faces that shows neither foot nor top.
    camera_height_m : float
        Height of the camera above the floor where nothing in the photo tells it, metres.
    room_height_m : float, optional
        Height of the room from the plan. Where one wall shows both its foot and its top, it
        gives the camera's height.
    room_extent_m : (float, float), optional
        Sides of the room's rectangle in the plan (`room_size.room_extent`). They bound the
        camera's height, or give it where opposite walls are seen, unless `room_height_m` does.
    """
    room = DEFAULT_ROOM_HEIGHT_M if room_height_m is None else room_height_m
    prior = min(camera_height_m, 0.8 * room)
    segments = None
    if image is not None:
        segments = detect_segments(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY), camera.width / 25)
    known, size = room_height_m is not None, RoomSize(room, room_extent_m)
    traced = trace_walls(labels, camera, prior, size, solve_height=known, segments=segments)
    return [*_flat_planes(labels, camera, traced, size, known=known), *_wall_planes(labels, traced)]


def _flat_planes(
    labels: np.ndarray, camera: Camera, traced: TracedWalls, room: RoomSize, *, known: bool
) -> list[Plane]:
    """Return the room's floor and ceiling, as far as seen; `known`: the plan gives the height."""
    height, source = traced.camera_height_m, traced.scale_source
    # Without the room's height, the ceiling's distance is a guess whatever the floor's is.
    above = source if known else "prior"
    longest = float(np.hypot(*room.extent_m)) if room.extent_m else np.inf
    rise = room.height_m - height
    floor, ceiling = (
        without_specks(within_room(labels == label, camera, drop, traced.reach, longest))
        for label, drop in ((FLOOR, height), (CEILING, -rise))
    )
    flat = [
        Plane("floor", 0, (0.0, 1.0, 0.0), -height, floor, source, height),
        Plane("ceiling", 0, (0.0, -1.0, 0.0), -rise, ceiling, above, height),
    ]
    return [plane for plane in flat if plane.mask.any()]


def _wall_planes(labels: np.ndarray, traced: TracedWalls) -> list[Plane]:
    """Return the largest walls, by size."""
    wall = (labels == WALL) & ~traced.through
    masks = [without_specks(wall & (traced.owner == k)) for k in range(len(traced.lines))]
    walls = sorted(zip(traced.lines, masks, strict=True), key=lambda item: -int(item[1].sum()))
    planes = []
    for index, (line, mask) in enumerate(walls[:MAX_WALLS]):
        if not mask.any():
            break
        source = traced.scale_source if line.seen else "prior"
        normal = (0.0 - line.outward[0], 0.0, 0.0 - line.outward[1])
        height = traced.camera_height_m
        planes.append(Plane("wall", index, normal, -line.distance, mask, source, height))
    return planes


def without_specks(mask: np.ndarray) -> np.ndarray:
    """Return a mask without connected parts smaller than `MIN_SHARE` of the photo."""
    count, parts, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    keep = stats[:, cv2.CC_STAT_AREA] >= max(1.0, MIN_SHARE * mask.size)
    keep[0] = False
    return np.asarray(keep[parts]) if count > 1 else np.zeros_like(mask)
