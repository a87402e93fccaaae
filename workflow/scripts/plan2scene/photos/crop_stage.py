"""The crops stage: photos, masks and cameras of one house -> crops.parquet."""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.errors import InputError
from plan2scene.house import SURFACES, House
from plan2scene.io import png_bytes, read_image, read_json, write_parquet
from plan2scene.photos.camera import Camera
from plan2scene.photos.crops import (
    CROP_METRES,
    CROP_PX,
    CROPS_PER_MASK,
    TRIES,
    Crop,
    medoid_index,
    sample_crops,
)
from plan2scene.photos.masks import read_label_png
from plan2scene.photos.planes import DEFAULT_CAMERA_HEIGHT_M, split_planes
from plan2scene.seeds import generator

if TYPE_CHECKING:
    import pandas as pd

_log = logging.getLogger("plan2scene")

#: Where crops come from (config key ``crops.source``).
SOURCES = ("sampled", "precomputed")
#: Columns of crops.parquet with the type of an empty one (docs/conventions.md).
COLUMNS = {
    "crop_id": "str",
    "photo": "str",
    "room_id": "str",
    "surface": "str",
    "plane": "int64",
    "index": "int64",
    "window": "object",
    "metres": "float64",
    "sharpness": "float64",
    "grazing_deg": "float64",
    "medoid": "bool",
    "png": "object",
}
_CROP_NAME = re.compile(r"(?P<stem>.+)_(?P<mask>\d+)_crop(?P<index>\d+)\.png")


@dataclass(frozen=True)
class CropSettings:
    """How windows are drawn: see :func:`plan2scene.photos.crops.sample_crops`.

    `camera_height_m` is the prior of :func:`plan2scene.photos.planes.split_planes`.
    """

    metres: tuple[float, ...] = CROP_METRES
    per_mask: int = CROPS_PER_MASK
    tries: int = TRIES
    camera_height_m: float = DEFAULT_CAMERA_HEIGHT_M


@dataclass(frozen=True)
class PhotoCrop:
    """A crop with the surface and plane (mask) that it is from."""

    surface: str
    plane: int
    crop: Crop


def make_crops(
    house: House,
    rooms_of_photo: Mapping[str, Sequence[str]],
    photos: Mapping[str, Path],
    masks_dir: str | Path,
    output: str | Path,
    *,
    dataset: str,
    seed: int,
    settings: CropSettings | None = None,
) -> pd.DataFrame:
    """Sample the crops of every photo of a house and write crops.parquet.

    Parameters
    ----------
    house : House
        The plan; gives the rooms' heights.
    rooms_of_photo : mapping
        Photo name to the rooms it shows; a photo of several rooms gives rows for each.
    photos : mapping
        Photo name to its file.
    masks_dir : path
        Output of the masks stage. Photos that it left out (``warnings.json``) are skipped.
    output : path
        The Parquet file, ``docs/conventions.md``.
    dataset : str
        Name for the metadata.
    seed : int
        Windows are drawn by (seed, house, photo, surface, plane).
    settings : CropSettings, optional
        Sampling settings; the paper's by default.

    Returns
    -------
    pandas.DataFrame
        What was written.
    """
    chosen = CropSettings() if settings is None else settings
    check_rooms(house, rooms_of_photo)
    folder = Path(masks_dir)
    cameras = read_json(folder / "cameras.json")
    crops: dict[str, list[PhotoCrop]] = {}
    for photo in sorted(rooms_of_photo):
        if photo not in cameras:
            _log.info("photo %s of house %s has no mask: skipped", photo, house.id)
            continue
        camera = Camera.from_json(cameras[photo], file=folder / "cameras.json")
        labels = read_label_png(folder / f"{Path(photo).stem}.png", house=house.id)
        image = read_image(photos[photo], house=house.id)
        _check_sizes(image, labels, camera, photos[photo], house.id)
        height = house.room(rooms_of_photo[photo][0]).height
        crops[photo] = crops_of_photo(
            image, labels, camera, height, chosen, seed=seed, names=(house.id, photo)
        )
        _log.info("%s: %d crops, camera %s", photo, len(crops[photo]), camera.focal_source)
    return _write(crops, rooms_of_photo, output, dataset, house.id)


def crops_of_photo(
    image: np.ndarray,
    labels: np.ndarray,
    camera: Camera,
    room_height_m: float,
    settings: CropSettings,
    *,
    seed: int,
    names: Sequence[object],
) -> list[PhotoCrop]:
    """Return the crops of all planes of one photo.

    `image` (h, w, 3) uint8 sRGB, `labels` (h, w) uint8; `names` are the house and photo that
    the windows' seed derives from.
    """
    planes = split_planes(
        labels,
        camera,
        image=image,
        camera_height_m=settings.camera_height_m,
        room_height_m=room_height_m,
    )
    return [
        PhotoCrop(plane.surface, plane.index, crop)
        for plane in planes
        for crop in sample_crops(
            image,
            camera,
            plane,
            generator(seed, "crops", *names, plane.surface, plane.index),
            metres=settings.metres,
            per_mask=settings.per_mask,
            tries=settings.tries,
        )
    ]


def load_crops(
    house: House,
    rooms_of_photo: Mapping[str, Sequence[str]],
    folder: str | Path,
    output: str | Path,
    *,
    dataset: str,
) -> pd.DataFrame:
    """Write crops.parquet from ready crops in Rent3D++'s ``surface_crops`` layout.

    `folder` has ``{floor,wall,ceiling}/{photo stem}_{mask}_crop{k}.png`` of 128x128; their size
    in metres, window, sharpness and grazing angle are unknown (NaN). Raises InputError when
    there is no such folder or a crop has another size.
    """
    root = Path(folder)
    if not root.is_dir():
        raise InputError("a folder of surface crops", "no such folder", file=root, house=house.id)
    check_rooms(house, rooms_of_photo)
    crops: dict[str, list[PhotoCrop]] = {photo: [] for photo in sorted(rooms_of_photo)}
    photo_of_stem = {Path(photo).stem: photo for photo in crops}
    for surface in SURFACES:
        for path in sorted((root / surface).glob("*.png")):
            match = _CROP_NAME.fullmatch(path.name)
            if match is None or match["stem"] not in photo_of_stem:
                continue
            crop = _ready_crop(path, int(match["index"]), house.id)
            crops[photo_of_stem[match["stem"]]].append(PhotoCrop(surface, int(match["mask"]), crop))
    return _write(crops, rooms_of_photo, output, dataset, house.id)


def _ready_crop(path: Path, index: int, house: str) -> Crop:
    """Return a crop read from a file."""
    image = read_image(path, house=house)
    if image.shape != (CROP_PX, CROP_PX, 3):
        raise InputError(
            f"a crop of {CROP_PX}x{CROP_PX}",
            f"{image.shape[1]}x{image.shape[0]}",
            file=path,
            house=house,
        )
    nan = float("nan")
    return Crop(index, (nan, nan, nan, nan), nan, nan, nan, image)


def check_rooms(house: House, rooms_of_photo: Mapping[str, Sequence[str]]) -> None:
    """Raise InputError when a photo is assigned to a room that the plan lacks."""
    known = {room.id for room in house.rooms}
    for photo, rooms in rooms_of_photo.items():
        for room in rooms:
            if room not in known:
                raise InputError(
                    f"a room of the plan ({', '.join(sorted(known))})",
                    f"{room} in the photo table for {photo}",
                    house=house.id,
                    room=room,
                )


def _check_sizes(
    image: np.ndarray, labels: np.ndarray, camera: Camera, path: Path, house: str
) -> None:
    """Raise InputError when photo, mask and camera are of different sizes."""
    height, width = image.shape[:2]
    if labels.shape != (height, width) or (camera.height, camera.width) != (height, width):
        raise InputError(
            f"mask and camera of the photo's size {width}x{height}",
            f"mask {labels.shape[1]}x{labels.shape[0]}, camera {camera.width}x{camera.height}",
            file=path,
            house=house,
        )


def _write(
    crops: Mapping[str, Sequence[PhotoCrop]],
    rooms_of_photo: Mapping[str, Sequence[str]],
    output: str | Path,
    dataset: str,
    house: str,
) -> pd.DataFrame:
    """Write one row per crop and room, the medoid of each surface marked."""
    import pandas as pd

    rows: list[dict[str, Any]] = []
    images: dict[tuple[str, str], list[tuple[int, np.ndarray]]] = {}
    for photo in sorted(crops):
        encoded = [png_bytes(item.crop.image) for item in crops[photo]]
        for room in dict.fromkeys(rooms_of_photo[photo]):
            for item, png in zip(crops[photo], encoded, strict=True):
                images.setdefault((room, item.surface), []).append((len(rows), item.crop.image))
                rows.append(_row(photo, room, item, png))
    for members in images.values():
        rows[members[medoid_index([image for _, image in members])][0]]["medoid"] = True
    frame = pd.DataFrame(rows, columns=list(COLUMNS)).astype(COLUMNS)
    write_parquet(output, frame, {"dataset": dataset, "house": house})
    return frame


def _row(photo: str, room: str, item: PhotoCrop, png: bytes) -> dict[str, Any]:
    """Return the row of one crop in one room."""
    crop = item.crop
    return {
        "crop_id": f"{item.surface}/{Path(photo).stem}_{item.plane}_crop{crop.index}",
        "photo": photo,
        "room_id": room,
        "surface": item.surface,
        "plane": item.plane,
        "index": crop.index,
        "window": [float(value) for value in crop.window],
        "metres": crop.metres,
        "sharpness": crop.sharpness,
        "grazing_deg": crop.grazing_deg,
        "medoid": False,
        "png": png,
    }
