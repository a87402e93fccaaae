"""crops.parquet and candidates.parquet of a house: which candidates become crops, and why."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from itertools import groupby, product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.images import medoid_index, png_bytes
from plan2scene.io import write_parquet
from plan2scene.photos.crops.sampling import Candidate, reason_text

if TYPE_CHECKING:
    import pandas as pd

#: Columns of both tables with their types (docs/conventions.md).
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
COLUMNS = {"crop_id": "str", **_SHARED, "medoid": "bool", "png": "object", "detail": "object"}
CANDIDATE_COLUMNS = {**_SHARED, "reason": "str", "crop_id": "str", "corners": "object"}
#: Largest number of crops of a surface without a good one: in all, where some windows have only
#: mild reasons; else of each photo.
LAST_RESORT, WORST_RESORT = 10, 3
#: Largest number of good crops of a surface: those of six planes of the paper. More add nothing.
MOST = 60


def select_candidates(candidates: Sequence[Candidate]) -> set[tuple[int, str]]:
    """Return (number in the sequence, room) of the candidates that become crops.

    Of each surface the good candidates are selected, at most `MOST`, in turn from all its planes. A
    surface without a good candidate gets the least bad ones, so that it stays observed.
    """
    of_surface: dict[tuple[str, str], list[int]] = {}
    for number, candidate in enumerate(candidates):
        for room in candidate.rooms:
            of_surface.setdefault((room, candidate.surface), []).append(number)
    rooms: set[tuple[int, str]] = set()
    for (room, _), numbers in of_surface.items():
        verdicts = {number: candidates[number].verdict for number in numbers}
        selected = [number for number in numbers if verdicts[number].good]
        selected = _in_turn(selected, candidates)[:MOST]
        if not selected:
            selected = sorted(numbers, key=lambda number: (verdicts[number].score, number))
            mild = not verdicts[selected[0]].grave
            selected = [number for number in selected if verdicts[number].grave != mild]
            selected = selected[:LAST_RESORT] if mild else _few_of_each(selected, candidates)
        rooms.update((number, room) for number in selected)
    return rooms


def _in_turn(numbers: Sequence[int], candidates: Sequence[Candidate]) -> list[int]:
    """Return the first number of each plane of each photo, then the second, and so on."""
    turn: Counter[tuple[str, int]] = Counter()
    order: list[tuple[int, int]] = []
    for number in numbers:
        plane = candidates[number].photo, candidates[number].plane
        order.append((turn[plane], number))
        turn[plane] += 1
    return [number for _, number in sorted(order)]


def _few_of_each(numbers: Sequence[int], candidates: Sequence[Candidate]) -> list[int]:
    """Return the first `WORST_RESORT` of each photo, so that one photo cannot decide alone."""
    few: dict[str, list[int]] = {}
    for number in numbers:
        few.setdefault(candidates[number].photo, []).append(number)
    return sorted(number for members in few.values() for number in members[:WORST_RESORT])


def write_tables(
    candidates: Sequence[Candidate],
    crops_path: str | Path,
    candidates_path: str | Path,
    *,
    dataset: str,
    house_id: str,
    keep_index: bool = False,
) -> pd.DataFrame:
    """Write both tables, one row per candidate and room; return the crop table.

    The crops keep the order of the candidates, room by room within a photo. The medoid of each
    surface is marked. With `keep_index` the crops keep their candidates' numbers; else they are
    numbered anew within each mask.
    """
    import pandas as pd

    crops = select_candidates(candidates)
    count: Counter[tuple[str, str, int]] = Counter()
    crop_index: dict[int, int] = {}
    for number in sorted({number for number, _ in crops}):
        candidate = candidates[number]
        key = (candidate.photo, candidate.surface, candidate.plane)
        crop_index[number] = candidate.crop.index if keep_index else count[key]
        count[key] += 1
    candidate_rows: list[dict[str, Any]] = []
    crop_rows: list[dict[str, Any]] = []
    images: dict[tuple[str, str], list[tuple[int, np.ndarray]]] = {}
    for _, group in groupby(enumerate(candidates), lambda pair: (pair[1].photo, pair[1].rooms)):
        members = list(group)
        encoded = {
            number: png_bytes(candidate.crop.image)
            for number, candidate in members
            if number in crop_index
        }
        for room, (number, candidate) in product(members[0][1].rooms, members):
            selected = (number, room) in crops
            row = _candidate_row(candidate, room, selected=selected)
            if selected:
                index = crop_index[number]
                name = f"{Path(candidate.photo).stem}_{candidate.plane}_crop{index}"
                row["crop_id"] = f"{candidate.surface}/{name}"
                images.setdefault((room, candidate.surface), []).append(
                    (len(crop_rows), candidate.crop.image)
                )
                pixels = {"png": encoded[number], "detail": candidate.crop.detail}
                crop_rows.append({**row, "index": index, "medoid": False, **pixels})
            candidate_rows.append(row)
    for of_surface in images.values():
        medoid = medoid_index([image for _, image in of_surface])
        crop_rows[of_surface[medoid][0]]["medoid"] = True
    metadata = {"dataset": dataset, "house": house_id}
    crop_table = pd.DataFrame(crop_rows, columns=list(COLUMNS)).astype(COLUMNS)
    write_parquet(crops_path, crop_table, metadata)
    table = pd.DataFrame(candidate_rows, columns=list(CANDIDATE_COLUMNS))
    write_parquet(candidates_path, table.astype(CANDIDATE_COLUMNS), metadata)
    return crop_table


def _candidate_row(candidate: Candidate, room: str, *, selected: bool) -> dict[str, Any]:
    """Return a row of candidates.parquet; its `crop_id` is left empty."""
    crop = candidate.crop
    return {
        "photo": candidate.photo,
        "room_id": room,
        "surface": candidate.surface,
        "plane": candidate.plane,
        "index": crop.index,
        "window": [float(value) for value in crop.window],
        "metres": crop.size_m,
        "sharpness": crop.sharpness,
        "grazing_deg": crop.grazing_deg,
        "reason": reason_text(candidate.verdict, selected=selected),
        "crop_id": "",
        "corners": [float(value) for value in crop.corners],
    }
