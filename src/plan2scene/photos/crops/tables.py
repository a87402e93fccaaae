"""crops.parquet and candidates.parquet of a house: which windows are kept, and why not the rest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby, product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.images import png_bytes
from plan2scene.io import write_parquet
from plan2scene.photos.crops.sampling import Candidate, medoid_index
from plan2scene.photos.crops.verdict import reason_text

if TYPE_CHECKING:
    import pandas as pd

#: Columns of both tables with the type of an empty one (docs/conventions.md).
_SHARED = {
    "photo": "str",
    "room_id": "str",
    "surface": "str",
    "plane": "int64",
    "index": "int64",
    "window": "object",
    "metres": "float64",
    "sharpness": "float64",
    "grazing_deg": "float64",
}
#: Columns of crops.parquet and of candidates.parquet.
COLUMNS = {
    "crop_id": "str",
    **_SHARED,
    "medoid": "bool",
    "png": "object",
    "detail": "object",
}
CANDIDATE_COLUMNS = {**_SHARED, "reason": "str", "crop_id": "str", "corners": "object"}
#: Crops kept of a surface that has no good one: with mild reasons only, and of each photo with
#: grave ones.
LAST_RESORT, WORST_RESORT = 10, 3


@dataclass(frozen=True)
class PhotoCandidate:
    """A candidate with where it is from."""

    photo: str
    #: Rooms that it shows: those of one size that the photo is assigned to, or its plane's own.
    rooms: tuple[str, ...]
    surface: str
    #: Number of the plane (mask) within the photo and surface.
    plane: int
    candidate: Candidate


@dataclass(frozen=True)
class Kept:
    """Which candidates of a house become crops."""

    #: Number of a candidate that some room keeps to its number k within the mask.
    crop_index: dict[int, int]
    #: (candidate's number, room) of the crops.
    rooms: set[tuple[int, str]]


def choose_kept(candidates: Sequence[PhotoCandidate], *, keep_index: bool = False) -> Kept:
    """Keep the good candidates; of a surface that has none, the least bad.

    A surface that a photo shows thus stays observed. With `keep_index` the crops keep their
    candidates' numbers, else they are counted within each mask.
    """
    members: dict[tuple[str, str], list[int]] = {}
    for number, item in enumerate(candidates):
        for room in item.rooms:
            members.setdefault((room, item.surface), []).append(number)
    rooms: set[tuple[int, str]] = set()
    for (room, _), numbers in members.items():
        verdicts = {number: candidates[number].candidate.verdict for number in numbers}
        kept = [number for number in numbers if verdicts[number].good]
        if not kept:
            kept = sorted(numbers, key=lambda number: (verdicts[number].score, number))
            mild = not verdicts[kept[0]].grave
            kept = [number for number in kept if verdicts[number].grave != mild]
            kept = kept[:LAST_RESORT] if mild else _few_of_each(kept, candidates)
        rooms.update((number, room) for number in kept)
    count: Counter[tuple[str, str, int]] = Counter()
    crop_index: dict[int, int] = {}
    for number in sorted({number for number, _ in rooms}):
        item = candidates[number]
        key = (item.photo, item.surface, item.plane)
        crop_index[number] = item.candidate.crop.index if keep_index else count[key]
        count[key] += 1
    return Kept(crop_index, rooms)


def _few_of_each(numbers: Sequence[int], candidates: Sequence[PhotoCandidate]) -> list[int]:
    """Return the first `WORST_RESORT` of each photo, so that no single photo has the only word."""
    few: dict[str, list[int]] = {}
    for number in numbers:
        few.setdefault(candidates[number].photo, []).append(number)
    return sorted(number for members in few.values() for number in members[:WORST_RESORT])


def write_tables(
    candidates: Sequence[PhotoCandidate],
    crops_path: str | Path,
    candidates_path: str | Path,
    *,
    dataset: str,
    house_id: str,
    keep_index: bool = False,
) -> pd.DataFrame:
    """Write both tables, one row per candidate and room; return crops.parquet's.

    The crops keep the order of the candidates, room by room within a photo; the medoid of each
    surface is marked. `keep_index` as in :func:`choose_kept`.
    """
    import pandas as pd

    kept = choose_kept(candidates, keep_index=keep_index)
    drawn: list[dict[str, Any]] = []
    rows: list[dict[str, Any]] = []
    images: dict[tuple[str, str], list[tuple[int, np.ndarray]]] = {}
    for _, group in groupby(enumerate(candidates), lambda pair: (pair[1].photo, pair[1].rooms)):
        members = list(group)
        encoded = {
            number: png_bytes(item.candidate.crop.image)
            for number, item in members
            if number in kept.crop_index
        }
        for room, (number, item) in product(members[0][1].rooms, members):
            row = _candidate_row(item, room, kept=(number, room) in kept.rooms)
            if (number, room) in kept.rooms:
                index = kept.crop_index[number]
                name = f"{item.surface}/{Path(item.photo).stem}_{item.plane}_crop{index}"
                row["crop_id"] = name
                images.setdefault((room, item.surface), []).append(
                    (len(rows), item.candidate.crop.image)
                )
                pixels = {"png": encoded[number], "detail": item.candidate.crop.detail}
                rows.append({**row, "index": index, "medoid": False, **pixels})
            drawn.append(row)
    for shown in images.values():
        rows[shown[medoid_index([image for _, image in shown])][0]]["medoid"] = True
    metadata = {"dataset": dataset, "house": house_id}
    frame = pd.DataFrame(rows, columns=list(COLUMNS)).astype(COLUMNS)
    write_parquet(crops_path, frame, metadata)
    table = pd.DataFrame(drawn, columns=list(CANDIDATE_COLUMNS)).astype(CANDIDATE_COLUMNS)
    write_parquet(candidates_path, table, metadata)
    return frame


def _candidate_row(item: PhotoCandidate, room: str, *, kept: bool) -> dict[str, Any]:
    """Return a row of candidates.parquet, without the name of a crop."""
    crop = item.candidate.crop
    return {
        "photo": item.photo,
        "room_id": room,
        "surface": item.surface,
        "plane": item.plane,
        "index": crop.index,
        "window": [float(value) for value in crop.window],
        "metres": crop.size_m,
        "sharpness": crop.sharpness,
        "grazing_deg": crop.grazing_deg,
        "reason": reason_text(item.candidate.verdict, kept=kept),
        "crop_id": "",
        "corners": [float(value) for value in crop.corners],
    }
