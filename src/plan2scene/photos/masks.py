"""The masks stage: photos of one house -> label PNGs and camera estimates."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import cv2
import numpy as np

from plan2scene.camera import Camera, focal_of
from plan2scene.errors import InputError
from plan2scene.io import atomic_directory, safe_join, write_json
from plan2scene.photos.camera.calibration import DEFAULT_FOV_DEG, estimate_camera
from plan2scene.photos.camera.exif import ExifFocal, read_exif_focal
from plan2scene.photos.camera.lens import with_shared_lenses
from plan2scene.photos.camera.lines import (
    SEGMENTS,
    PhotoSegments,
    find_segments,
    write_segments,
)
from plan2scene.photos.labels.labeller import Labeller
from plan2scene.photos.labels.palette import (
    AMODAL,
    CEILING,
    FLOOR,
    KINDS_FILE,
    LIKENESS_FILE,
    OTHER,
    PROBABILITIES,
    SPOTS_FILE,
    TURNS_FILE,
    read_label_png,
    without_openings,
    write_label_png,
    write_probability_png,
)
from plan2scene.photos.labels.watermark import reduced, watermarks
from plan2scene.photos.matches import (
    Points,
    colours_of,
    find_points,
    likeness,
    matched_rays,
    same_spot,
    same_things,
)
from plan2scene.photos.photo_files import read_photo

_log = logging.getLogger("plan2scene")
#: A photo that looks taken from outside still shows a room above this share of floor and ceiling.
_OF_A_ROOM = 0.1


def make_masks(
    photos: Mapping[str, Path],
    label: Callable[[], Labeller],
    out_dir: str | Path,
    *,
    house_id: str,
    fov_deg: float = DEFAULT_FOV_DEG,
    known_fov_deg: float | None = None,
    find_rooms: str | None = "embedded",
    threads: int = 1,
) -> list[str]:
    """Write the masks folder of a house and return its warnings.

    A photo that is missing, damaged or tiny, has an unsafe name, or lacks its precomputed mask
    becomes a warning and is left out. A focal length in EXIF data that is not used becomes a
    warning, too. `label` makes the labeller; it is not called for a house without photos.
    `out_dir` is replaced as a whole: ``{stem}.png`` labels at the size that `read_photo` gives,
    ``probabilities/{stem}.png`` and ``amodal/{stem}.png`` where the source of labels gives them,
    ``cameras.json``, ``segments.parquet``, ``kinds.json``, ``turns.json``, ``spots.json``,
    ``likeness.json``, ``warnings.json`` (``docs/conventions.md``).

    `fov_deg` is the horizontal field of view in degrees that a photo gets when neither its EXIF
    data, nor its vanishing points, nor the other photos give one. `known_fov_deg` is the field of
    view of all photos along their longer side; it replaces all of these. `find_rooms` names the
    method that finds the use of rooms (``photos.kinds``); with None, ``kinds.json`` and
    ``likeness.json`` are empty. The result does not depend on the number of `threads`.
    """
    _refuse_equal_stems(photos, house_id)
    with atomic_directory(out_dir) as folder:
        shots: dict[str, _Shot] = {}
        warnings: list[str] = []
        if photos:
            one = partial(
                _label_photo,
                labeller=label(),
                folder=folder,
                house_id=house_id,
                fov_deg=fov_deg,
                known_fov_deg=known_fov_deg,
                find_rooms=find_rooms is not None,
            )
            with ThreadPoolExecutor(threads) as pool:
                labelled = pool.map(lambda name: one(name, photos[name]), sorted(photos))
                for name, (shot, lines) in zip(sorted(photos), labelled, strict=True):
                    warnings += lines
                    if shot is not None:
                        shots[name] = shot
        _log.info("%d photos labelled, %d left out", len(shots), len(photos) - len(shots))
        _leave_out_marks(shots, folder)
        cameras = _cameras(shots, folder, fov_deg)
        write_json(folder / "cameras.json", {name: c.to_json() for name, c in cameras.items()})
        kinds = {name: shot.kinds for name, shot in shots.items() if shot.kinds}
        write_json(folder / KINDS_FILE, {"source": find_rooms or "", "photos": kinds})
        points = {name: shot.points for name, shot in shots.items()}
        matches = list(matched_rays(points, cameras))
        for file, turned in ((TURNS_FILE, same_things(matches)), (SPOTS_FILE, same_spot(matches))):
            write_json(folder / file, [[*pair, quarters] for pair, quarters in turned.items()])
        alike = likeness({name: shot.looks for name, shot in shots.items() if shot.looks})
        write_json(folder / LIKENESS_FILE, [[*pair, round(v, 4)] for pair, v in alike.items()])
        write_segments(folder / SEGMENTS, {name: shot.segments for name, shot in shots.items()})
        write_json(folder / "warnings.json", warnings)
    return warnings


@dataclass(frozen=True)
class _Shot:
    """What the stage finds out about one labelled photo."""

    camera: Camera
    segments: PhotoSegments
    exif: ExifFocal
    kinds: list[float]  #: probability of each of `palette.KINDS`; empty without a classifier
    points: Points  #: to find photos from the same spot and photos that see the same things
    grey: np.ndarray  #: reduced grey copy, from `watermark.reduced`
    looks: list[np.ndarray]  #: vectors for :func:`likeness`; empty when rooms are not searched


def _leave_out_marks(shots: Mapping[str, _Shot], folder: Path) -> None:
    """Label watermarks that are printed over the photos as other."""
    marks = watermarks({name: shot.grey for name, shot in shots.items()})
    for name, mark in marks.items():
        path = folder / f"{Path(name).stem}.png"
        labels = read_label_png(path, openings=True)
        size = labels.shape[::-1]
        labels[cv2.resize(mark.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0] = OTHER
        write_label_png(path, labels)
    if marks:
        _log.info("%d photos with a watermark, which is left out", len(marks))


def _cameras(shots: Mapping[str, _Shot], folder: Path, fov_deg: float) -> dict[str, Camera]:
    """Return the photos' cameras; a photo with an unsure focal length takes the others' lens."""

    def refit(name: str, told: ExifFocal) -> Camera:
        shot = shots[name]
        if shot.exif.focal_px is not None:
            return shot.camera
        size = (shot.camera.height, shot.camera.width, 3)
        labels = read_label_png(folder / f"{Path(name).stem}.png")
        nothing = np.broadcast_to(np.uint8(0), size)  # no pixels needed: the segments are known
        return estimate_camera(nothing, labels, fov_deg=fov_deg, exif=told, segments=shot.segments)

    cameras = {name: shot.camera for name, shot in shots.items()}
    models = {name: shot.exif.model for name, shot in shots.items()}
    return with_shared_lenses(cameras, models, refit)


def _label_photo(
    name: str,
    path: Path,
    *,
    labeller: Labeller,
    folder: Path,
    house_id: str,
    fov_deg: float,
    known_fov_deg: float | None,
    find_rooms: bool,
) -> tuple[_Shot | None, list[str]]:
    """Write a photo's label PNG; return its `_Shot` (None if it is left out) and warnings."""
    try:
        safe_join("", name, house_id=house_id)
        image = read_photo(path, house_id=house_id)
        exif = read_exif_focal(path, (image.shape[0], image.shape[1]))
        if known_fov_deg is not None:
            focal = focal_of(np.radians(known_fov_deg), max(image.shape[:2]))
            exif = ExifFocal(focal, model=exif.model, told=True)
        segments = find_segments(image)
        labelled = labeller.labelled(name, image, fov_deg=fov_deg, exif=exif, segments=segments)
    except InputError as error:
        _log.warning("photo %s left out: %s", name, error)
        return None, [f"photo {name} left out: {error}"]
    plain = without_openings(labelled.labels)
    camera = estimate_camera(image, plain, fov_deg=fov_deg, exif=exif, segments=segments)
    write_label_png(folder / f"{Path(name).stem}.png", labelled.labels)
    for of, likely in ((PROBABILITIES, labelled.probabilities), (AMODAL, labelled.amodal)):
        if likely is not None:
            write_probability_png(folder / of / f"{Path(name).stem}.png", likely)
    lines = [f"photo {name}: {line}" for line in _focal_warnings(camera, exif)]
    kinds = labeller.kinds(image) if find_rooms and labeller.kinds else np.zeros(0)
    bare = np.isin(plain, (FLOOR, CEILING)).mean() <= _OF_A_ROOM  # else it may be a conservatory
    if kinds.size and bare and labeller.outside and labeller.outside(image):
        kinds = np.zeros_like(kinds)
    kind_probabilities = [round(p, 4) for p in kinds.tolist()]
    looks = [colours_of(image)] if find_rooms else []
    looks += [labeller.look(image)] if find_rooms and labeller.look else []
    return _Shot(
        camera, segments, exif, kind_probabilities, find_points(image), reduced(image), looks
    ), lines


def _focal_warnings(camera: Camera, exif: ExifFocal) -> list[str]:
    """Return why the focal length of EXIF data was not used; empty if it was used or is absent."""
    if exif.warning:
        return [exif.warning]
    if exif.focal_px is None or camera.focal_source == "exif":
        return []
    reason = "the photo is cropped" if exif.cropped else "vanishing points contradict it"
    return [
        f"EXIF focal length of {exif.focal_px:.0f} px not used, {reason} "
        f"({camera.focal_px:.0f} px, confidence {camera.confidence:.2f})"
    ]


def _refuse_equal_stems(photos: Mapping[str, Path], house_id: str) -> None:
    """Raise InputError when two photos of a house would share a mask file."""
    seen: dict[str, str] = {}
    for name in sorted(photos):
        other = seen.setdefault(Path(name).stem, name)
        if other != name:
            raise InputError(
                "photos of a house with different names before the extension",
                f"{other} and {name}",
                house=house_id,
            )
