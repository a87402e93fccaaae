"""The crops stage: photos, masks and camera poses of a house -> crops, planes, colours, light."""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.camera import Camera
from plan2scene.errors import InputError
from plan2scene.house import SURFACES, House
from plan2scene.images import read_image
from plan2scene.io import write_json
from plan2scene.paint.light import estimate_light, house_gains
from plan2scene.paint.observations import PlaneColours, SurfaceColour, write_colours
from plan2scene.parallel import each
from plan2scene.photos.camera.lines import SEGMENTS, read_segments
from plan2scene.photos.crops.candidates import candidates_of_photo, planes_of_photo
from plan2scene.photos.crops.colours import (
    colours_of_photo,
    door_colours,
    frame_colours,
    surface_colours,
)
from plan2scene.photos.crops.filter import inner_mask, mark_outvoted, strong_edges
from plan2scene.photos.crops.floor_parts import floor_parts, of_other_rooms
from plan2scene.photos.crops.sampling import CROP_PX, CROPS, Candidate, Crop, CropSettings, Verdict
from plan2scene.photos.crops.selection import write_tables
from plan2scene.photos.labels.palette import (
    DOOR,
    OTHER,
    PROBABILITIES,
    WINDOW,
    read_label_png,
    read_probability_png,
)
from plan2scene.photos.locate.plan_view import RoomShape, room_shapes
from plan2scene.photos.locate.pose import Pose, read_poses
from plan2scene.photos.locate.seen_doors import seen_doors
from plan2scene.photos.locate.seen_planes import seen_planes
from plan2scene.photos.photo_files import read_photo
from plan2scene.photos.planes.planes import plane_row, write_planes
from plan2scene.seeds import generator
from plan2scene.stage_json import read_stage_json

if TYPE_CHECKING:
    import pandas as pd

_log = logging.getLogger("plan2scene")
_CROP_NAME = re.compile(r"(?P<stem>.+)_(?P<mask>\d+)_crop(?P<index>\d+)\.png")


@dataclass(frozen=True)
class CropFiles:
    """Files that the stage writes: four Parquet files and light.json (``docs/conventions.md``)."""

    crops: str | Path
    candidates: str | Path
    planes: str | Path
    colours: str | Path
    light: str | Path


@dataclass(frozen=True, eq=False)
class PhotoCrops:
    """What the stage takes from one photo."""

    candidates: list[Candidate]
    #: Rows of planes.parquet.
    planes: list[dict[str, Any]]
    colours: list[PlaneColours]
    floors: list[PlaneColours]  #: colours of the parts of its floors (:func:`floor_parts`)
    surfaces: list[SurfaceColour]


@dataclass(frozen=True, eq=False)
class HouseCrops:
    """What the stage takes from all photos of a house."""

    candidates: list[Candidate]
    #: Rows of planes.parquet.
    planes: list[dict[str, Any]] = field(default_factory=list)
    colours: list[PlaneColours] = field(default_factory=list)
    #: Photo -> gains (3,) of :func:`plan2scene.paint.light.house_gains`.
    gains: dict[str, np.ndarray] = field(default_factory=dict)
    #: Whether the crops come from a folder; they keep their candidates' numbers then.
    precomputed: bool = False


def write_crops(
    made: HouseCrops, output: CropFiles, *, dataset: str, house_id: str
) -> pd.DataFrame:
    """Write the stage's files and return the crop table."""
    names = {"dataset": dataset, "house_id": house_id}
    gains = {photo: [round(float(g), 6) for g in made.gains[photo]] for photo in sorted(made.gains)}
    write_json(output.light, {"gains": gains})
    write_planes(output.planes, made.planes, **names)
    write_colours(output.colours, made.colours, **names)
    tables = (output.crops, output.candidates)
    return write_tables(made.candidates, *tables, keep_index=made.precomputed, **names)


def crops_of_house(
    house: House,
    rooms_of_photo: Mapping[str, Sequence[str]],
    photos: Mapping[str, Path],
    masks_dir: str | Path,
    *,
    seed: int,
    settings: CropSettings = CROPS,
    cameras: str | Path | None = None,
    threads: int = 1,
) -> HouseCrops:
    """Sample the crops of a house's photos.

    A photo that is assigned to several rooms (`rooms_of_photo`, ``photo_rooms.json``) gives rows
    for each of them; each room's height and extent give the distances of its planes. `masks_dir` is
    the output of the masks stage; photos that it left out (``warnings.json``) are skipped. The
    random draws are seeded by (seed, house, photo, surface, plane). With `cameras`
    (``cameras.json`` of the places stage) a located photo gives each room in sight its own crops.
    The result does not depend on the number of `threads`.
    """
    masks_dir = Path(masks_dir)
    camera_entries = read_stage_json(masks_dir / "cameras.json", "cameras")
    labelled = []
    for photo in sorted(rooms_of_photo):
        if photo in camera_entries:
            labelled.append(photo)
        else:
            _log.info("photo %s of house %s has no mask: skipped", photo, house.id)
    one = partial(
        _crops_of_photo,
        house=house,
        masks_dir=masks_dir,
        known=camera_entries,
        segments=cache(partial(read_segments, masks_dir / SEGMENTS, "walls")),
        poses={} if cameras is None else read_poses(cameras, house),
        shapes=room_shapes(house),
        seed=seed,
        settings=settings,
    )
    photo_crops = list(
        each(lambda photo: one(photo, photos[photo], rooms_of_photo[photo]), labelled, threads)
    )
    surfaces = [surface for item in photo_crops for surface in item.surfaces]
    lights = estimate_light(surfaces)
    foreign_parts = of_other_rooms([floor for item in photo_crops for floor in item.floors], lights)
    for k, photo in enumerate(labelled):
        if photo in foreign_parts:
            rooms = rooms_of_photo[photo]
            photo_crops[k] = one(photo, photos[photo], rooms, left_out=foreign_parts[photo])
    candidates = [candidate for item in photo_crops for candidate in item.candidates]
    return HouseCrops(
        mark_outvoted(candidates, lights) if settings.filter else candidates,
        [row for item in photo_crops for row in item.planes],
        [colours for item in photo_crops for colours in item.colours],
        house_gains(lights, surfaces),
    )


def _crops_of_photo(
    photo: str,
    path: Path,
    rooms: Sequence[str],
    *,
    house: House,
    masks_dir: Path,
    known: Mapping[str, Any],
    segments: Callable[[], Mapping[str, np.ndarray]],
    poses: Mapping[str, Pose],
    shapes: Mapping[str, RoomShape],
    seed: int,
    settings: CropSettings,
    left_out: Collection[int] = (),
) -> PhotoCrops:
    """Return the crops of one photo; `left_out` are numbers of floor parts that are not used."""
    camera = Camera.from_json(known[photo], file=masks_dir / "cameras.json")
    labels = read_label_png(masks_dir / f"{Path(photo).stem}.png", house_id=house.id)
    image = read_photo(path, house_id=house.id)
    _check_sizes(image, labels, camera, path, house.id)
    rooms = list(dict.fromkeys(rooms))
    planes = seen_planes(labels, poses[photo], shapes) if photo in poses else []
    if planes:
        camera = poses[photo].camera
    else:
        shown_rooms = [house.room(room) for room in rooms]
        planes = planes_of_photo(
            labels, camera, segments().get(photo), shown_rooms, settings.camera_height_m
        )
    parts = [part for item in planes for part in floor_parts(item, image)]
    floors = [part for part in parts if part.plane.surface == "floor"]
    if left_out:
        planes = [p for p in parts if p.plane.surface != "floor" or p.plane.index not in left_out]
    edges = strong_edges(image)
    inner = [inner_mask(item.plane.mask, edges) for item in planes]
    rng = partial(generator, seed, "crops", house.id, photo)
    drawn_candidates = candidates_of_photo(image, camera, planes, settings, rng, inner)
    candidates = [replace(candidate, photo=photo) for candidate in drawn_candidates]
    _log.info("%s: %d candidates, camera %s", photo, len(candidates), camera.focal_source)
    colours = colours_of_photo(image, camera, planes, photo, inner)
    inner = [inner_mask(part.plane.mask, edges) for part in floors]
    in_parts = colours_of_photo(image, camera, floors, photo, inner)
    pose, likely = poses.get(photo), masks_dir / PROBABILITIES / f"{Path(photo).stem}.png"
    room = rooms[0] if pose is None else pose.room_id
    if likely.is_file():
        shares = read_probability_png(likely, house_id=house.id)
        likely_door = shares[DOOR]
        colours += frame_colours(image, labels, shares[WINDOW], photo, room)
    else:
        likely_door = 0.5 * (labels == OTHER)
    colours += door_colours(image, photo, room, seen_doors(labels, likely_door, pose, shapes))
    return PhotoCrops(
        candidates,
        [plane_row(photo, item) for item in planes],
        colours,
        in_parts,
        surface_colours(image, labels, photo, rooms, edges),
    )


def read_precomputed_crops(
    house: House, rooms_of_photo: Mapping[str, Sequence[str]], folder: str | Path
) -> HouseCrops:
    """Read precomputed crops from a folder in Rent3D++'s ``surface_crops`` layout.

    `folder` has ``{floor,wall,ceiling}/{photo stem}_{mask}_crop{k}.png`` of 128x128; their size
    in metres, window, sharpness and grazing angle are unknown (NaN). Raises InputError when
    there is no such folder or a crop has another size.
    """
    root = Path(folder)
    if not root.is_dir():
        raise InputError("a folder of surface crops", "no such folder", file=root, house=house.id)
    candidates: list[Candidate] = []
    photo_of_stem = {Path(photo).stem: photo for photo in rooms_of_photo}
    for surface in SURFACES:
        for path in sorted((root / surface).glob("*.png")):
            match = _CROP_NAME.fullmatch(path.name)
            if match is None or match["stem"] not in photo_of_stem:
                continue
            image = read_image(path, house_id=house.id)
            if image.shape != (CROP_PX, CROP_PX, 3):
                expected, found = f"{CROP_PX}x{CROP_PX}", f"{image.shape[1]}x{image.shape[0]}"
                raise InputError(f"a crop of {expected}", found, file=path, house=house.id)
            crop = Crop(int(match["index"]), (math.nan,) * 4, math.nan, math.nan, math.nan, image)
            photo = photo_of_stem[match["stem"]]
            rooms = tuple(dict.fromkeys(rooms_of_photo[photo]))
            mask = int(match["mask"])
            candidates.append(Candidate(crop, Verdict(), surface, mask, photo, rooms))
    candidates.sort(key=lambda candidate: candidate.photo)
    return HouseCrops(candidates, precomputed=True)


def _check_sizes(
    image: np.ndarray, labels: np.ndarray, camera: Camera, path: Path, house_id: str
) -> None:
    """Raise InputError when photo, mask and camera have different sizes."""
    height, width = image.shape[:2]
    if labels.shape != (height, width) or (camera.height, camera.width) != (height, width):
        expected = f"mask and camera of the photo's size {width}x{height}"
        found = f"mask {labels.shape[1]}x{labels.shape[0]}, camera {camera.width}x{camera.height}"
        raise InputError(expected, found, file=path, house=house_id)
