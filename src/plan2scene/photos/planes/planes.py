"""Planes of a photo: one floor, one ceiling, walls split by the direction that they face.

Positions are metres from the camera centre in the photo's Manhattan frame (x, y up, z;
``docs/conventions.md``). A plane is the set of points X with ``normal . X = offset``. Normals point
into the room, so offsets are negative.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.io import read_parquet, write_parquet
from plan2scene.photos.labels.palette import CEILING, FLOOR, WALL
from plan2scene.photos.planes.walls import PLANES, RoomSize, TracedWalls, trace_walls, within_room


@dataclass(frozen=True)
class Plane:
    """One plane of a photo."""

    surface: str  #: ``floor``, ``wall`` or ``ceiling``
    #: Number within the surface: walls from the largest to the smallest, 0..9; floor and ceiling
    #: are 0. A located photo that shows other rooms can have more of each.
    index: int
    #: (3,): Unit normal into the room, in the frame of the camera that the photo was split with.
    normal: tuple[float, float, float]
    offset: float  #: ``normal . X`` of its points, metres from the camera centre.
    mask: np.ndarray  #: (h, w) bool: Its pixels
    #: What gave the distance: ``camera_height`` (prior), ``room_height`` (feet and tops of walls
    #: with a known room height), ``room_extent`` (the prior put walls farther away, or opposite
    #: walls farther apart or nearer, than the plan has them), ``plan`` (the photo is located), or
    #: ``prior`` (the photo shows nothing that gives it).
    scale_source: str
    camera_height_m: float = PLANES.camera_height_m  #: height of the camera above the floor, metres


@dataclass(frozen=True)
class PhotoPlane:
    """A plane of a photo and the rooms that it may belong to."""

    #: Candidate rooms of one size; of a located photo the one room that the plan gives.
    rooms: tuple[str, ...]
    plane: Plane
    own: bool = True  #: whether the photo was taken inside that room
    #: Ids of the walls on the plane, if the photo is located.
    walls: tuple[str, ...] = ()

    @property
    def in_plan(self) -> bool:
        """Whether the plane is in the plan's frame, else in the photo's Manhattan frame."""
        return self.plane.scale_source == "plan"


def split_planes(
    labels: np.ndarray,
    camera: Camera,
    *,
    segments: np.ndarray | None = None,
    camera_height_m: float = PLANES.camera_height_m,
    room_height_m: float | None = None,
    room_extent_m: tuple[float, float] | None = None,
) -> list[Plane]:
    """Return the planes of a photo: floor, ceiling, then walls by size.

    `labels` (h, w) uint8 are 0 other, 1 floor, 2 wall, 3 ceiling, 255 ignore, of the camera's size.
    `segments` (n, 4) float64, pixels (`lines.find_segments`, those of walls), help to find which
    way a wall faces, if neither its foot nor its top is seen. `camera_height_m` is the prior of the
    camera's height above the floor. If enough feet and tops of walls are seen, the height follows
    from `room_height_m` of the plan. Else `room_extent_m`, the sides of the room's rectangle in the
    plan (`walls.room_extent`), bounds the height, or gives it if opposite walls are seen.
    """
    room = PLANES.room_height_m if room_height_m is None else room_height_m
    prior = min(camera_height_m, 0.8 * room)
    known, size = room_height_m is not None, RoomSize(room, room_extent_m)
    traced = trace_walls(labels, camera, prior, size, solve_height=known, segments=segments)
    return [*_flat_planes(labels, camera, traced, size, known=known), *_wall_planes(labels, traced)]


def _flat_planes(
    labels: np.ndarray, camera: Camera, traced: TracedWalls, room: RoomSize, *, known: bool
) -> list[Plane]:
    """Return the room's floor and ceiling, if seen; `known`: the plan gives the room's height."""
    height, source = traced.camera_height_m, traced.scale_source
    # Without the room's height the ceiling's distance is a guess, even if the floor's is known.
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
    """Return the largest walls, the largest first."""
    wall = (labels == WALL) & ~traced.through
    masks = [without_specks(wall & (traced.owner == k)) for k in range(len(traced.lines))]
    walls = sorted(zip(traced.lines, masks, strict=True), key=lambda item: -int(item[1].sum()))
    planes = []
    for index, (line, mask) in enumerate(walls[: PLANES.max_walls]):
        if not mask.any():
            break
        source = traced.scale_source if line.seen else "prior"
        normal = (0.0 - line.outward[0], 0.0, 0.0 - line.outward[1])
        height = traced.camera_height_m
        planes.append(Plane("wall", index, normal, -line.distance, mask, source, height))
    return planes


def without_specks(mask: np.ndarray) -> np.ndarray:
    """Return a mask without connected parts smaller than `PLANES.min_share` of the photo."""
    count, parts, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    keep = stats[:, cv2.CC_STAT_AREA] >= max(1.0, PLANES.min_share * mask.size)
    keep[0] = False
    return np.asarray(keep[parts]) if count > 1 else np.zeros_like(mask)


#: Columns of planes.parquet (docs/conventions.md).
_COLUMNS = {
    "photo": "str",
    "rooms": "str",
    "surface": "str",
    "plane": "int64",
    "own": "bool",
    "walls": "str",
    "normal": "object",
    "offset": "float64",
    "scale_source": "str",
    "camera_height_m": "float64",
    "polygons": "object",
}


def plane_row(photo: str, item: PhotoPlane) -> dict[str, Any]:
    """Return a plane's row of planes.parquet; its pixels are written as polygons."""
    plane = item.plane
    mask = plane.mask.astype(np.uint8)
    contours, _ = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    return {
        "photo": photo,
        "rooms": "|".join(item.rooms),
        "surface": plane.surface,
        "plane": plane.index,
        "own": item.own,
        "walls": "|".join(item.walls),
        "normal": list(plane.normal),
        "offset": plane.offset,
        "scale_source": plane.scale_source,
        "camera_height_m": plane.camera_height_m,
        "polygons": [contour.ravel().tolist() for contour in contours],
    }


def write_planes(
    path: str | Path, rows: Sequence[Mapping[str, Any]], *, dataset: str, house_id: str
) -> None:
    """Write the planes of a house's photos; `rows` are those of :func:`plane_row`."""
    import pandas as pd

    table = pd.DataFrame(rows, columns=list(_COLUMNS)).astype(_COLUMNS)
    write_parquet(path, table, {"dataset": dataset, "house": house_id})


def read_planes(path: str | Path) -> dict[str, list[dict[str, Any]]]:
    """Return photo -> rows of planes.parquet."""
    table, _ = read_parquet(path)
    rows: dict[str, list[dict[str, Any]]] = {}
    for row in table.to_dict("records"):
        rows.setdefault(row["photo"], []).append(row)
    return rows


def plane_of_row(row: Mapping[str, Any], size: tuple[int, int]) -> PhotoPlane:
    """Return the plane in a row of planes.parquet; `size` is (height, width) of the photo."""
    mask = np.zeros(size, np.uint8)
    cv2.fillPoly(mask, [np.array(ring, np.int32).reshape(-1, 2) for ring in row["polygons"]], 1)
    x, y, z = (float(value) for value in row["normal"])
    plane = Plane(
        row["surface"],
        int(row["plane"]),
        (x, y, z),
        float(row["offset"]),
        mask > 0,
        row["scale_source"],
        float(row["camera_height_m"]),
    )
    rooms, walls = (tuple(filter(None, row[key].split("|"))) for key in ("rooms", "walls"))
    return PhotoPlane(rooms, plane, bool(row["own"]), walls)
