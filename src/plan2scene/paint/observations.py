"""Observations: the colours that photos show of the surfaces of a house (``colours.parquet``).

Crops are the few windows that show a pattern well. All visible pixels of a surface tell its colour
better, also where no crop fits. The pixels of a plane in a photo are sorted from dark to bright and
divided into equal shares; each share gives its mean colour. Colours are linear RGB.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.colour import LUMINANCE, srgb_to_linear
from plan2scene.house import SURFACES, SurfaceKey
from plan2scene.io import read_parquet, write_parquet

if TYPE_CHECKING:
    import pandas as pd

#: Number of equal shares of a plane's pixels whose mean colours are kept.
SHARES = 32
#: An observation of this weight or more counts as one whole photo.
WHOLE = 0.02
#: A photo taken in another room is ignored for a floor of which it shows less (share of pixels).
#: Chosen on the demo, where such photos make two floors wrong by 15 and 20 CIEDE2000.
GLIMPSE = 2e-3
#: The share of pixels with the most similar luminance gives the colour: others are shadow, glare.
ALIKE = 0.5
#: The darkest share of a surface's pixels, which does not count for its hue. Chosen on a real
#: listing; reported on three others, two real flats and the demo (development).
DARKEST = 0.1
_COLUMNS = ["photo", "room_id", "surface", "plane", "own", "walls", "weight", "colours"]


@dataclass(frozen=True)
class SurfaceColour:
    """The median colour (3,) of a kind of surface in a photo, of a room that the photo shows."""

    photo: str
    room_id: str
    surface: str
    colour: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class PlaneColours:
    """What a photo shows of a plane."""

    photo: str
    rooms: tuple[str, ...]  #: ids of the rooms that it may belong to
    #: of ``house.SURFACES``; ``door`` for a door leaf, ``frame`` for frames of windows
    surface: str
    plane: int  #: number of the plane within photo and surface
    own: bool  #: whether it is seen from within the room
    #: ids of the walls on the plane; none where they are not known. For a door: its opening's id
    walls: tuple[str, ...]
    #: share of the photo's pixels, times the mean squared sine of the angle of view, shared among
    #: the rooms
    weight: float
    #: (SHARES, 3) float32: Linear RGB of equal shares of it, from the darkest to the brightest
    colours: np.ndarray


@dataclass(frozen=True, eq=False)
class HouseColours:
    """What photos show of the surfaces of n rooms."""

    #: (n, 3, 3) float64: Linear RGB of the surfaces in the order of ``house.SURFACES``; undefined
    #: where none is seen
    colours: np.ndarray
    photos: np.ndarray  #: (n, 3) float64: Number of photos that each colour is worth; 0: not seen

    @classmethod
    def of_embeddings(cls, embeddings: np.ndarray, observed: np.ndarray) -> HouseColours:
        """Return the colours of embeddings (n, 3, 11); each `observed` one (n, 3) is one photo."""
        colours = srgb_to_linear(np.clip(embeddings[..., -3:].astype(np.float64), 0.0, 1.0))
        return cls(colours, observed.astype(np.float64))

    def without(self, place: tuple[int, int]) -> HouseColours:
        """Return the same without one surface."""
        photos = self.photos.copy()
        photos[place] = 0.0
        return replace(self, photos=photos)


def equal_shares(linear: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Sort colours (n, 3) by luminance; return the means (SHARES, 3) float32 of equal shares.

    At least one of the `weights` (n,) is above 0.
    """
    order = np.argsort(linear @ LUMINANCE, kind="stable")
    ends = np.cumsum(weights[order])
    share = np.minimum((ends - weights[order] / 2) / ends[-1] * SHARES, SHARES - 0.5).astype(int)
    heavy = np.maximum(weights[order], 1e-12)
    total = np.bincount(share, heavy, SHARES)
    sums = [np.bincount(share, heavy * linear[order, c], SHARES) for c in range(3)]
    colours = np.stack(sums, axis=1) / np.maximum(total, 1e-300)[:, None]
    # A heavy pixel spans several shares but is counted in one: give its colour to the others.
    middle = (np.arange(SHARES) + 0.5) / SHARES * ends[-1]
    middle_places = np.minimum(np.searchsorted(ends, middle), len(order) - 1)
    colours = np.where((total > 0)[:, None], colours, linear[order[middle_places]])
    return colours.astype(np.float32)


def usual_colour(shares: Sequence[np.ndarray], weights: Sequence[float]) -> np.ndarray:
    """Return the mean (3,) of the `ALIKE` share of colours whose luminance is most alike.

    The shortest half (Rousseeuw 1984, DOI 10.1080/01621459.1984.10477105) of log luminance: shadows
    on one side, glare and lamps on the other do not move it. `shares` are, of each observation, the
    linear RGB (m, 3) of equal shares of its pixels.
    """
    colours, weight = _weighed(shares, weights)
    log = np.log(colours @ LUMINANCE + 0.01)
    order = np.argsort(log, kind="stable")
    log, colours, weight = log[order], colours[order], weight[order]
    ends = np.cumsum(weight) / weight.sum()
    starts = ends - weight / weight.sum()
    last = np.searchsorted(ends, starts + ALIKE - 1e-9)
    fits = np.flatnonzero(last < len(log))
    first = fits[(log[last[fits]] - log[fits]).argmin()]
    shortest_part = slice(first, last[first] + 1)
    return np.average(colours[shortest_part], axis=0, weights=weight[shortest_part])


def matte_colour(shares: Sequence[np.ndarray], weights: Sequence[float]) -> np.ndarray:
    """Return :func:`usual_colour` (3,) with the hue of the darker half of the pixels.

    Glare adds the hue of the light to bright pixels (dichromatic reflection: Shafer 1985, DOI
    10.1002/col.5080100409). The `DARKEST` share is left out: it lies in the shadow of furniture and
    takes its colour.
    """
    usual = usual_colour(shares, weights)
    colours, weight = _weighed(shares, weights)
    order = np.argsort(colours @ LUMINANCE, kind="stable")
    ends = np.cumsum(weight[order]) / weight.sum()
    dark = order[(ends > DARKEST) & (ends <= 0.5)]
    hue = np.average(colours[dark], axis=0, weights=weight[dark])
    return np.asarray(hue * (usual @ LUMINANCE) / max(hue @ LUMINANCE, 1e-12))


def _weighed(
    shares: Sequence[np.ndarray], weights: Sequence[float]
) -> tuple[np.ndarray, np.ndarray]:
    """Return all colours (n, 3), and their weights (n,): those of one observation share its own."""
    each = [np.full(len(s), w / len(s)) for s, w in zip(shares, weights, strict=True)]
    return np.concatenate(shares), np.concatenate(each)


def write_colours(
    path: str | Path,
    planes: Sequence[PlaneColours],
    *,
    dataset: str,
    house_id: str,
) -> None:
    """Write ``colours.parquet`` (docs/conventions.md): a row for each plane and room."""
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
        for item in planes
        for room in item.rooms
    ]
    metadata = {"dataset": dataset, "house": house_id}
    write_parquet(path, pd.DataFrame(rows, columns=_COLUMNS), metadata)


def without_glimpses(table: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of ``colours.parquet`` without glimpses (`GLIMPSE`) of other rooms' floors.

    Such a floor lies in another light and is seen at a flat angle. The floor of the next room tells
    more about its colour.
    """
    surface_weight = table.groupby(["photo", "room_id", "surface"])["weight"].transform("sum")
    return table[(table["surface"] != "floor") | table["own"] | (surface_weight >= GLIMPSE)]


def read_colours(
    path: str | Path, hidden_photos: Collection[str] = ()
) -> dict[SurfaceKey, list[tuple[str, float, np.ndarray]]]:
    """Return (photo, weight, colours (SHARES, 3)) of each surface in photos that are not hidden."""
    table = without_glimpses(read_parquet(path)[0])
    observed: dict[SurfaceKey, list[tuple[str, float, np.ndarray]]] = {}
    for row in table.itertuples():
        if row.surface in SURFACES and row.photo not in set(hidden_photos):
            colours = np.asarray(row.colours, dtype=np.float64).reshape(-1, 3)
            key = SurfaceKey(row.room_id, row.surface)
            observed.setdefault(key, []).append((row.photo, float(row.weight), colours))
    return observed


def house_colours(
    path: str | Path,
    hidden_photos: Collection[str],
    room_ids: Sequence[str],
) -> HouseColours:
    """Return the colours of a house in the photos that are not hidden (``colours.parquet``)."""
    shape = len(room_ids), len(SURFACES)
    linear, photos = np.zeros((*shape, 3)), np.zeros(shape)
    for key, planes in read_colours(path, hidden_photos).items():
        place = room_ids.index(key.room_id), SURFACES.index(key.surface)
        of_photo: dict[str, float] = {}
        for photo, weight, _ in planes:
            of_photo[photo] = of_photo.get(photo, 0.0) + weight
        # Planes of one photo share its errors of light and camera pose. So a photo counts by the
        # root of its total weight: one that shows much of a surface does not outvote two.
        weights = [weight / of_photo[photo] ** 0.5 for photo, weight, _ in planes]
        linear[place] = usual_colour([shares for *_, shares in planes], weights)
        photos[place] = sum(min(1.0, weight / WHOLE) for weight in of_photo.values())
    return HouseColours(linear, photos)
