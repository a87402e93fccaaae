"""Accent walls: a wall of another paint than the other walls of its room.

Located photos tell walls apart. Light differs from wall to wall, most of all in brightness, so a
wall counts as an accent only where several photos that show it beside others agree on a difference
that light does not make.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd

from plan2scene.colour import linear_to_srgb, rgb_to_lab
from plan2scene.house import House, SurfaceKey
from plan2scene.io import read_parquet
from plan2scene.paint.light import recoloured
from plan2scene.paint.observations import usual_colour
from plan2scene.plans.parse import ID_PATTERN
from plan2scene.textures.exemplar.house_tiles import PLAIN, exemplar_of
from plan2scene.textures.inputs import KnownSurface, TextureInputs
from plan2scene.textures.tiles import Tile

#: Difference in Lab, lightness counted half, from which a wall is of another paint: on white
#: walls of two real flats (development) two photos agree on 13 at most.
APART = 20.0
#: Photos that have to show it, each with the least weight (``colours.parquet``) of both sides.
PHOTOS, LEAST = 2, 0.02
_LIGHTNESS = np.array([0.5, 1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Accent:
    """Walls on one plane of a room that are of another paint."""

    keys: tuple[SurfaceKey, ...]  #: a key for each wall
    colour: np.ndarray  #: (3,) float64, sRGB
    planes: frozenset[str]  #: names of the photos' planes that show it, as crop ids begin


def find_accents(colours: str | Path) -> list[Accent]:
    """Return the accent walls of a house by what its photos show (``colours.parquet``)."""
    table, _ = read_parquet(colours)
    seen = table[(table["surface"] == "wall") & table["own"] & (table["walls"] != "")]
    accents = []
    for room_id, of_room in seen.groupby("room_id", sort=True):
        while (walls := _most_apart(of_room)) is not None:
            mine = of_room[of_room["walls"] == walls]
            # The others are compared without it: beside a red wall a white one is as far apart.
            of_room = of_room[of_room["walls"] != walls]
            keys = tuple(SurfaceKey(str(room_id), f"wall.{name}") for name in walls.split("|"))
            planes = frozenset(f"wall/{Path(r.photo).stem}_{r.plane}" for r in mine.itertuples())
            accents.append(Accent(keys, linear_to_srgb(_usual(mine)), planes))
    return accents


def _most_apart(of_room: pd.DataFrame) -> str | None:
    """Return the accent walls of a room that differ most from its other walls; None without."""
    far: dict[str, float] = {}
    for walls, mine in of_room.groupby("walls", sort=True):
        rest = of_room[of_room["walls"] != walls]
        # The paint of most of what is seen is the room's.
        if mine["weight"].sum() < rest["weight"].sum() and _apart(mine, rest) >= APART:
            lab, other = (rgb_to_lab(linear_to_srgb(_usual(part))) for part in (mine, rest))
            far[str(walls)] = float(np.linalg.norm((lab - other) * _LIGHTNESS))
    named = [walls for walls in far if all(map(_can_name, walls.split("|")))]
    return max(named, key=lambda walls: far[walls]) if named else None


def _can_name(wall: str) -> bool:
    """Return whether a wall's id can be part of a file's name, as ids of read plans can."""
    return ID_PATTERN.fullmatch(wall) is not None


def _apart(mine: pd.DataFrame, rest: pd.DataFrame) -> float:
    """Return how far a wall is from the others of the photos that show both, on the whole.

    0 where too few photos do, or show half of it at least. Differences of photos that do not agree
    cancel out.
    """
    away = []
    for photo, own in mine.groupby("photo"):
        others = rest[rest["photo"] == photo]
        if min(own["weight"].sum(), others["weight"].sum()) >= LEAST:
            lab, other = (rgb_to_lab(linear_to_srgb(_usual(part))) for part in (own, others))
            away.append((lab - other) * _LIGHTNESS)
    if len(away) < PHOTOS:
        return 0.0
    mean = np.mean(away, axis=0)
    apart = float(np.linalg.norm(mean))
    agree = np.array(away) @ mean >= 0.5 * apart**2
    return apart if agree.sum() >= PHOTOS else 0.0


def _usual(rows: pd.DataFrame) -> np.ndarray:
    """Return the usual linear RGB (3,) of rows of ``colours.parquet``."""
    shares = [np.asarray(c, dtype=np.float64).reshape(-1, 3) for c in rows["colours"]]
    return usual_colour(shares, rows["weight"])


def with_accents(
    inputs: TextureInputs, tiles: Mapping[SurfaceKey, Tile], accents: Sequence[Accent]
) -> tuple[House, tuple[KnownSurface, ...], dict[SurfaceKey, Tile]]:
    """Return house, surfaces and tiles; accent walls have their own.

    A tile is quilted from the wall's own crops, or else is the room's in the wall's colour.
    """
    known = {surface.key: surface for surface in inputs.surfaces}
    surfaces, made = list(inputs.surfaces), dict(tiles)
    for accent in accents:
        room = SurfaceKey(accent.keys[0].room_id, "wall")
        crops = [
            crop
            for crop in inputs.crops
            if crop.key == room and crop.crop_id.rpartition("_crop")[0] in accent.planes
        ]
        plain = known[room].substance == PLAIN
        tile = exemplar_of(inputs, crops, accent.colour, plain=plain) if crops else None
        if tile is None:
            image = recoloured(tiles[room].image, accent.colour)
            source = f"{tiles[room].source}, in the colour of an accent wall"
            tile = replace(tiles[room], image=image, source=source)
        for key in accent.keys:
            surfaces.append(replace(known[room], key=key, material="", colour=accent.colour))
            made[key] = tile
    house = replace(inputs.house, accents=tuple(key for accent in accents for key in accent.keys))
    return house, tuple(surfaces), made
