"""Writes synthetic data sets: house after house with photos and truth, then the index of all.

Layout and schemas: ``docs/conventions.md`` (Rent3D++ layout plus ``truth/``).
"""

from __future__ import annotations

import logging
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from plan2scene.datasets.assignments import read_rows
from plan2scene.house import House, SurfaceKey
from plan2scene.images import write_png
from plan2scene.io import atomic_directory, atomic_path, write_json
from plan2scene.materials import Material
from plan2scene.photos.labels.palette import write_label_png
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene.seeds import derive_seed, generator
from plan2scene_app.workflow.house_table import COLUMNS, SPLITS, table_of_lists
from plan2scene_workshop.homes.floorplans import generate_house
from plan2scene_workshop.homes.style import accent_walls, assign_materials
from plan2scene_workshop.rendering import RenderedPhoto, encode_jpeg, plan_views, render_house
from plan2scene_workshop.rendering.decor import listing_decor
from plan2scene_workshop.rendering.randomised import (
    draw_random_rooms,
    randomise_materials,
    randomise_view,
)
from plan2scene_workshop.rendering.sources import Sources

_LOGGER = logging.getLogger("plan2scene")

#: Shares of hidden photos for which unobserved_photos.json has a list.
DROP_FRACTIONS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
#: Relative probability that a room type is photographed (listings mostly show living rooms).
PHOTO_WEIGHT = {
    "Reception": 60.0,
    "Kitchen": 5.0,
    "Bedroom": 5.0,
    "Bathroom": 4.0,
    "Corridor": 1.0,
    "Entrance": 0.6,
    "Staircase": 0.6,
    "Unknown": 1.0,
    "Balcony": 0.3,
    "Terrace": 0.4,
    "Outdoor": 0.2,
    "Closet": 0.1,
}
#: Smallest inner width in metres of a room with photos: a person with a camera must fit in.
LEAST_PHOTO_WIDTH = 1.0


@dataclass(frozen=True)
class ResidenceOptions:
    """How a synthetic house is photographed and stored."""

    photos: tuple[int, int] = (4, 8)  #: range of photos per house
    hidden_room_share: float = 0.4  #: share of rooms without any photo
    height: int = 480  #: of a photo, pixels
    width: int = 640  #: of a photo, pixels
    samples_per_pixel: int = 16  #: light paths per pixel
    jpeg_quality: tuple[int, int] = (78, 92)  #: range; a value is drawn for each photo
    tile_px: int = 256  #: side of the albedo tiles in truth/, pixels
    random_room_share: float = 0.0  #: share of rooms with random looks (`rendering.randomised`)
    variant: str | None = None  #: Mitsuba variant; None: the first that works


def residence_names(prefix: str, counts: Mapping[str, int]) -> dict[str, str]:
    """Return the houses of a data set, name to split: ``{"home_train_000": "train", ...}``."""
    return {f"{prefix}_{split}_{k:03d}": split for split in SPLITS for k in range(counts[split])}


def write_residence(
    root: str | Path,
    house_id: str,
    split: str,
    seed: int,
    *,
    options: ResidenceOptions | None = None,
    sources: Sources | None = None,
) -> House:
    """Write one synthetic house: plan, photo table, photos, truth; return the house.

    Only files of this house are written, so that several houses can be made at the same time. The
    same seed, options, sources and Mitsuba variant give the same bytes.

    `root` is the data set's folder and `seed` its seed; each house derives its own seed from it.
    The style model also uses the real textures of `sources`, and their models furnish the rooms.
    InputError if Mitsuba or its variant does not work.
    """
    options, sources = options or ResidenceOptions(), sources or Sources()
    root = Path(root)
    house = generate_house(house_id, derive_seed(seed, "house"))
    materials = assign_materials(house, derive_seed(seed, "style"), sources.textures)
    random_rooms = draw_random_rooms(house, options.random_room_share, seed)
    materials = randomise_materials(materials, random_rooms, derive_seed(seed, "random", house_id))
    rng = generator(seed, "photos", house_id)
    photos = _photographed(house, materials, random_rooms, options, sources, seed, rng)
    assignment: list[tuple[str, str]] = []
    cameras: dict[str, Any] = {}
    clear_photos(root, house_id)
    with atomic_directory(root / "truth" / split / house_id) as truth:
        for k, photo in enumerate(photos):
            name = f"{house_id}_{k:02d}.jpg"
            quality = int(rng.integers(options.jpeg_quality[0], options.jpeg_quality[1] + 1))
            write_photo(root, truth, name, photo.image, photo.labels, quality)
            write_png(truth / "planes" / f"{Path(name).stem}.png", photo.planes)
            cameras[name] = photo.camera
            assignment.append((photo.view.room_id, name))
            _LOGGER.info("%s: photo %d, %s", house_id, k + 1, photo.view.room_id)
        write_json(truth / "cameras.json", cameras)
        _write_materials(truth, materials, options.tile_px)
    write_scene_json(house, root / "archs_no_objects" / split / f"{house_id}.scene.json")
    write_assignment(root / "photo_assignments" / split / f"{house_id}.photoroom.csv", assignment)
    return house


def _photographed(
    house: House,
    materials: Mapping[SurfaceKey, Material],
    random_rooms: Collection[str],
    options: ResidenceOptions,
    sources: Sources,
    seed: int,
    rng: np.random.Generator,
) -> Iterator[RenderedPhoto]:
    """Yield the photos of a house; `seed` is that of the data set."""
    accents = accent_walls(house, derive_seed(seed, "accents"))
    rooms = photographed_rooms(house, options.hidden_room_share, rng)
    low, high = options.photos
    count = max(int(rng.integers(low, high + 1)), min(len(rooms), high))
    views = [
        randomise_view(view, generator(view.seed, "snapshot"))
        if view.room_id in random_rooms
        else view
        for view in plan_views(house, rooms, count, derive_seed(seed, "views"))
    ]
    furnished = listing_decor(sources, derive_seed(seed, "decor", house.id))
    yield from render_house(
        house,
        materials,
        accents,
        views,
        derive_seed(seed, "render"),
        height=options.height,
        width=options.width,
        samples_per_pixel=options.samples_per_pixel,
        variant=options.variant,
        random_rooms=random_rooms,
        decor=furnished if sources.models else None,
    )


def clear_photos(root: Path, house_id: str) -> None:
    """Remove a house's photos, because an earlier run may have written more of them."""
    for old in (root / "photos").glob(f"{house_id}_[0-9][0-9].jpg"):
        old.unlink()


def write_assignment(path: Path, rows: Sequence[tuple[str, str]]) -> None:
    """Write a photo table with rows (room id, photo)."""
    with atomic_path(path) as temporary:
        lines = ["room_id,photo", *(",".join(row) for row in rows)]
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")


def photographed_rooms(
    house: House, hidden_share: float, rng: np.random.Generator
) -> tuple[str, ...]:
    """Return the ids of the rooms that get photos: all but about `hidden_share` of the rooms."""
    names, weights = [], []
    for room in house.rooms:
        inner = room_polygon(room).buffer(-LEAST_PHOTO_WIDTH / 2)
        if not inner.is_empty:
            names.append(room.id)
            weights.append(PHOTO_WEIGHT[room.types[0]])
    shown = max(1, len(house.rooms) - round(hidden_share * len(house.rooms)))
    shares = np.array(weights) / np.sum(weights)
    chosen = rng.choice(len(names), min(shown, len(names)), replace=False, p=shares)
    return tuple(names[i] for i in sorted(chosen))


def write_photo(
    root: Path, truth: Path, name: str, image: np.ndarray, labels: np.ndarray, quality: int
) -> None:
    """Write a photo and its mask."""
    with atomic_path(root / "photos" / name) as temporary:
        temporary.write_bytes(encode_jpeg(image, quality))
    write_label_png(truth / "masks" / f"{Path(name).stem}.png", labels)


def _write_materials(truth: Path, materials: Mapping[SurfaceKey, Material], tile_px: int) -> None:
    """Write materials.json and the albedo tile of every surface."""
    index = {}
    for key, material in materials.items():
        index[f"{key.room_id}/{key.surface}"] = {
            "substance": material.substance,
            "kind": material.kind,
            "size_m": round(material.size_m, 4),
        }
        albedo = material.albedo
        if albedo.shape[0] != tile_px:
            mode = cv2.INTER_AREA if albedo.shape[0] > tile_px else cv2.INTER_LINEAR
            albedo = cv2.resize(albedo, (tile_px, tile_px), interpolation=mode)
        write_png(truth / "materials" / f"{key.filename}.png", albedo)
    write_json(truth / "materials.json", index)


def write_dataset_index(root: str | Path, houses: Mapping[str, str], seed: int) -> list[str]:
    """Write data_lists/, unobserved_photos.json and houses.tsv; return warnings.

    Parameters
    ----------
    houses : mapping
        House name to split, as from :func:`residence_names`; their files must exist.
    seed : int
        Decides which photos are hidden. Each share holds for each house, and a larger share hides
        all photos that a smaller one hides.
    """
    root = Path(root)
    hidden: dict[str, list[str]] = {f"{fraction:.1f}": [] for fraction in DROP_FRACTIONS}
    for house, split in houses.items():
        table = root / "photo_assignments" / split / f"{house}.photoroom.csv"
        photos = sorted({row.photo for row in read_rows(table, house_id=house)})
        order = generator(seed, "unobserved", house).permutation(len(photos))
        for fraction in DROP_FRACTIONS:
            count = round(fraction * len(photos))
            hidden[f"{fraction:.1f}"] += sorted(photos[i] for i in order[:count])
    for split in SPLITS:
        names = [house for house, where in houses.items() if where == split]
        with atomic_path(root / "data_lists" / f"{split}.txt") as temporary:
            temporary.write_text("".join(f"{name}\n" for name in names), encoding="utf-8")
    write_json(root / "unobserved_photos.json", hidden)
    made = table_of_lists(root)
    rows = [COLUMNS, *((*row[:-1], "|".join(row.photos)) for row in made.houses.values())]
    with atomic_path(root / "houses.tsv") as temporary:
        temporary.write_bytes("".join("\t".join(row) + "\n" for row in rows).encode())
    return list(made.warnings)
