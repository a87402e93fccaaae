"""The patterns stage: photos, their planes, shared materials -> ``patterns.parquet``."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.io import read_parquet, write_parquet
from plan2scene.photos.patterns.find import FIND, FoundPattern, find_pattern
from plan2scene.photos.patterns.views import FloorView, PhotoFiles, floor_views

if TYPE_CHECKING:
    import pandas as pd

_log = logging.getLogger("plan2scene")
#: Columns of patterns.parquet (docs/conventions.md).
_COLUMNS = {
    "room_id": "str",
    "surface": "str",
    "kind": "str",
    "width_m": "float64",
    "width_spread": "float64",
    "length_m": "float64",
    "direction_deg": "float64",
    "offset": "float64",
    "confidence": "float64",
    "photos": "str",
}


def write_patterns(
    files: PhotoFiles, materials: str | Path, output: str | Path, *, dataset: str, house: str
) -> pd.DataFrame:
    """Find the patterns of a house's floors; write ``patterns.parquet``.

    Parameters
    ----------
    files : PhotoFiles
    materials : path
        ``materials.parquet``: floors of one material are read together.
    output : path
    dataset, house : str
        For the metadata and messages.

    Returns
    -------
    pandas.DataFrame
    """
    import pandas as pd

    table, _ = read_parquet(materials)
    floors = table[table["surface"] == "floor"]
    shared = dict(zip(floors["room_id"], floors["material"], strict=True))
    found = floor_patterns(list(floor_views(files, house_id=house)), shared)
    rows = [_row(room, found[room]) for room in sorted(found)]
    result = pd.DataFrame(rows, columns=list(_COLUMNS)).astype(_COLUMNS)
    write_parquet(output, result, {"dataset": dataset, "house": house})
    for row in result[result["kind"] != "plain"].itertuples():
        size = f"{100 * row.width_m:.1f} x {100 * row.length_m:.1f} cm"
        _log.info("%s: %s %s, confidence %.2f", row.room_id, row.kind, size, row.confidence)
    return result


def floor_patterns(
    views: Sequence[FloorView], materials: Mapping[str, str]
) -> dict[str, FoundPattern]:
    """Return the pattern of each room's floor that `views` show.

    Rooms of one material (room -> its name) are read together: photos' scales differ. A room whose
    own photos show something else evidently keeps that.
    """
    rooms = sorted({room for view in views for room in view.rooms})
    together: dict[str, FoundPattern] = {}
    for name in sorted(set(materials.values())):
        members = [view for view in views if any(materials.get(r) == name for r in view.rooms)]
        together[name] = find_pattern(members)
    found = {}
    for room in rooms:
        own = find_pattern([view for view in views if room in view.rooms])
        whole = together.get(materials.get(room, ""))
        found[room] = own if whole is None else _agreed(own, whole)
    return found


def _agreed(own: FoundPattern, whole: FoundPattern) -> FoundPattern:
    """Return a room's pattern, of what its own photos show and those of its material.

    Planks may run another way in each room.
    """
    if whole.confidence < own.confidence and whole.kind == "plain":
        return own
    same = own.kind == whole.kind and abs(np.log(own.width_m / whole.width_m)) < 2 * FIND.same_size
    if same and np.isfinite(own.direction_deg):
        return replace(whole, direction_deg=own.direction_deg)
    return whole


def _row(room: str, pattern: FoundPattern) -> dict[str, Any]:
    """Return a row of patterns.parquet."""
    values = {name: getattr(pattern, name) for name in _COLUMNS if hasattr(pattern, name)}
    for name, value in values.items():
        if isinstance(value, float) and np.isfinite(value):
            values[name] = round(value, 4)
    return {**values, "room_id": room, "surface": "floor", "photos": "|".join(pattern.photos)}
