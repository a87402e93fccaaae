"""Materials of a house: surfaces of different rooms that are one material.

A floor that runs on, walls of one paint, ceilings alike. The evidence is the surfaces' codes and
their colours after light; rooms that no doors join are not compared. For floors the pattern counts
more than the colour, which lamps change from room to room; passages without a leaf count, and so
does that both are of wood. For plain walls and ceilings the colour alone counts. The mean of few
crops is uncertain: a difference of two means that chance explains does not count. Two walls that
one photo each shows may look alike by chance, so few photos weaken the evidence. Surfaces are
joined while the mean evidence of all pairs is positive (average linkage), so a doubtful one stays
alone.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import squareform

from plan2scene.colour import linear_to_srgb, srgb_to_linear
from plan2scene.house import SURFACES
from plan2scene.io import read_parquet, write_parquet
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.propagation.graph import doors_between, house_graph
from plan2scene.stage_json import read_stage_json

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class MaterialSettings:
    """Evidence that two surfaces are one material; above 0 for it. By floor, wall, ceiling.

    Chosen on synthetic homes and real flats (development).
    """

    alike: float = 0.85  #: of two surfaces that look exactly alike
    #: What a difference of codes takes from it, a mean over the code.
    by_code: tuple[float, float, float] = (1.0, 0.5, 0.5)
    #: What a difference of colours takes from it, Euclidean, sRGB in [0, 1].
    by_colour: tuple[float, float, float] = (0.5, 4.0, 4.0)
    #: What it takes from it that one photo alone shows each of the two; half of it with two photos
    #: each. Ceilings are white in most homes, floors are known by their pattern.
    one_photo: tuple[float, float, float] = (0.0, 0.12, 0.0)
    #: Of floors that a passage without a leaf joins: 24 of 30 in synthetic homes run on through
    #: one, 101 of 267 through a door; all of six in real homes do. For floors of one substance it
    #: grows with the passage's width over the first number, metres, up to the second: rooms of an
    #: open plan are floored together.
    passage: float = 0.28
    wide: tuple[float, float] = (0.9, 2.7)
    #: Of two floors of wood: homes seldom have two kinds of it on one storey, and lamps, rugs and
    #: glare change its looks from photo to photo. Chosen on one real listing (development).
    wood: float = 0.25
    scale: float = 0.15  #: evidence that makes one material e times likelier


EVIDENCE = MaterialSettings()
_APART = 1e9  #: A distance that no two groups of surfaces are joined over
#: Numbers of a code.
_CODE = 8
_COLUMNS = ["room_id", "surface", "material", "confidence", "colour", "rooms"]
Gains = Mapping[str, Sequence[float]]  #: Photo -> factors on linear RGB


@dataclass(frozen=True, eq=False)
class SeenSurface:
    """An observed surface: its room, code (8,), sRGB colour (3,) after light, number of crops.

    `doubt` (8,) is the variance of the code, as far as it is a mean of crops that differ; `photos`
    is how many the crops are of; `substance` is of ``house.SUBSTANCES``.
    """

    room_id: str
    code: np.ndarray
    colour: np.ndarray
    crops: int
    doubt: np.ndarray
    photos: int
    substance: str


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

    `surfaces` is the table of the observed surfaces, `embeddings` that of all crops, `light` the
    gains of their photos (``light.json``).
    """
    import pandas as pd

    plan = read_scene_json(scene_json, house)
    graph = house_graph(plan, {})
    doors = np.isfinite(doors_between(len(graph.room_ids), graph.edges))
    place = {room: k for k, room in enumerate(graph.room_ids)}
    open_ = np.zeros(doors.shape)
    for one, other, metres in plan.passages():
        pair = place[one], place[other]
        width = float(np.clip(metres, *EVIDENCE.wide)) / EVIDENCE.wide[0]
        open_[pair] = open_[pair[::-1]] = max(open_[pair], width)
    gains = read_stage_json(light, "light")["gains"]
    crops, _ = read_parquet(embeddings)
    crops = crops[~crops["photo"].isin(set(hidden_photos))]
    table, _ = read_parquet(surfaces)
    rows = []
    for kind in SURFACES:
        of_kind = crops[crops["surface"] == kind]
        spread = _spread_within(of_kind)
        seen = [
            _seen_surface(row, of_kind[of_kind["room_id"] == row.room_id], gains, spread)
            for row in table[table["surface"] == kind].itertuples()
        ]
        index = [place[item.room_id] for item in seen]
        pairs = pair_evidence(seen, kind, doors[np.ix_(index, index)])
        if kind == "floor":
            substances = np.array([item.substance for item in seen])
            alike = substances[:, None] == substances[None]
            wide = open_[np.ix_(index, index)]
            pairs += EVIDENCE.passage * np.where(alike, wide, np.minimum(wide, 1.0))
        groups = grouped(pairs)
        for number, (members, evidence) in enumerate(groups, start=1):
            rows += _rows_of([seen[k] for k in members], f"{kind}-{number}", kind, evidence)
    write_parquet(
        output, pd.DataFrame(rows, columns=_COLUMNS), {"dataset": dataset, "house": house}
    )


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


def _seen_surface(row: Any, crops: pd.DataFrame, gains: Gains, spread: np.ndarray) -> SeenSurface:
    """Return a row of surfaces.parquet with the facts of its visible crops.

    A pattern is known from all crops, whose codes differ by a variance of `spread` (8,); of plain
    walls and ceilings the plainest crop, which the row is about, has the least of other things.
    """
    values = np.asarray(row.embedding, dtype=np.float64)
    code, doubt = values[:-3], np.zeros(_CODE)
    if row.surface == "floor" and len(crops):
        code, doubt = _codes(crops).mean(axis=0), spread / len(crops)
    linear = srgb_to_linear(np.clip(values[-3:], 0.0, 1.0)) * _gain(gains, crops["photo"])
    after = linear_to_srgb(np.minimum(linear, 1.0))
    photos = max(1, crops["photo"].nunique())
    return SeenSurface(row.room_id, code, after, int(row.n_crops), doubt, photos, row.substance)


def _rows_of(
    members: Sequence[SeenSurface], name: str, kind: str, evidence: float
) -> list[dict[str, Any]]:
    """Return the rows of one material's surfaces."""
    weights = [item.crops for item in members]
    shared = np.average([item.colour for item in members], axis=0, weights=weights)
    values = {
        "surface": kind,
        "material": name,
        "confidence": float(1.0 / (1.0 + np.exp(-evidence / EVIDENCE.scale))),
        "colour": shared.astype(np.float32),
        "rooms": "|".join(item.room_id for item in members),
    }
    return [{"room_id": item.room_id} | values for item in members]


def _gain(gains: Gains, photos: Iterable[str]) -> np.ndarray:
    """Return the factors (3,) that take a surface's colour under the house's light."""
    known = [gains[photo] for photo in photos if photo in gains]
    return np.asarray(np.exp(np.log(known).mean(axis=0))) if known else np.ones(3)


def pair_evidence(seen: Sequence[SeenSurface], kind: str, joined: np.ndarray) -> np.ndarray:
    """Return the evidence (n, n) that surfaces of a kind are one material; above 0 for it.

    `joined` (n, n) bool: rooms that doors join. The squared difference of two means exceeds that
    of the true values by the sum of their variances, on average.
    """
    number = SURFACES.index(kind)
    codes = np.array([item.code for item in seen])
    colours = np.array([item.colour for item in seen])
    if not len(seen):
        return np.zeros((0, 0))
    doubts = np.array([item.doubt for item in seen])
    squares = (codes[:, None] - codes[None]) ** 2 - doubts[:, None] - doubts[None]
    apart = EVIDENCE.by_code[number] * np.sqrt(np.maximum(squares, 0.0)).mean(axis=2)
    apart += EVIDENCE.by_colour[number] * np.linalg.norm(colours[:, None] - colours[None], axis=2)
    chance = 1.0 / np.array([item.photos for item in seen])
    apart += EVIDENCE.one_photo[number] * (chance[:, None] + chance[None]) / 2.0
    wooden = np.array([kind == "floor" and item.substance == "wood" for item in seen])
    apart -= EVIDENCE.wood * (wooden[:, None] & wooden[None])
    return np.where(joined, EVIDENCE.alike - apart, -np.inf)


def grouped(evidence: np.ndarray) -> list[tuple[list[int], float]]:
    """Return the groups of two and more, and the mean evidence of their pairs.

    Average linkage (:func:`scipy.cluster.hierarchy.linkage`): the two groups of the strongest mean
    evidence are joined as long as it is for it.
    """
    if len(evidence) < 2:
        return []
    most = float(np.abs(evidence[np.isfinite(evidence)]).max(initial=0.0))
    apart = np.minimum(most - evidence, _APART)
    tree = linkage(squareform(apart, checks=False), method="average")
    label = fcluster(tree, np.nextafter(most, 0.0), criterion="distance")
    groups = sorted(np.flatnonzero(label == name).tolist() for name in set(label))
    return [
        (group, float(evidence[np.ix_(group, group)][np.triu_indices(len(group), 1)].mean()))
        for group in groups
        if len(group) > 1
    ]
