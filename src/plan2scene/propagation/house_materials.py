"""Materials of a house: surfaces of different rooms that are one material.

A floor that runs on, walls of one paint, ceilings alike. Told by the surfaces' codes, their colour
after light and by doors: rooms that no doors join are not compared. Floors are told by their
pattern more than by their colour, which lamps change from room to room; plain walls and ceilings
by their colour alone. Surfaces are joined while the evidence of all their pairs is for it (average
linkage), so one that is in doubt stays alone.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from plan2scene.colour import linear_to_srgb, srgb_to_linear
from plan2scene.floorplans.scene_json import read_scene_json
from plan2scene.house import SURFACES
from plan2scene.io import read_json, read_parquet, write_parquet
from plan2scene.propagation.graph import doors_between, house_graph

#: Evidence for one material of two surfaces that look exactly alike.
EVIDENCE = 0.85
#: What a difference of codes (mean over the code) and of colours (Euclidean, sRGB) takes from it.
WEIGHTS = {"floor": (1.0, 0.5), "wall": (0.5, 4.0), "ceiling": (0.5, 4.0)}
#: Evidence that makes one material e times likelier.
EVIDENCE_SCALE = 0.15
_COLUMNS = ["room_id", "surface", "material", "confidence", "colour", "rooms"]


@dataclass(frozen=True, eq=False)
class SeenSurface:
    """An observed surface: its room, code (8,), sRGB colour (3,) after light, number of crops."""

    room_id: str
    code: np.ndarray
    colour: np.ndarray
    crops: int


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

    `surfaces` is the table of the observed surfaces, `embeddings` that of the crops, which names
    their photos; `light` says under which light these are.
    """
    import pandas as pd

    plan = read_scene_json(scene_json, house)
    graph = house_graph(plan, {})
    doors = doors_between(len(graph.room_ids), graph.edges)
    place = {room: k for k, room in enumerate(graph.room_ids)}
    lit = read_json(light)
    photos = read_parquet(embeddings)[0][["room_id", "surface", "photo"]]
    photos = photos[~photos["photo"].isin(set(hidden_photos))]
    table, _ = read_parquet(surfaces)
    rows = []
    for kind in SURFACES:
        seen = []
        for row in table[table["surface"] == kind].itertuples():
            own = photos[(photos["room_id"] == row.room_id) & (photos["surface"] == kind)]
            gain = _gain(lit, own["photo"])
            colour = np.clip(np.asarray(row.embedding, dtype=np.float64)[-3:], 0.0, 1.0)
            after = linear_to_srgb(np.minimum(srgb_to_linear(colour) * gain, 1.0))
            code = np.asarray(row.embedding, dtype=np.float64)[:-3]
            seen.append(SeenSurface(row.room_id, code, after, int(row.n_crops)))
        index = [place[item.room_id] for item in seen]
        joined = np.isfinite(doors[np.ix_(index, index)])
        groups = grouped(pair_evidence(seen, kind, joined))
        for number, (members, evidence) in enumerate(groups, start=1):
            rooms = [seen[k].room_id for k in members]
            weights = [seen[k].crops for k in members]
            shared = np.average([seen[k].colour for k in members], axis=0, weights=weights)
            values = {
                "surface": kind,
                "material": f"{kind}-{number}",
                "confidence": float(1.0 / (1.0 + np.exp(-evidence / EVIDENCE_SCALE))),
                "colour": shared.astype(np.float32),
                "rooms": "|".join(rooms),
            }
            rows += [{"room_id": room} | values for room in rooms]
    metadata = {"dataset": dataset, "house": house, "colours": str(lit["colours"])}
    write_parquet(output, pd.DataFrame(rows, columns=_COLUMNS), metadata)


def _gain(light: Mapping[str, Any], photos: Iterable[str]) -> np.ndarray:
    """Return the factors (3,) that take a surface's colour under the house's light."""
    gains = light["gains"]
    if light["colours"] == "corrected":
        return np.ones(3)  # the colour has them already
    known = [gains[photo] for photo in photos if photo in gains]
    return np.asarray(np.exp(np.log(known).mean(axis=0))) if known else np.ones(3)


def pair_evidence(seen: Sequence[SeenSurface], kind: str, joined: np.ndarray) -> np.ndarray:
    """Return the evidence (n, n) that surfaces of a kind are one material; above 0 for it.

    `joined` (n, n) bool tells which rooms doors join.
    """
    by_code, by_colour = WEIGHTS[kind]
    codes = np.array([item.code for item in seen])
    colours = np.array([item.colour for item in seen])
    if not len(seen):
        return np.zeros((0, 0))
    apart = by_code * np.abs(codes[:, None] - codes[None]).mean(axis=2)
    apart += by_colour * np.linalg.norm(colours[:, None] - colours[None], axis=2)
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
