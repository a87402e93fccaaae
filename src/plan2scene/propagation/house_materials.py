"""Materials of a house: which surfaces of different rooms share one material.

Examples are a floor that runs on through several rooms, or walls of one paint. Two surfaces are
compared by their codes (the pattern) and by their colours after correction of the light. Rooms that
no doors connect are not compared. For floors the code counts more than the colour, because lamps
change the colour from room to room; a passage without a leaf between them, or wood on both, is more
evidence. For walls and ceilings the colour counts most. The mean code of few crops is noisy, so the
part of a difference that noise explains is subtracted. Two walls that only one photo each shows may
look alike by chance, so few photos weaken the evidence. Groups of surfaces are joined while the
mean evidence of their pairs is positive (average linkage), so a doubtful surface stays alone.
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
    """Terms of the evidence that two surfaces share a material: they do if the sum is above 0.

    Triples are for floor, wall, ceiling. Chosen on synthetic homes and real flats (development).
    """

    alike: float = 0.85  #: evidence of two surfaces that look exactly alike
    #: Subtracted per unit of difference of the codes (mean absolute difference).
    by_code: tuple[float, float, float] = (1.0, 0.5, 0.5)
    #: Subtracted per unit of difference of the colours (Euclidean, sRGB in [0, 1]).
    by_colour: tuple[float, float, float] = (0.5, 4.0, 4.0)
    #: Subtracted if only one photo shows each of the two surfaces; half of it with two photos each.
    #: It is 0 for ceilings, which are white in most homes, and floors, known by their pattern.
    one_photo: tuple[float, float, float] = (0.0, 0.12, 0.0)
    #: Added for two floors that a passage without a leaf joins: in synthetic homes 24 of 30 floors
    #: run on through a passage (101 of 267 through a door), in real homes all six do. If the floors
    #: have one substance, it is multiplied by the passage's width over `wide[0]`, the width limited
    #: to the range `wide`, metres: rooms of an open plan share a floor.
    passage: float = 0.28
    wide: tuple[float, float] = (0.9, 2.7)
    #: Added for two floors of wood: homes seldom have two kinds of wood on one storey, and lamps,
    #: rugs and glare change its look from photo to photo. Chosen on one real listing (development).
    wood: float = 0.25
    scale: float = 0.15  #: evidence that multiplies the odds of one material by e


EVIDENCE = MaterialSettings()
_APART = 1e9  #: A distance so large that no groups of surfaces are joined
#: Length of a code.
_CODE = 8
_COLUMNS = ["room_id", "surface", "material", "confidence", "colour", "rooms"]
Gains = Mapping[str, Sequence[float]]  #: Photo -> factors on linear RGB


@dataclass(frozen=True, eq=False)
class SeenSurface:
    """An observed surface: its room, code (8,), sRGB colour (3,) after light, number of crops.

    `doubt` (8,) is the variance of the code if it is a mean over crops, else 0. `photos` is the
    number of photos that the crops come from. `substance` is one of ``house.SUBSTANCES``.
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
    """Write ``materials.parquet`` (docs/conventions.md): a row per surface that shares a material.

    `surfaces` is the table of the observed surfaces, `embeddings` the table of all crops, `light`
    the gains of their photos (``light.json``).
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
        seen_surfaces = [
            _seen_surface(row, of_kind[of_kind["room_id"] == row.room_id], gains, spread)
            for row in table[table["surface"] == kind].itertuples()
        ]
        index = [place[item.room_id] for item in seen_surfaces]
        pairs = pair_evidence(seen_surfaces, kind, doors[np.ix_(index, index)])
        if kind == "floor":
            substances = np.array([item.substance for item in seen_surfaces])
            alike = substances[:, None] == substances[None]
            wide = open_[np.ix_(index, index)]
            pairs += EVIDENCE.passage * np.where(alike, wide, np.minimum(wide, 1.0))
        groups = grouped(pairs)
        for number, (members, evidence) in enumerate(groups, start=1):
            rows += _rows_of(
                [seen_surfaces[k] for k in members], f"{kind}-{number}", kind, evidence
            )
    write_parquet(
        output, pd.DataFrame(rows, columns=_COLUMNS), {"dataset": dataset, "house": house}
    )


def _codes(crops: pd.DataFrame) -> np.ndarray:
    """Return the codes (n, 8) of crops."""
    return np.stack(list(crops["embedding"])).astype(np.float64)[:, :-3]


def _spread_within(crops: pd.DataFrame) -> np.ndarray:
    """Return the variance (8,) of codes within a room, pooled over rooms; 0 if it is unknown."""
    of_rooms = [_codes(of_room) for _, of_room in crops.groupby("room_id")]
    free = sum(len(codes) - 1 for codes in of_rooms)
    if not free:
        return np.zeros(_CODE)
    squares = [((codes - codes.mean(axis=0)) ** 2).sum(axis=0) for codes in of_rooms]
    return np.asarray(np.sum(squares, axis=0) / free)


def _seen_surface(row: Any, crops: pd.DataFrame, gains: Gains, spread: np.ndarray) -> SeenSurface:
    """Return the surface of a row of surfaces.parquet, with the facts of its visible crops.

    A floor's code is the mean over all its crops, whose codes have the variance `spread` (8,). A
    wall or ceiling keeps the row's code, that of the plainest crop: it shows fewest other things.
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
    """Return the factors (3,) on linear RGB that bring a surface under the house's light."""
    known = [gains[photo] for photo in photos if photo in gains]
    return np.asarray(np.exp(np.log(known).mean(axis=0))) if known else np.ones(3)


def pair_evidence(seen: Sequence[SeenSurface], kind: str, joined: np.ndarray) -> np.ndarray:
    """Return the evidence (n, n) that surfaces of a kind share a material; above 0 they do.

    `joined` (n, n) bool: pairs of rooms that doors connect. On average, noise adds the sum of the
    variances of two mean codes to their squared difference, so that sum is subtracted.
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
    """Return the groups of two or more surfaces, each with the mean evidence of its pairs.

    Average linkage (:func:`scipy.cluster.hierarchy.linkage`): the two groups with the largest mean
    evidence are joined, again and again, while that is above 0.
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
