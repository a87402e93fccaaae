"""What colours each photo shows of a surface, from all of its pixels: colours.parquet.

Crops are the few windows that show a pattern well. The colour of a surface is known better from
all that is seen of it, also of what no good window fits on. Each plane of a photo gives the colours
of equal shares of its pixels, from the darkest to the brightest: steep views, which show less glare
and more of the surface, count more.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from plan2scene.camera import Camera
from plan2scene.colour import LUMINANCE, srgb_to_linear
from plan2scene.io import write_parquet
from plan2scene.photos.crops.candidates import ShownPlane
from plan2scene.photos.crops.filter import unclipped
from plan2scene.photos.planes.planes import Plane

#: Colours that tell what a plane's pixels look like, each of an equal share of them.
SHARES = 32
#: Planes of fewer pixels tell nothing.
MIN_PIXELS = 200
#: At most about so many pixels of a plane are looked at.
MOST_PIXELS = 20000
_COLUMNS = ["photo", "room_id", "surface", "plane", "own", "walls", "weight", "colours"]


@dataclass(frozen=True, eq=False)
class SeenColours:
    """What a photo shows of a surface.

    Attributes
    ----------
    photo : str
    rooms : tuple of str
        Whose it may be.
    surface : str
    plane : int
        Number of the plane within photo and surface.
    own : bool
        Whether it is seen from within the room.
    walls : tuple of str
        Ids of the walls on the plane; none where they are not known.
    weight : float
        Share of the photo's pixels, times the mean squared sine of the angle of view, shared
        among the rooms.
    colours : (SHARES, 3) float32
        Linear RGB of equal shares of it, from the darkest to the brightest.
    """

    photo: str
    rooms: tuple[str, ...]
    surface: str
    plane: int
    own: bool
    walls: tuple[str, ...]
    weight: float
    colours: np.ndarray


def colours_of_photo(
    image: np.ndarray,
    camera: Camera,
    planes: Sequence[ShownPlane],
    photo: str,
    inner: Sequence[np.ndarray],
) -> list[SeenColours]:
    """Return what a photo, image (h, w, 3) uint8 sRGB, shows of each of its planes.

    `inner` are the pixels (h, w) bool of each plane that lie off its border.
    """
    count = len({room for shown in planes if shown.own for room in shown.rooms})
    found = []
    for shown, pixels in zip(planes, inner, strict=True):
        plane, seen = shown.plane, plane_colours(image, camera, shown.plane, pixels)
        if seen is not None:
            # Where the place is not known any of the table's rooms may be meant.
            weight = seen[0] / (count if shown.own else 1)
            facts = photo, shown.rooms, plane.surface, plane.index, shown.own, shown.walls
            found.append(SeenColours(*facts, weight, seen[1]))
    return found


def plane_colours(
    image: np.ndarray, camera: Camera, plane: Plane, inner: np.ndarray
) -> tuple[float, np.ndarray] | None:
    """Return weight and colours of a plane as of :class:`SeenColours`; None of too few pixels.

    `image` (h, w, 3) uint8 sRGB; of the pixels `inner` (h, w) bool clipped ones are left aside.
    """
    rows, columns = np.nonzero(inner & unclipped(image))
    if len(rows) < MIN_PIXELS:
        return None
    share = len(rows) / plane.mask.size
    few = slice(None, None, max(1, len(rows) // MOST_PIXELS))
    rows, columns = rows[few], columns[few]
    rays = camera.rays(np.stack([columns, rows], axis=-1))
    steep = (rays @ np.asarray(plane.normal)) ** 2 / (rays**2).sum(axis=1)
    return share * float(steep.mean()), equal_shares(srgb_to_linear(image[rows, columns]), steep)


def equal_shares(linear: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the mean colours (SHARES, 3) float32 of equal shares of (n, 3), by luminance.

    `weights` (n,) are above 0 for some.
    """
    order = np.argsort(linear @ LUMINANCE, kind="stable")
    ends = np.cumsum(weights[order])
    share = np.minimum((ends - weights[order] / 2) / ends[-1] * SHARES, SHARES - 0.5).astype(int)
    heavy = np.maximum(weights[order], 1e-12)
    total = np.bincount(share, heavy, SHARES)
    sums = [np.bincount(share, heavy * linear[order, c], SHARES) for c in range(3)]
    colours = np.stack(sums, axis=1) / np.maximum(total, 1e-300)[:, None]
    # A heavy pixel fills whole shares, but lies in one.
    middle = (np.arange(SHARES) + 0.5) / SHARES * ends[-1]
    there = np.minimum(np.searchsorted(ends, middle), len(order) - 1)
    colours = np.where((total > 0)[:, None], colours, linear[order[there]])
    return colours.astype(np.float32)


def relit(seen: Sequence[SeenColours], gains: Mapping[str, np.ndarray]) -> list[SeenColours]:
    """Return what is seen with its linear RGB times its photo's gains (3,)."""
    return [
        replace(item, colours=np.minimum(item.colours * gains[item.photo], 1.0).astype(np.float32))
        if item.photo in gains
        else item
        for item in seen
    ]


def write_colours(
    path: str | Path,
    seen: Sequence[SeenColours],
    *,
    dataset: str,
    house_id: str,
    colours: str = "photo",
) -> None:
    """Write ``colours.parquet`` (docs/conventions.md): a row for each plane and room.

    `colours` is one of :data:`plan2scene.photos.crops.light.COLOURS`.
    """
    import pandas as pd

    rows = [
        {
            "photo": item.photo,
            "room_id": room,
            "surface": item.surface,
            "plane": item.plane,
            "own": item.own,
            "walls": "|".join(item.walls),
            "weight": item.weight,
            "colours": item.colours.ravel(),
        }
        for item in seen
        for room in item.rooms
    ]
    metadata = {"dataset": dataset, "house": house_id, "colours": colours}
    write_parquet(path, pd.DataFrame(rows, columns=_COLUMNS), metadata)
