"""Colours of all surfaces of a house from all that its photos show of them, seen or not.

The log colour of a surface is a sum: what surfaces of its kind usually have, the house's light,
what the kind has in this house, the light of its room, and what only this surface has; what photos
show of it differs by the light on the part seen. All terms are normal, so what each surface is
expected to have is a linear function of all that is seen (best linear unbiased prediction, Robinson
1991, DOI 10.1214/ss/1177011926; kriging). A surface that is well seen keeps its colour; one of
which few pixels are seen, or none, follows its kind in the house and its room's light. Under one
light (`house.colours: corrected`) the terms of light are left out again, but for the house's
brightness, and surfaces of one material are one. Walls keep their room's light: paint and light
both differ from room to room, so what of a wall's colour is which nothing in its room tells.

Axes of log colours: brightness, red, blue (:func:`plan2scene.colour.log_axes`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from plan2scene.colour import LUMINANCE, from_log_axes, linear_to_srgb, log_axes, srgb_to_linear
from plan2scene.house import SURFACES, SurfaceKey
from plan2scene.io import read_parquet

#: Standard deviations on the three axes. Of the light of a house's photos: exposure is anything.
HOUSE = (1.0, 0.4, 0.4)
#: Of a kind of surface in a house: floor, wall, ceiling.
KIND = ((0.5, 0.3, 0.3), (0.3, 0.15, 0.15), (0.2, 0.06, 0.08))
#: Of a room's light.
ROOM = (0.15, 0.1, 0.08)
#: Of a surface within its kind, house and room.
OWN = ((0.5, 0.3, 0.3), (0.25, 0.12, 0.14), (0.2, 0.08, 0.08))
#: Of the light on what one photo shows of a surface.
SEEN = (0.3, 0.1, 0.12)
#: Weight of what a photo shows (share of its pixels, times the squared sine of the angle of view)
#: from which on it counts for a whole one.
WHOLE = 0.02
#: Share of what is seen whose luminance is most alike: the rest is shadow, glare, other things.
ALIKE = 0.5


@dataclass(frozen=True, eq=False)
class Shown:
    """What is seen of the surfaces of n rooms.

    Attributes
    ----------
    colours : (n, 3, 3) float64
        Linear RGB of the surfaces in the order of ``house.SURFACES``; anything where none is seen.
    photos : (n, 3) float64
        How many photos that is worth; 0 for none.
    materials : (n, 3) int64, optional
        Surfaces of one number are of one material; all differ without.
    one_light : bool
        Whether colours under one white light are wanted, not under that of each room (but walls).
    """

    colours: np.ndarray
    photos: np.ndarray
    materials: np.ndarray | None = None
    one_light: bool = False

    @classmethod
    def of_embeddings(cls, embeddings: np.ndarray, observed: np.ndarray) -> Shown:
        """Return what embeddings (n, 3, 11) of `observed` surfaces (n, 3) tell: a photo's each."""
        colours = srgb_to_linear(np.clip(embeddings[..., -3:].astype(np.float64), 0.0, 1.0))
        return cls(colours, observed.astype(np.float64))

    def but(self, place: tuple[int, int]) -> Shown:
        """Return the same without one surface."""
        photos = self.photos.copy()
        photos[place] = 0.0
        return replace(self, photos=photos)


def shown_colours(
    colours: str | Path,
    hidden_photos: Collection[str],
    room_ids: Sequence[str],
    materials: Mapping[SurfaceKey, str],
) -> Shown:
    """Return what visible photos show, of ``colours.parquet`` (docs/conventions.md).

    `materials` names those that surfaces share.
    """
    shape = len(room_ids), len(SURFACES)
    linear, photos = np.zeros((*shape, 3)), np.zeros(shape)
    seen_of, one_light = visible_colours(colours, hidden_photos)
    for key, seen in seen_of.items():
        place = _place(key, room_ids)
        of_photo: dict[str, float] = {}
        for photo, weight, _ in seen:
            of_photo[photo] = of_photo.get(photo, 0.0) + weight
        # What one photo shows has one light and place, right or wrong: photos count by the root
        # of what they show, so that one with much of it does not outvote two.
        weights = [weight / of_photo[photo] ** 0.5 for photo, weight, _ in seen]
        linear[place] = usual_colour([shares for *_, shares in seen], weights)
        photos[place] = sum(min(1.0, weight / WHOLE) for weight in of_photo.values())
    numbers = np.arange(photos.size).reshape(shape)
    first: dict[str, int] = {}
    for key, name in materials.items() if one_light else ():
        place = _place(key, room_ids)
        numbers[place] = first.setdefault(name, int(numbers[place]))
    return Shown(linear, photos, numbers, one_light)


def visible_colours(
    path: str | Path, hidden_photos: Collection[str]
) -> tuple[dict[SurfaceKey, list[tuple[str, float, np.ndarray]]], bool]:
    """Return (photo, weight, colours (SHARES, 3)) of each surface in photos that are not hidden.

    With it whether they are under one light.
    """
    table, metadata = read_parquet(path)
    found: dict[SurfaceKey, list[tuple[str, float, np.ndarray]]] = {}
    for row in table.itertuples():
        if row.photo not in set(hidden_photos):
            colours = np.asarray(row.colours, dtype=np.float64).reshape(-1, 3)
            key = SurfaceKey(row.room_id, row.surface)
            found.setdefault(key, []).append((row.photo, float(row.weight), colours))
    return found, metadata["colours"] == "corrected"


def _place(key: SurfaceKey, room_ids: Sequence[str]) -> tuple[int, int]:
    return room_ids.index(key.room_id), SURFACES.index(key.surface)


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


def expected_colours(shown: Shown, usual: np.ndarray, *, as_if_unseen: bool = False) -> np.ndarray:
    """Return the sRGB (n, 3, 3) in [0, 1] that every surface is expected to have.

    Parameters
    ----------
    shown : Shown
        What is seen of n rooms.
    usual : (n, 3, 3) float
        sRGB of such surfaces in other houses.
    as_if_unseen : bool
        Leave what is seen of a surface itself out of its colour.
    """
    size = shown.photos.size
    room, kind = np.divmod(np.arange(size), len(SURFACES))
    number = np.arange(size) if shown.materials is None else shown.materials.reshape(-1)
    one = number[:, None] == number
    photos = shown.photos.reshape(-1)
    seen = np.flatnonzero(photos > 0)
    values = log_axes(srgb_to_linear(np.clip(usual, 0.0, 1.0))).reshape(-1, 3)
    values = one @ values / one.sum(axis=1, keepdims=True)
    away = log_axes(shown.colours.reshape(-1, 3)[seen]) - values[seen]
    for axis in range(3) if len(seen) else ():
        own = np.array([of_kind[axis] for of_kind in OWN])[kind]
        of_kind = np.array([of_kind[axis] for of_kind in KIND])[kind]
        paint = (kind[:, None] == kind) * of_kind**2 + one * own**2
        of_room = (room[:, None] == room) * ROOM[axis] ** 2
        covariance = paint + HOUSE[axis] ** 2 + of_room
        if shown.one_light:  # white: of the house's light only the brightness is left
            on_walls = (kind == SURFACES.index("wall"))[:, None] * of_room
            wanted = paint + HOUSE[axis] ** 2 * (axis == 0) + on_walls
        else:
            wanted = covariance
        noise = np.diag(SEEN[axis] ** 2 / photos[seen])
        inverse = np.linalg.inv(covariance[np.ix_(seen, seen)] + noise)
        pull = inverse @ away[:, axis]
        expected = wanted[:, seen] @ pull
        if as_if_unseen:
            expected[seen] = away[:, axis] - pull / np.diag(inverse)
        values[:, axis] += expected
    return linear_to_srgb(np.minimum(from_log_axes(values), 1.0)).reshape(usual.shape)
