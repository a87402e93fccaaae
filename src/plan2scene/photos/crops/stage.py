"""The crops stage: photos, masks and cameras of one house -> the tables of its crops."""

from __future__ import annotations

import logging
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.camera import Camera
from plan2scene.errors import InputError
from plan2scene.house import SURFACES, House
from plan2scene.images import image_from_bytes, jpeg_bytes, read_image
from plan2scene.io import read_json, write_json
from plan2scene.paint.light import estimate_light, house_gains, relight
from plan2scene.paint.observations import PlaneColours, SurfaceColour, relit, write_colours
from plan2scene.parallel import each
from plan2scene.photos.crops.candidates import (
    CropSettings,
    Naming,
    candidates_of_photo,
    planes_of_located,
    planes_of_photo,
    rooms_by_size,
)
from plan2scene.photos.crops.colours import colours_of_photo, surface_colours
from plan2scene.photos.crops.filter import inner_mask, strong_edges
from plan2scene.photos.crops.house import agreeing
from plan2scene.photos.crops.sampling import CROP_PX, Candidate, Crop
from plan2scene.photos.crops.tables import PhotoCandidate, write_tables
from plan2scene.photos.crops.verdict import Verdict
from plan2scene.photos.labels.palette import read_label_png
from plan2scene.photos.locate.plan_view import RoomShape, room_shapes
from plan2scene.photos.locate.pose import Pose
from plan2scene.photos.locate.stage import read_poses
from plan2scene.photos.photo_files import read_photo

if TYPE_CHECKING:
    import pandas as pd

_log = logging.getLogger("plan2scene")

_CROP_NAME = re.compile(r"(?P<stem>.+)_(?P<mask>\d+)_crop(?P<index>\d+)\.png")


@dataclass(frozen=True)
class CropFiles:
    """What the stage writes: three Parquet files and light.json, ``docs/conventions.md``."""

    crops: str | Path
    candidates: str | Path
    colours: str | Path
    light: str | Path


@dataclass(frozen=True, eq=False)
class Drawn:
    """What photos of a house show, as photographed, and each photo's gains (3,)."""

    candidates: list[PhotoCandidate]
    colours: list[PlaneColours]
    #: As of :func:`plan2scene.paint.light.house_gains`.
    gains: dict[str, np.ndarray]


def make_crops(
    house: House,
    rooms_of_photo: Mapping[str, Sequence[str]],
    photos: Mapping[str, Path],
    masks_dir: str | Path,
    output: CropFiles,
    *,
    dataset: str,
    seed: int,
    settings: CropSettings | None = None,
    cameras: str | Path | None = None,
    threads: int = 1,
) -> pd.DataFrame:
    """Sample the crops of every photo of a house and write the stage's files.

    Parameters
    ----------
    house : House
        The plan; gives the rooms' heights.
    rooms_of_photo : mapping
        Photo name to the rooms of the house that it shows (`datasets.rooms_of_photos`); a photo
        of several rooms gives rows for each, with the planes at the distance that each room's own
        height tells.
    photos : mapping
        Photo name to its file.
    masks_dir : path
        Output of the masks stage. Photos that it left out (``warnings.json``) are skipped.
    output : CropFiles
        What is written.
    dataset : str
        Name for the metadata.
    seed : int
        Windows are drawn by (seed, house, photo, surface, plane).
    settings : CropSettings, optional
        How windows are drawn and corrected.
    cameras : path, optional
        ``cameras.json`` of the locate stage: located photos give each room in sight its own.
    threads : int
        Photos worked on at a time; the result does not depend on it.

    Returns
    -------
    pandas.DataFrame
        The crops that were written.
    """
    chosen = CropSettings() if settings is None else settings
    shown = (house, rooms_of_photo, photos, masks_dir)
    drawn = draw_candidates(*shown, seed=seed, settings=chosen, cameras=cameras, threads=threads)
    candidates, colours = drawn.candidates, drawn.colours
    if chosen.colours == "corrected":
        candidates, colours = corrected(candidates, drawn.gains), relit(colours, drawn.gains)
    _write_light(output.light, drawn.gains, chosen)
    names = {"dataset": dataset, "house_id": house.id, "colours": chosen.colours}
    write_colours(output.colours, colours, **names)
    return write_tables(
        candidates, output.crops, output.candidates, dataset=dataset, house_id=house.id
    )


def draw_candidates(
    house: House,
    rooms_of_photo: Mapping[str, Sequence[str]],
    photos: Mapping[str, Path],
    masks_dir: str | Path,
    *,
    seed: int,
    settings: CropSettings,
    cameras: str | Path | None = None,
    threads: int = 1,
) -> Drawn:
    """Return what all photos of a house show. Parameters as in :func:`make_crops`."""
    known = read_json(Path(masks_dir) / "cameras.json")
    shown = []
    for photo in sorted(rooms_of_photo):
        if photo in known:
            shown.append(photo)
        else:
            _log.info("photo %s of house %s has no mask: skipped", photo, house.id)
    one = partial(
        _of_photo,
        house=house,
        masks_dir=Path(masks_dir),
        known=known,
        poses={} if cameras is None else read_poses(cameras),
        shapes=room_shapes(house),
        seed=seed,
        settings=settings,
    )
    drawn: list[PhotoCandidate] = []
    seen: list[PlaneColours] = []
    colours: list[SurfaceColour] = []
    found = each(lambda photo: one(photo, photos[photo], rooms_of_photo[photo]), shown, threads)
    for of_photo, seen_here, of_surfaces in found:
        drawn += of_photo
        seen += seen_here
        colours += of_surfaces
    lights = estimate_light(colours)
    gains = house_gains(lights, colours)
    return Drawn(agreeing(drawn, lights) if settings.filter else drawn, seen, gains)


def _of_photo(
    photo: str,
    path: Path,
    rooms: Sequence[str],
    *,
    house: House,
    masks_dir: Path,
    known: Mapping[str, Any],
    poses: Mapping[str, Pose],
    shapes: Mapping[str, RoomShape],
    seed: int,
    settings: CropSettings,
) -> tuple[list[PhotoCandidate], list[PlaneColours], list[SurfaceColour]]:
    """Return what one photo shows."""
    camera = Camera.from_json(known[photo], file=masks_dir / "cameras.json")
    labels = read_label_png(masks_dir / f"{Path(photo).stem}.png", house_id=house.id)
    image = read_photo(path, house_id=house.id)
    _check_sizes(image, labels, camera, path, house.id)
    names = Naming(seed, house.id, photo)
    rooms = list(dict.fromkeys(rooms))
    planes = planes_of_located(labels, poses[photo], shapes) if photo in poses else []
    if planes:
        camera = poses[photo].camera
    else:
        planes = planes_of_photo(image, labels, camera, rooms_by_size(house, rooms), settings)
    edges = strong_edges(image)
    inner = [inner_mask(shown.plane.mask, edges) for shown in planes]
    drawn = candidates_of_photo(image, camera, planes, settings, names, inner)
    _log.info("%s: %d candidates, camera %s", photo, len(drawn), camera.focal_source)
    seen = colours_of_photo(image, camera, planes, photo, inner)
    return drawn, seen, surface_colours(image, labels, photo, rooms, edges)


def corrected(
    drawn: Sequence[PhotoCandidate], gains: Mapping[str, np.ndarray]
) -> list[PhotoCandidate]:
    """Return the candidates with the linear RGB of their images times their photo's gains (3,)."""
    return [_under(item, gains.get(item.photo, np.ones(3))) for item in drawn]


def _under(item: PhotoCandidate, gains: np.ndarray) -> PhotoCandidate:
    """Return a candidate whose image's linear RGB is multiplied by `gains` (3,)."""
    crop = item.candidate.crop
    detail = crop.detail
    if detail:
        even = relight(image_from_bytes(detail), gains)
        detail = jpeg_bytes(even, quality=95, full_colour=True)
    crop = replace(crop, image=relight(crop.image, gains), detail=detail)
    return replace(item, candidate=replace(item.candidate, crop=crop))


def _write_light(
    path: str | Path, gains: Mapping[str, np.ndarray], settings: CropSettings | None
) -> None:
    """Write light.json; `settings` None where crops are taken as they are."""
    used = {
        "filter": settings is not None and settings.filter,
        "colours": "photo" if settings is None else settings.colours,
    }
    photos = {photo: [round(float(gain), 6) for gain in gains[photo]] for photo in sorted(gains)}
    write_json(path, {**used, "gains": photos})


def load_crops(
    house: House,
    rooms_of_photo: Mapping[str, Sequence[str]],
    folder: str | Path,
    output: CropFiles,
    *,
    dataset: str,
) -> pd.DataFrame:
    """Write the stage's files from ready crops in Rent3D++'s ``surface_crops`` layout.

    `folder` has ``{floor,wall,ceiling}/{photo stem}_{mask}_crop{k}.png`` of 128x128; their size
    in metres, window, sharpness and grazing angle are unknown (NaN). Raises InputError when
    there is no such folder or a crop has another size.
    """
    root = Path(folder)
    if not root.is_dir():
        raise InputError("a folder of surface crops", "no such folder", file=root, house=house.id)
    found: list[PhotoCandidate] = []
    photo_of_stem = {Path(photo).stem: photo for photo in rooms_of_photo}
    for surface in SURFACES:
        for path in sorted((root / surface).glob("*.png")):
            match = _CROP_NAME.fullmatch(path.name)
            if match is None or match["stem"] not in photo_of_stem:
                continue
            crop = _ready_crop(path, int(match["index"]), house.id)
            photo = photo_of_stem[match["stem"]]
            rooms = tuple(dict.fromkeys(rooms_of_photo[photo]))
            ready = Candidate(crop, Verdict())
            found.append(PhotoCandidate(photo, rooms, surface, int(match["mask"]), ready))
    found.sort(key=lambda item: item.photo)
    _write_light(output.light, {}, None)
    write_colours(output.colours, [], dataset=dataset, house_id=house.id)
    return write_tables(
        found,
        output.crops,
        output.candidates,
        dataset=dataset,
        house_id=house.id,
        keep_index=True,
    )


def _ready_crop(path: Path, index: int, house_id: str) -> Crop:
    """Return a crop read from a file."""
    image = read_image(path, house_id=house_id)
    if image.shape != (CROP_PX, CROP_PX, 3):
        found = f"{image.shape[1]}x{image.shape[0]}"
        raise InputError(f"a crop of {CROP_PX}x{CROP_PX}", found, file=path, house=house_id)
    nan = float("nan")
    return Crop(index, (nan, nan, nan, nan), nan, nan, nan, image)


def _check_sizes(
    image: np.ndarray, labels: np.ndarray, camera: Camera, path: Path, house_id: str
) -> None:
    """Raise InputError when photo, mask and camera are of different sizes."""
    height, width = image.shape[:2]
    if labels.shape != (height, width) or (camera.height, camera.width) != (height, width):
        expected = f"mask and camera of the photo's size {width}x{height}"
        found = f"mask {labels.shape[1]}x{labels.shape[0]}, camera {camera.width}x{camera.height}"
        raise InputError(expected, found, file=path, house=house_id)
