"""Observations: the colours that photos show of the surfaces of a house (``colours.parquet``).

Crops are the few windows that show a pattern well. The colour of a surface is known better from
all that is seen of it, also where no good window fits. Each plane of a photo gives the colours of
equal shares of its pixels, from the darkest to the brightest. Colours are linear RGB.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from plan2scene.colour import LUMINANCE, srgb_to_linear
from plan2scene.house import SURFACES, SurfaceKey
from plan2scene.io import read_parquet, write_parquet

if TYPE_CHECKING:
    import pandas as pd

#: Equal shares of a plane's pixels whose colours are kept.
SHARES = 32
#: Weight of an observation from which on it counts for a whole photo.
WHOLE = 0.02
#: A floor of which another room's photo shows less (share of its pixels) takes no colour from it.
#: Chosen on the demo, where two are 15 and 20 CIEDE2000 off by such.
GLIMPSE = 2e-3
#: Share of what is seen whose luminance is most alike: the rest is shadow, glare, other things.
ALIKE = 0.5
#: Share of a surface's pixels, the darkest, that tells no hue. Chosen on a real listing; three
#: others, two real flats and the demo report (development).
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
    rooms: tuple[str, ...]  #: whose it may be
    #: of ``house.SURFACES``; ``door`` for a door leaf, ``frame`` for frames of windows
    surface: str
    plane: int  #: number of the plane within photo and surface
    own: bool  #: whether it is seen from within the room
    #: ids of the walls on the plane; none where they are not known. Of a door that of the opening.
    walls: tuple[str, ...]
    #: share of the photo's pixels, times the mean squared sine of the angle of view, shared among
    #: the rooms
    weight: float
    #: (SHARES, 3) float32: Linear RGB of equal shares of it, from the darkest to the brightest
    colours: np.ndarray


@dataclass(frozen=True, eq=False)
class HouseColours:
    """What photos show of the surfaces of n rooms."""

    #: (n, 3, 3) float64: Linear RGB of the surfaces in the order of ``house.SURFACES``; anything
    #: where none is seen
    colours: np.ndarray
    photos: np.ndarray  #: (n, 3) float64: How many photos that is worth; 0 for none

    @classmethod
    def of_embeddings(cls, embeddings: np.ndarray, observed: np.ndarray) -> HouseColours:
        """Return colours of embeddings (n, 3, 11) that are `observed` (n, 3), a photo each."""
        colours = srgb_to_linear(np.clip(embeddings[..., -3:].astype(np.float64), 0.0, 1.0))
        return cls(colours, observed.astype(np.float64))

    def without(self, place: tuple[int, int]) -> HouseColours:
        """Return the same without one surface."""
        photos = self.photos.copy()
        photos[place] = 0.0
        return replace(self, photos=photos)


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


def usual_colour(shares: Iterable[np.ndarray], weights: Iterable[float]) -> np.ndarray:
    """Return the mean (3,) of the `ALIKE` share of colours whose luminance is most alike.

    The shortest half (Rousseeuw 1984, DOI 10.1080/01621459.1984.10477105) of log luminance: shadows
    on one side, glare and lamps on the other do not move it.

    Parameters
    ----------
    shares : arrays (m, 3), linear RGB
        What each photo shows, of equal shares of its pixels.
    weights : float of each
    """
    colours = np.concatenate(list(map(np.asarray, shares)))
    each = [np.full(len(s), w / len(s)) for s, w in zip(shares, weights, strict=True)]
    weight = np.concatenate(each)
    log = np.log(colours @ LUMINANCE + 0.01)
    order = np.argsort(log, kind="stable")
    log, colours, weight = log[order], colours[order], weight[order]
    ends = np.cumsum(weight) / weight.sum()
    starts = ends - weight / weight.sum()
    last = np.searchsorted(ends, starts + ALIKE - 1e-9)
    fits = np.flatnonzero(last < len(log))
    first = fits[(log[last[fits]] - log[fits]).argmin()]
    alike = slice(first, last[first] + 1)
    return np.average(colours[alike], axis=0, weights=weight[alike])


def matte_colour(shares: Iterable[np.ndarray], weights: Iterable[float]) -> np.ndarray:
    """Return :func:`usual_colour` (3,) with the hue of the darker half: glare adds the light's own.

    Dichromatic reflection (Shafer 1985, DOI 10.1002/col.5080100409). The `DARKEST` lies in the
    shadow of furniture, whose colour it has. Parameters as there.
    """
    shares, weights = list(shares), list(weights)
    usual = usual_colour(shares, weights)
    colours = np.concatenate(shares)
    weight = np.concatenate(
        [np.full(len(s), w / len(s)) for s, w in zip(shares, weights, strict=True)]
    )
    order = np.argsort(colours @ LUMINANCE, kind="stable")
    ends = np.cumsum(weight[order]) / weight.sum()
    dark = order[(ends > DARKEST) & (ends <= 0.5)]
    hue = np.average(colours[dark], axis=0, weights=weight[dark])
    return np.asarray(hue * (usual @ LUMINANCE) / max(hue @ LUMINANCE, 1e-12))


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
    """Return the rows of ``colours.parquet`` without floors that another room's photo glimpses.

    They lie in another light and are seen at a flat angle, so they tell less than the floor of the
    next room.
    """
    seen = table.groupby(["photo", "room_id", "surface"])["weight"].transform("sum")
    return table[(table["surface"] != "floor") | table["own"] | (seen >= GLIMPSE)]


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
    """Return what visible photos show of a house, of ``colours.parquet``."""
    shape = len(room_ids), len(SURFACES)
    linear, photos = np.zeros((*shape, 3)), np.zeros(shape)
    for key, planes in read_colours(path, hidden_photos).items():
        place = room_ids.index(key.room_id), SURFACES.index(key.surface)
        of_photo: dict[str, float] = {}
        for photo, weight, _ in planes:
            of_photo[photo] = of_photo.get(photo, 0.0) + weight
        # What one photo shows has one light and place, right or wrong: photos count by the root
        # of what they show, so that one with much of it does not outvote two.
        weights = [weight / of_photo[photo] ** 0.5 for photo, weight, _ in planes]
        linear[place] = usual_colour([shares for *_, shares in planes], weights)
        photos[place] = sum(min(1.0, weight / WHOLE) for weight in of_photo.values())
    return HouseColours(linear, photos)
