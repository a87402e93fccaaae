"""The photo crop that represents each surface: the baselines make their tiles of it.

Method Crop (paper section 6.1) puts it on the surface as it is. Two from related work change it:

``medoid_colour``  one flat colour, the crop's median (IM2CAD, Izadinia et al. 2017, section 4.4)
``projection``     the photo region itself, stretched over the surface, so that it does not repeat
                   (Rent3D, Liu et al. 2015). A crop is at most a metre wide: the largest one of
                   the surface is taken, and the sharpest of equally large ones

An observed surface gets its reference crop, the medoid of its visible crops. For an unobserved
one a random crop is drawn from the first of these pools that is not empty:

1. same surface type in rooms of the house that share a room type with its room,
2. the same in other houses (the paper's training set), where there is a pool of them
   (:func:`write_pool`, config key ``textures.crop_pool``),
3. same surface type in the house,
4. same surface type in other houses,
5. any surface of the house.

If all are empty, the stage takes a tile of the library.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene.colour import as_uint8, median_colour
from plan2scene.errors import InputError
from plan2scene.house import House, SurfaceKey
from plan2scene.images import image_from_bytes, medoid_index
from plan2scene.io import read_parquet, write_parquet
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.seeds import generator

#: Substance of a surface of which nothing is known, by kind; floors of `_TILED_ROOMS` are tiled.
_USUAL_SUBSTANCE = {"floor": "wood", "wall": "plaster", "ceiling": "plaster"}
_TILED_ROOMS = frozenset({"Bathroom", "Balcony", "Terrace", "Outdoor"})


@dataclass(frozen=True)
class Crop:
    """A visible crop of a surface: PNG bytes of 128x128 sRGB, and the metres that its side covers.

    `size_m` and `sharpness` (photo pixels per crop pixel) are NaN where unknown. `detail` is a
    JPEG at the photo's own resolution, empty where the crop has the same detail. `window` is
    x0 y0 x1 y1 on the photo's plane, metres.
    """

    crop_id: str
    key: SurfaceKey
    png: bytes
    size_m: float
    sharpness: float = math.nan
    detail: bytes = b""
    window: tuple[float, ...] = (math.nan,) * 4

    @classmethod
    def of(cls, row: Any) -> Crop:
        """Return the crop of a row of ``crops.parquet`` (a named tuple)."""
        key = SurfaceKey(row.room_id, row.surface)
        detail, window = getattr(row, "detail", b""), getattr(row, "window", (math.nan,) * 4)
        sizes = float(row.metres), float(row.sharpness)
        # Crops that were made elsewhere have no window: NaN, which Parquet holds as null.
        window = tuple(math.nan if side is None else float(side) for side in window)
        return cls(row.crop_id, key, row.png, *sizes, detail, window)

    def image(self) -> np.ndarray:
        """Return the pixels, (128, 128, 3) uint8 sRGB, which are not to be changed."""
        return _pixels(self.png)


@lru_cache(maxsize=1024)
def _pixels(png: bytes) -> np.ndarray:
    """Return the pixels of a crop, cached: several methods read them at several drops."""
    return image_from_bytes(png)


@dataclass(frozen=True)
class PoolCrop:
    """The reference crop of a surface of another house, and the types of its room."""

    house: str
    types: tuple[str, ...]
    crop: Crop


@dataclass(frozen=True)
class Choice:
    """The crop chosen for a surface, and where it comes from, in words."""

    crop: Crop
    source: str


def medoid_crop(crops: Sequence[Crop]) -> Crop:
    """Return the crop nearest to the mean of a surface's crops (paper, reference crop)."""
    return crops[medoid_index([crop.image() for crop in crops])]


def largest_crop(crops: Sequence[Crop]) -> Crop:
    """Return the crop that covers most; among equals the sharpest, then the first.

    Windows are cut to whole pixels, so sides are rounded to a centimetre. Unknown values count as
    0.
    """
    known = [
        (round(np.nan_to_num(crop.size_m), 2), float(np.nan_to_num(crop.sharpness)))
        for crop in crops
    ]
    return crops[known.index(max(known))]


def choose_crop(
    plan: House,
    key: SurfaceKey,
    crops: Sequence[Crop],
    seed: int,
    own_crop: Callable[[Sequence[Crop]], Crop] = medoid_crop,
    others: Sequence[PoolCrop] = (),
) -> Choice | None:
    """Return the crop that represents a surface; None if there is no crop at all.

    `plan` gives the room types. `crops` are all visible ones of the house, in a stable order,
    `others` those of other houses. `own_crop` chooses among the own crops of an observed surface.
    The random draw depends on the global seed, the house and the surface alone.
    """
    own_crops = [crop for crop in crops if crop.key == key]
    if own_crops:
        crop = own_crop(own_crops)
        return Choice(crop, crop.crop_id)
    types = set(plan.room(key.room_id).types)
    same_surface = [crop for crop in crops if crop.key.surface == key.surface]
    pool_crops = [other for other in others if other.crop.key.surface == key.surface]
    related = [c for c in same_surface if types & set(plan.room(c.key.room_id).types)]
    pools = (
        ("a room of its type", related),
        ("such a room of another house", [o.crop for o in pool_crops if types & set(o.types)]),
        (f"another {key.surface} of the house", same_surface),
        (f"a {key.surface} of another house", [other.crop for other in pool_crops]),
        ("another surface of the house", list(crops)),
    )
    for name, pool in pools:
        if pool:
            rng = generator(seed, plan.id, key.room_id, key.surface, "crop")
            crop = pool[int(rng.integers(len(pool)))]
            return Choice(crop, f"{name}: {crop.crop_id} of {crop.key.room_id}")
    return None


def flat_image(image: np.ndarray) -> np.ndarray:
    """Return an (h, w, 3) uint8 sRGB image of one colour: the median of another's."""
    return np.broadcast_to(as_uint8(median_colour(image)), image.shape).copy()


def surface_extent(plan: House, key: SurfaceKey) -> tuple[float, tuple[float, float]]:
    """Return the side of the square that holds a surface, and the square's corner, metres.

    Both are in the texture coordinates of the mesh: (x, z) for floors and ceilings. A room's walls
    are one strip along its outline (or that of a column in it), from the ceiling down.
    """
    room = plan.room(key.room_id)
    if key.surface == "wall":
        return max(room.height, *(_length(np.array(ring)) for ring in room.rings)), (0.0, 0.0)
    points = np.array(room.rings[0])
    low, high = points.min(axis=0), points.max(axis=0)
    return float((high - low).max()), (float(low[0]), float(low[1]))


def _length(ring: np.ndarray) -> float:
    """Return the length of a closed (n, 2) ring."""
    return float(np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1).sum())


def usual_substance(plan: House, key: SurfaceKey) -> str:
    """Return the substance that a surface has in most homes."""
    if key.surface == "floor" and _TILED_ROOMS & set(plan.room(key.room_id).types):
        return "tile"
    return _USUAL_SUBSTANCE[key.surface]


def write_pool(
    scenes: Sequence[str | Path],
    crops: Sequence[str | Path],
    houses: Sequence[str],
    output: str | Path,
    *,
    dataset: str,
) -> None:
    """Write ``crop_pool.parquet``: the medoid crop of every surface that these houses show.

    There is one crop per surface, so that rooms of many photos do not outweigh the others (and the
    file of 129 houses stays near 50 MB). Columns ``house, room_id, types (joined by |), surface,
    crop_id, metres, sharpness, png``.
    """
    import pandas as pd

    frames = []
    for scene, path, house in zip(scenes, crops, houses, strict=True):
        plan = read_scene_json(scene, house)
        table, _ = read_parquet(path)
        table = table[table["medoid"].astype(bool)]
        types = ["|".join(plan.room(room).types) for room in table["room_id"]]
        frames.append(table.assign(house=house, types=types))
    columns = ["house", "room_id", "types", "surface", "crop_id", "metres", "sharpness", "png"]
    frame = pd.concat(frames, ignore_index=True) if frames else pd.DataFrame(columns=columns)
    write_parquet(output, frame[columns], {"dataset": dataset})


def read_pool(path: str | Path, *, but: str) -> list[PoolCrop]:
    """Return the crops of a pool, except those of the house `but`."""
    frame, _ = read_parquet(path)
    missing = {"house", "types", "crop_id", "png"} - set(frame.columns)
    if missing:
        raise InputError("a crop pool", f"no {', '.join(sorted(missing))}", file=path)
    return [
        PoolCrop(row.house, tuple(row.types.split("|")), Crop.of(row))
        for row in frame.itertuples()
        if row.house != but
    ]
