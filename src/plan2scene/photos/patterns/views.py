"""Rectify the floors that photos show: seen straight on, at a scale in metres."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from plan2scene.camera import Camera
from plan2scene.colour import rgb_to_lab
from plan2scene.errors import InputError
from plan2scene.photos.crops.filter import FILTER
from plan2scene.photos.locate.pose import read_poses
from plan2scene.photos.patterns.joints import JOINTS, Direction, directions, evened
from plan2scene.photos.photo_files import read_photo
from plan2scene.photos.planes.planes import PhotoPlane, plane_of_row, read_planes
from plan2scene.photos.planes.rectification import rectify
from plan2scene.stage_json import read_stage_json

#: Sources of a plane's scale that measure the camera's height; the others guess it.
_MEASURED = ("plan", "room_height")


@dataclass(frozen=True, eq=False)
class FloorView:
    """A floor in one photo, seen straight on."""

    photo: str
    rooms: tuple[str, ...]  #: rooms that it may belong to
    #: whether +x and +y (down) of the image are the plan's x and z; else those of the photo's frame
    in_plan: bool
    image: np.ndarray  #: (h, w, 3) uint8: sRGB at `JOINTS.px_per_m`
    mask: np.ndarray  #: (h, w) bool: the floor
    directions: list[Direction]  #: directions of its lines
    px_per_m: float = JOINTS.px_per_m  #: photo pixels per metre where it is seen best
    #: height of the camera, from which the view's scale follows; NaN if it is a guess
    camera_m: float = float("nan")
    #: factor from the view's metres to metres at the house's usual camera height
    usual: float = 1.0

    @property
    def square_m(self) -> float:
        """Return the area of the floor that is seen, square metres."""
        return float(self.mask.sum()) / JOINTS.px_per_m**2


@dataclass(frozen=True)
class PhotoFiles:
    """Files of a house's photos: the photos by name, and the outputs of earlier stages."""

    photos: Mapping[str, Path]
    masks: Path
    cameras: Path
    planes: Path


def photos_with_floors(
    files: PhotoFiles, *, house_id: str = ""
) -> list[Callable[[], list[FloorView]]]:
    """Return a function for each photo with floors, which reads that photo and returns them."""
    poses = read_poses(files.cameras)
    frames = read_stage_json(files.masks / "cameras.json", "cameras")

    def read(photo: str, rows: Sequence[Mapping[str, Any]]) -> list[FloorView]:
        if photo not in files.photos or photo not in frames:
            expected = "a camera of every photo with planes"
            raise InputError(expected, f"none of {photo}", file=files.cameras, house=house_id)
        image = read_photo(files.photos[photo], house_id=house_id)
        own, pose = Camera.from_json(frames[photo], file=files.masks), poses.get(photo)
        items = [plane_of_row(row, image.shape[:2]) for row in rows]
        camera = own if pose is None else pose.camera
        return list(_floor_views(photo, image, camera, items, placed=pose is not None))

    floors = {
        photo: [row for row in rows if row["surface"] == "floor"]
        for photo, rows in sorted(read_planes(files.planes).items())
    }
    return [partial(read, photo, rows) for photo, rows in floors.items() if rows]


def with_usual_height(views: Sequence[FloorView]) -> list[FloorView]:
    """Return the views with `usual` set by the median camera height of the house.

    All photos of a house are taken from about one height (a tripod, one person), while the measured
    height of a single photo may be off by a fifth.
    """
    heights = {view.photo: view.camera_m for view in views if np.isfinite(view.camera_m)}
    usual = float(np.median(list(heights.values()))) if heights else float("nan")
    return [
        replace(view, usual=usual / view.camera_m) if np.isfinite(view.camera_m) else view
        for view in views
    ]


def _floor_views(
    photo: str, image: np.ndarray, camera: Camera, planes: Sequence[PhotoPlane], *, placed: bool
) -> Iterator[FloorView]:
    """Yield the floors of which a photo (h, w, 3) uint8 sRGB shows a large enough part.

    `placed` tells whether the photo has a pose: `camera` is in the plan's frame then.
    """
    for item in planes:
        whole = rectify(image, camera, item.plane, min_density=JOINTS.least_px_per_m)
        if whole is None:
            continue
        straight, mask = whole.at_scale(JOINTS.px_per_m)
        floor = of_one_colour(straight, mask)
        line_directions = directions(*evened(straight, floor))
        if line_directions:
            plane = item.plane
            known = plane.scale_source in _MEASURED
            height = plane.camera_height_m if known else float("nan")
            shown = straight, floor, line_directions, 1.0 / whole.metres_per_pixel, height
            yield FloorView(photo, item.rooms, placed, *shown)


def of_one_colour(image: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Return a floor mask without parts whose colour differs from its largest part (a blanket).

    `image` (h, w, 3) uint8 sRGB, `mask` (h, w) bool. Lightness, which light changes, counts half.
    """
    count, number, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    if count <= 2:
        return mask
    shown = [np.median(image[number == k], axis=0) for k in range(1, count)]
    labs = rgb_to_lab(np.array(shown) / 255.0)
    largest = int(stats[1:, cv2.CC_STAT_AREA].argmax())
    away = np.linalg.norm((labs - labs[largest]) * np.array([0.5, 1.0, 1.0]), axis=1)
    return np.r_[False, away <= FILTER.group_limit][number]
