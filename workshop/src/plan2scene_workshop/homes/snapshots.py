"""Writes a synthetic house for training: many snapshots of each room, with labels and targets."""

from __future__ import annotations

import importlib
import logging
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from plan2scene.house import House, Opening, SurfaceKey
from plan2scene.images import write_png
from plan2scene.io import atomic_directory, atomic_path, write_json
from plan2scene.materials import Material
from plan2scene.photos.labels.palette import write_label_png
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene.seeds import derive_seed, generator
from plan2scene_workshop.homes.floorplans import generate_house
from plan2scene_workshop.homes.residences import clear_photos, write_assignment, write_photo
from plan2scene_workshop.homes.style import PLAIN, VARIED, accent_walls, assign_materials
from plan2scene_workshop.rendering.decor import Decor, draw_decor, listing_decor
from plan2scene_workshop.rendering.snapshots import Snapshot, shoot_room
from plan2scene_workshop.rendering.sources import Sources
from plan2scene_workshop.rendering.tracer import load_mitsuba

_LOGGER = logging.getLogger("plan2scene")
#: Probability that a room of a type is photographed; 1 for types not named.
_CHANCE = {"Corridor": 0.2, "Entrance": 0.2, "Closet": 0.05, "Balcony": 0.1, "Terrace": 0.2}
#: The same for homes like those of listings, and the factor on their numbers of built-in pieces.
_CHANCE_LISTED = {
    **{"Corridor": 0.4, "Entrance": 0.5, "Closet": 0.5, "Staircase": 0.3, "Bedroom": 0.7},
    **{"Balcony": 0.0, "Terrace": 0.0, "Outdoor": 0.0, "Unknown": 0.0, "Reception": 0.8},
}
_BUILT_IN_LISTED = 2.0
#: Factor on `emptied`: their product is the share of homes with the style `PLAIN`.
PLAIN_SHARE = 0.6


@dataclass(frozen=True)
class SnapshotOptions:
    """How a synthetic house is photographed for training."""

    views: int = 6  #: largest number of snapshots of a room
    long_side: int = 448  #: longer side of a photo, pixels
    randomised: float = 0.5  #: share of rooms with randomised looks
    emptied: float = 0.0  #: share of rooms that are nearly empty, as after moving out
    covered: float = 0.0  #: share of windows covered by blinds or curtains
    joinery: bool = False  #: whether there are fitted closets, various doors, and glass doors
    listed: bool = False  #: homes like those of listings, with furniture for each room's use
    amodal: bool = False  #: write the labels of what is behind the furniture, too
    targets: bool = True  #: write normals and depth beside the masks
    jpeg_quality: tuple[int, int] = (50, 95)  #: range; a value is drawn for each photo
    variant: str | None = None  #: Mitsuba variant (a vectorised one); None: the first that works


def write_snapshots(
    root: str | Path,
    house_id: str,
    split: str,
    seed: int,
    options: SnapshotOptions,
    *,
    sources: Sources,
) -> House:
    """Write one house: plan, photo table, snapshots, truth; return the house.

    Truth masks hold doors (4) and windows (5). The same arguments give the same bytes.
    InputError if Mitsuba or its variant does not work.
    """
    root = Path(root)
    mi = load_mitsuba(options.variant)
    importlib.import_module("drjit").set_thread_count(1)  # one job per house, one core per job
    house = generate_house(house_id, derive_seed(seed, "house"))
    if options.joinery:
        house = _with_glass_doors(house, generator(seed, "glass doors"))
    materials = _materials(house, seed, options, sources)
    accents = accent_walls(house, derive_seed(seed, "accents"))
    rng = generator(seed, "snapshots", house_id)
    assignment: list[tuple[str, str]] = []
    cameras: dict[str, Any] = {}
    clear_photos(root, house_id)
    with atomic_directory(root / "truth" / split / house_id) as truth:
        for room_id in _rooms(house, rng, _CHANCE_LISTED if options.listed else _CHANCE):
            decor = _decor(house_id, room_id, seed, options, sources, rng)
            shots = shoot_room(
                house,
                room_id,
                materials,
                accents,
                decor,
                options.views,
                decor.seed,
                long_side=options.long_side,
                mi=mi,
                listed=options.listed,
                amodal=options.amodal,
            )
            for shot in shots:
                name = f"{house_id}_{len(cameras):02d}.jpg"
                quality = int(rng.integers(options.jpeg_quality[0], options.jpeg_quality[1] + 1))
                write_photo(root, truth, name, shot.image, shot.labels, quality)
                if shot.amodal is not None:
                    write_label_png(truth / "amodal" / f"{Path(name).stem}.png", shot.amodal)
                if options.targets:
                    _write_targets(truth, f"{Path(name).stem}.png", shot)
                cameras[name] = shot.camera
                assignment.append((room_id, name))
        write_json(truth / "cameras.json", cameras)
    _LOGGER.info("%s: %d snapshots", house_id, len(cameras))
    write_scene_json(house, root / "archs_no_objects" / split / f"{house_id}.scene.json")
    write_assignment(root / "photo_assignments" / split / f"{house_id}.photoroom.csv", assignment)
    return house


def _materials(
    house: House, seed: int, options: SnapshotOptions, sources: Sources
) -> dict[SurfaceKey, Material]:
    """Return the materials of a house, of the style `PLAIN` in some houses (see `PLAIN_SHARE`)."""
    plain = generator(seed, "plain").random() < PLAIN_SHARE * options.emptied
    style = PLAIN if plain else VARIED
    return assign_materials(house, derive_seed(seed, "style"), sources.textures, style=style)


def _decor(
    house_id: str,
    room_id: str,
    seed: int,
    options: SnapshotOptions,
    sources: Sources,
    rng: np.random.Generator,
) -> Decor:
    """Draw the look of one room; the decor's seed also decides all else in the room."""
    room_seed = derive_seed(seed, "room", house_id, room_id)
    decor = draw_decor(
        sources,
        room_seed,
        randomised=bool(rng.random() < options.randomised),
        emptied=bool(generator(room_seed, "emptied").random() < options.emptied),
    )
    if options.listed:
        decor = _listed(decor, sources, room_seed)
    return replace(decor, covered=options.covered, joinery=options.joinery)


def _with_glass_doors(house: House, rng: np.random.Generator) -> House:
    """Return the house with some wide windows extended down to the floor."""

    def lower(opening: Opening) -> Opening:
        wide = opening.kind == "window" and opening.end - opening.start > 1.1
        return replace(opening, bottom=0.0) if wide and rng.random() < 0.35 else opening

    walls = (replace(wall, openings=tuple(map(lower, wall.openings))) for wall in house.walls)
    return replace(house, walls=tuple(walls))


def _listed(decor: Decor, sources: Sources, seed: int) -> Decor:
    """Return the decor of a room whose furniture shows its use; some rooms are tidied up."""
    if not (decor.randomised or decor.emptied) and generator(seed, "tidied").random() < 0.5:
        decor = listing_decor(sources, seed)
    style = replace(decor.style, kind=None, bulk="", built_in=_BUILT_IN_LISTED)
    return replace(decor, style=style)


def _rooms(house: House, rng: np.random.Generator, chance: Mapping[str, float]) -> list[str]:
    return [
        room.id
        for room in house.rooms
        if rng.random() < chance.get(room.types[0] if room.types else "", 1.0)
        and not room_polygon(room).buffer(-0.5).is_empty
    ]


def _write_targets(truth: Path, name: str, shot: Snapshot) -> None:
    """Write normals, and depth in millimetres as a 16-bit grey PNG."""
    write_png(truth / "normals" / name, shot.normals)
    done, data = cv2.imencode(".png", shot.depth)
    if not done:
        raise RuntimeError("no PNG of a depth image")
    with atomic_path(truth / "depth" / name) as temporary:
        temporary.write_bytes(data.tobytes())
