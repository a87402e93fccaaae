"""Materials of a house: surfaces of different rooms that are one material.

A floor that runs on, walls of one paint, ceilings alike. Told by the surfaces' codes, their colour
after light and by doors: rooms that no doors join are not compared. Floors are told by their
pattern more than by their colour, which lamps change from room to room; plain walls and ceilings by
their colour alone. A mean of few crops is in doubt: what chance alone makes two means differ by is
no difference. Walls are of many paints, and what one photo shows of one has one light: that two
look alike in a photo each may be chance, so few photos take from the evidence. Surfaces are joined
while the evidence of all their pairs is for it (average linkage), so one that is in doubt stays
alone.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.colour import linear_to_srgb, srgb_to_linear
from plan2scene.house import SURFACES
from plan2scene.io import read_json, read_parquet, write_parquet
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.propagation.graph import doors_between, house_graph

if TYPE_CHECKING:
    import pandas as pd

#: Evidence for one material of two surfaces that look exactly alike.
EVIDENCE = 0.85
#: What a difference of codes (mean over the code) and of colours (Euclidean, sRGB) takes from it.
WEIGHTS = {"floor": (1.0, 0.5), "wall": (0.5, 4.0), "ceiling": (0.5, 4.0)}
#: What it takes from it that one photo alone shows each of the two; half of it with two photos
#: each. Ceilings are white in most homes, floors are told by their pattern.
ONE_PHOTO = {"floor": 0.0, "wall": 0.12, "ceiling": 0.0}
#: Evidence that makes one material e times likelier.
EVIDENCE_SCALE = 0.15
#: Numbers of a code.
_CODE = 8
_COLUMNS = ["room_id", "surface", "material", "confidence", "colour", "rooms"]


@dataclass(frozen=True, eq=False)
class SeenSurface:
    """An observed surface: its room, code (8,), sRGB colour (3,) after light, number of crops.

    `doubt` (8,) is the variance of the code, as far as it is a mean of crops that differ; `photos`
    is how many the crops are of.
    """

    room_id: str
    code: np.ndarray
    colour: np.ndarray
    crops: int
    doubt: np.ndarray = field(default_factory=lambda: np.zeros(_CODE))
    photos: int = 1


def find_materials(
    scene_json: str | Path,
    surfaces: str | Path,
    embeddings: str | Path,
    light: str | Path,
    hidden_photos: Collection[str],
    output: str | Path,
    *,
    house: str,
    dataset: str,
) -> None:
    """Write ``materials.parquet`` (docs/conventions.md): a row for each surface that shares one.

    `surfaces` is the table of the observed surfaces, `embeddings` that of all crops, `light` says
    under which light these are.
    """
    import pandas as pd

    graph = house_graph(read_scene_json(scene_json, house), {})
    doors = np.isfinite(doors_between(len(graph.room_ids), graph.edges))
    place = {room: k for k, room in enumerate(graph.room_ids)}
    lit = read_json(light)
    crops, _ = read_parquet(embeddings)
    crops = crops[~crops["photo"].isin(set(hidden_photos))]
    table, _ = read_parquet(surfaces)
    rows = []
    for kind in SURFACES:
        of_kind = crops[crops["surface"] == kind]
        spread = _spread_within(of_kind)
        seen = [
            _seen_surface(row, of_kind[of_kind["room_id"] == row.room_id], lit, spread)
            for row in table[table["surface"] == kind].itertuples()
        ]
        index = [place[item.room_id] for item in seen]
        groups = grouped(pair_evidence(seen, kind, doors[np.ix_(index, index)]))
        for number, (members, evidence) in enumerate(groups, start=1):
            rows += _rows_of([seen[k] for k in members], f"{kind}-{number}", kind, evidence)
    metadata = {"dataset": dataset, "house": house, "colours": str(lit["colours"])}
    write_parquet(output, pd.DataFrame(rows, columns=_COLUMNS), metadata)


def _codes(crops: pd.DataFrame) -> np.ndarray:
    """Return the codes (n, 8) of crops."""
    return np.stack(list(crops["embedding"])).astype(np.float64)[:, :-3]


def _spread_within(crops: pd.DataFrame) -> np.ndarray:
    """Return the variance (8,) of the codes of one room's crops, pooled over rooms; 0 unknown."""
    of_rooms = [_codes(of_room) for _, of_room in crops.groupby("room_id")]
    free = sum(len(codes) - 1 for codes in of_rooms)
    if not free:
        return np.zeros(_CODE)
    squares = [((codes - codes.mean(axis=0)) ** 2).sum(axis=0) for codes in of_rooms]
    return np.asarray(np.sum(squares, axis=0) / free)


def _seen_surface(
    row: Any, crops: pd.DataFrame, light: Mapping[str, Any], spread: np.ndarray
) -> SeenSurface:
    """Return a row of surfaces.parquet with the facts of its visible crops.

    A pattern is known from all crops, whose codes differ by a variance of `spread` (8,); of plain
    walls and ceilings the plainest crop, which the row is about, has the least of other things.
    """
    values = np.asarray(row.embedding, dtype=np.float64)
    code, doubt = values[:-3], np.zeros(_CODE)
    if row.surface == "floor" and len(crops):
        code, doubt = _codes(crops).mean(axis=0), spread / len(crops)
    linear = srgb_to_linear(np.clip(values[-3:], 0.0, 1.0)) * _gain(light, crops["photo"])
    after = linear_to_srgb(np.minimum(linear, 1.0))
    photos = max(1, crops["photo"].nunique())
    return SeenSurface(row.room_id, code, after, int(row.n_crops), doubt, photos)


def _rows_of(
    members: Sequence[SeenSurface], name: str, kind: str, evidence: float
) -> list[dict[str, Any]]:
    """Return the rows of one material's surfaces."""
    weights = [item.crops for item in members]
    shared = np.average([item.colour for item in members], axis=0, weights=weights)
    values = {
        "surface": kind,
        "material": name,
        "confidence": float(1.0 / (1.0 + np.exp(-evidence / EVIDENCE_SCALE))),
        "colour": shared.astype(np.float32),
        "rooms": "|".join(item.room_id for item in members),
    }
    return [{"room_id": item.room_id} | values for item in members]


def _gain(light: Mapping[str, Any], photos: Iterable[str]) -> np.ndarray:
    """Return the factors (3,) that take a surface's colour under the house's light."""
    gains = light["gains"]
    if light["colours"] == "corrected":
        return np.ones(3)  # the colour has them already
    known = [gains[photo] for photo in photos if photo in gains]
    return np.asarray(np.exp(np.log(known).mean(axis=0))) if known else np.ones(3)


def pair_evidence(seen: Sequence[SeenSurface], kind: str, joined: np.ndarray) -> np.ndarray:
    """Return the evidence (n, n) that surfaces of a kind are one material; above 0 for it.

    `joined` (n, n) bool tells which rooms doors join. The squared difference of two means is by
    the sum of their variances larger than that of what they are means of, on average.
    """
    by_code, by_colour = WEIGHTS[kind]
    codes = np.array([item.code for item in seen])
    colours = np.array([item.colour for item in seen])
    if not len(seen):
        return np.zeros((0, 0))
    doubts = np.array([item.doubt for item in seen])
    squares = (codes[:, None] - codes[None]) ** 2 - doubts[:, None] - doubts[None]
    apart = by_code * np.sqrt(np.maximum(squares, 0.0)).mean(axis=2)
    apart += by_colour * np.linalg.norm(colours[:, None] - colours[None], axis=2)
    chance = 1.0 / np.array([item.photos for item in seen])
    apart += ONE_PHOTO[kind] * (chance[:, None] + chance[None]) / 2.0
    return np.where(joined, EVIDENCE - apart, -np.inf)


def grouped(evidence: np.ndarray) -> list[tuple[list[int], float]]:
    """Return the groups of two and more, and the mean evidence of their pairs.

    The two groups of the strongest mean evidence are joined as long as it is for it.
    """
    groups = [[k] for k in range(len(evidence))]
    while len(groups) > 1:
        pairs = [
            (float(evidence[np.ix_(a, b)].mean()), i, j)
            for i, a in enumerate(groups)
            for j, b in enumerate(groups)
            if i < j
        ]
        best, i, j = max(pairs, key=lambda pair: (pair[0], -pair[1], -pair[2]))
        if not best > 0.0:
            break
        groups[i] = sorted(groups[i] + groups.pop(j))
    found = []
    for group in sorted(groups):
        if len(group) > 1:
            inner = evidence[np.ix_(group, group)][np.triu_indices(len(group), 1)]
            found.append((group, float(inner.mean())))
    return found
