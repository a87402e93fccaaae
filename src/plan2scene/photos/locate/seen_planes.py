"""Planes of a located photo: which room's floor, wall or ceiling each labelled pixel shows.

The mask gives the kind of surface of a pixel. The plan gives its room: the pose's own room within
its walls, or the room behind, seen through a door or passage. Pixels near the border between two
rooms get no room, since plan and pose are a few centimetres off.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import cv2
import numpy as np

from plan2scene.photos.labels.palette import CEILING, FLOOR, WALL
from plan2scene.photos.locate.locate_settings import LOCATE
from plan2scene.photos.locate.plan_view import RoomShape, Sight, look
from plan2scene.photos.locate.pose import Pose
from plan2scene.photos.planes.planes import PhotoPlane, Plane, without_specks
from plan2scene.photos.planes.walls import PLANES

#: Kinds of opening through which a room is seen.
OPEN = ("door", "passage")
COARSE = 4  #: :func:`shows_its_room` reduces the labels by this factor in both directions


def seen_planes(
    labels: np.ndarray, pose: Pose, shapes: Mapping[str, RoomShape]
) -> list[PhotoPlane]:
    """Return floors, ceilings and walls of the pose's room and of the rooms behind its doors.

    `labels` (h, w) uint8 are the photo's mask, of the camera's size; `shapes` are the house's rooms
    (`plan_view.room_shapes`). The planes are in the plan's frame (as `pose.camera`) and scale. The
    planes of one surface are numbered through all rooms, the pose's own room first. The list is
    empty if pose and mask contradict each other (`LOCATE.min_explained`).
    """
    directions = np.arange(LOCATE.directions) * (2 * np.pi / LOCATE.directions)
    eyes = np.repeat(pose.eye[None, [0, 2]], LOCATE.directions, axis=0)
    around = look(shapes, pose.room_id, eyes, directions)
    planes_of_photo: list[PhotoPlane] = []
    for kind, surface in ((FLOOR, "floor"), (CEILING, "ceiling"), (WALL, "wall")):
        rows, columns = np.nonzero(labels == kind)
        if not len(rows):
            continue
        rays = pose.camera.rays_at(rows, columns)
        turns = np.arctan2(rays[:, 0], rays[:, 2]) / (2 * np.pi)
        sight = around.of(np.rint(turns * LOCATE.directions).astype(int) % LOCATE.directions)
        slope = rays[:, 1] / np.maximum(np.hypot(rays[:, 0], rays[:, 2]), 1e-9)
        if surface == "wall":
            owners = _wall_owners(pose, shapes, sight, slope)
        else:
            owners = _flat_owners(surface, pose, shapes, sight, slope)
        planes = []
        for room_id, bare, room_pixels in owners:
            if np.count_nonzero(room_pixels) < PLANES.min_share * labels.size:
                continue  # only specks; `without_specks` would be slow
            mask = np.zeros(labels.shape, bool)
            mask[rows[room_pixels], columns[room_pixels]] = True
            mask = without_specks(mask)
            if mask.any():
                own, walls = room_id == pose.room_id, set[str]()
                if own and surface == "wall":
                    walls = {
                        shapes[room_id].walls[edge] for edge in np.unique(sight.edge[room_pixels])
                    }
                wall_ids = tuple(sorted(walls - {""}))
                planes.append(PhotoPlane((room_id,), replace(bare, mask=mask), own, wall_ids))
        planes.sort(key=lambda item: (not item.own, -int(item.plane.mask.sum())))
        planes_of_photo += [
            replace(item, plane=replace(item.plane, index=index))
            for index, item in enumerate(planes[: PLANES.max_walls])
        ]
    surfaces = np.isin(labels, (FLOOR, CEILING, WALL)).sum()
    explained = sum(int(item.plane.mask.sum()) for item in planes_of_photo)
    return planes_of_photo if explained >= LOCATE.min_explained * surfaces else []


def shows_its_room(labels: np.ndarray, pose: Pose, shapes: Mapping[str, RoomShape]) -> bool:
    """Return whether a photo with labels (h, w) uint8 shows the room that its pose stands in.

    It is True, too, if the labels contradict the pose (no plane is found).
    """
    size = labels.shape[0] // COARSE, labels.shape[1] // COARSE
    small = cv2.resize(labels, size[::-1], interpolation=cv2.INTER_NEAREST)
    photo_planes = seen_planes(small, replace(pose, camera=pose.camera.resized(size)), shapes)
    sizes = np.array([item.plane.mask.sum() for item in photo_planes])
    own = np.array([item.own for item in photo_planes], dtype=bool)
    return bool(sizes[own].sum() >= LOCATE.min_own * sizes.sum())


def _flat_owners(
    surface: str, pose: Pose, shapes: Mapping[str, RoomShape], sight: Sight, slope: np.ndarray
) -> Iterator[tuple[str, Plane, np.ndarray]]:
    """Yield (room, its plane without a mask, pixels (n,) bool) for floor or ceiling pixels.

    `sight` is what the pixels' rays meet; `slope` (n,) is their rise per horizontal metre.
    """
    shape = shapes[pose.room_id]
    slack = LOCATE.off_share * sight.reach + LOCATE.off_m
    open_ = _open_to(shape, sight)
    tops = np.array([*(hole.top for hole in shape.holes), 0.0])[sight.hole]
    below_top = pose.position[1] + slope * sight.reach < tops - LOCATE.off_m
    for room_id in (pose.room_id, *_rooms_behind(shape)):
        level = 0.0 if surface == "floor" else shapes[room_id].height
        rise = level - pose.position[1]
        meets = slope * rise > 1e-9
        away = np.where(meets, rise / np.where(meets, slope, 1.0), np.inf)
        if room_id == pose.room_id:
            room_pixels = away < np.where(
                open_ == "", sight.reach + slack, sight.reach - LOCATE.off_m
            )
        else:
            room_pixels = (open_ == room_id) & below_top & (away > sight.reach + LOCATE.off_m)
            room_pixels &= away < sight.beyond * (1 + LOCATE.off_share)
        up = 1.0 if surface == "floor" else -1.0
        yield room_id, _plane(surface, (0.0, up, 0.0), up * rise, pose), room_pixels


def _wall_owners(
    pose: Pose, shapes: Mapping[str, RoomShape], sight: Sight, slope: np.ndarray
) -> Iterator[tuple[str, Plane, np.ndarray]]:
    """Yield the same as :func:`_flat_owners`, for wall pixels and each plane of walls."""
    shape = shapes[pose.room_id]
    level = pose.position[1] + slope * sight.reach
    near_hole = np.zeros(len(level), bool)
    well_inside = np.zeros(len(level), bool)
    for hole in shape.holes:
        for margin, inside in ((LOCATE.off_m, near_hole), (-LOCATE.off_m, well_inside)):
            inside |= (
                (sight.edge == hole.edge)
                & (sight.at > hole.start - margin)
                & (sight.at < hole.end + margin)
                & (level > hole.bottom - margin)
                & (level < hole.top + margin)
            )
    corner = np.minimum(sight.at, shape.length[sight.edge] - sight.at) < LOCATE.corner_m
    for plane, edges in _wall_planes(pose, shape):
        yield pose.room_id, plane, np.isin(sight.edge, edges) & ~near_hole & ~corner
    open_ = _open_to(shape, sight)
    for room_id in _rooms_behind(shape):
        through = (open_ == room_id) & well_inside
        for plane, edges in _wall_planes(pose, shapes[room_id]):
            yield room_id, plane, through & np.isin(sight.beyond_edge, edges)


def _open_to(shape: RoomShape, sight: Sight) -> np.ndarray:
    """Return the room (n,) str behind the door or passage that each ray meets, "" if none."""
    names = [
        (hole.room_behind or "") if hole.kind in OPEN and hole.bottom <= 0.0 else ""
        for hole in shape.holes
    ]
    return np.array([*names, ""])[sight.hole]


def _rooms_behind(shape: RoomShape) -> tuple[str, ...]:
    """Return the rooms behind a room's doors and passages, each once."""
    behind = (hole.room_behind for hole in shape.holes if hole.kind in OPEN)
    return tuple(dict.fromkeys(room for room in behind if room is not None))


def _wall_planes(pose: Pose, shape: RoomShape) -> Iterator[tuple[Plane, np.ndarray]]:
    """Yield each plane of a room's walls that faces the camera, with the edges that lie in it."""
    eye = pose.eye[[0, 2]]
    distance = ((shape.start - eye) * shape.outward).sum(axis=1)
    keys = np.round(np.column_stack([shape.outward, distance]), 2)
    for key in np.unique(keys[distance > 0.05], axis=0):
        edges = np.flatnonzero((keys == key).all(axis=1))
        x, z = shape.outward[edges[0]].tolist()
        offset = -float(distance[edges].mean())
        yield _plane("wall", (0.0 - x, 0.0, 0.0 - z), offset, pose), edges


def _plane(surface: str, normal: tuple[float, float, float], offset: float, pose: Pose) -> Plane:
    """Return a plane with an empty mask, in the plan's scale."""
    nothing = np.zeros((0, 0), bool)
    return Plane(surface, 0, normal, offset, nothing, "plan", pose.position[1])
