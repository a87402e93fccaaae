"""The patterns stage: photos, their planes, shared materials -> ``patterns.parquet``."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from plan2scene.house import House
from plan2scene.images import jpeg_bytes
from plan2scene.io import read_parquet, write_parquet
from plan2scene.parallel import each
from plan2scene.photos.patterns.bonds import LAID
from plan2scene.photos.patterns.find import FIND, FoundPattern, Reading, find_pattern, lines_of
from plan2scene.photos.patterns.units import Units, cut_units, unlaid
from plan2scene.photos.patterns.views import (
    FloorView,
    PhotoFiles,
    photos_with_floors,
    with_usual_height,
)

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
    "slant_deg": "float64",
    "joint": "object",
    "joint_m": "float64",
    "confidence": "float64",
    "photos": "str",
    "like": "str",
    "units": "object",
    "shown": "object",
}
#: Rooms of this type seldom share a floor with other rooms, even if both look alike.
_WET = "Bathroom"


def write_patterns(
    files: PhotoFiles,
    plan: House,
    crops: str | Path,
    materials: str | Path,
    output: str | Path,
    *,
    dataset: str,
    looks: Mapping[str, tuple[float, float]],
    threads: int = 1,
) -> pd.DataFrame:
    """Find the patterns of a house's floors; write ``patterns.parquet``.

    Floors of one material (``materials.parquet``) are measured together. A floor without crops
    (``crops.parquet``), or one that is :func:`boarded`, can take a neighbour's pattern. `looks` are
    the probabilities that a room's floor is of wood and of tiles. `threads` photos, then materials,
    are processed at a time.
    """
    import pandas as pd

    table, _ = read_parquet(materials)
    floors = table[table["surface"] == "floor"]
    wet = {room.id for room in plan.rooms if _WET in room.types}
    shared = {
        room: f"{material} wet" if room in wet else material
        for room, material in zip(floors["room_id"], floors["material"], strict=True)
    }
    photos = photos_with_floors(files, house_id=plan.id)
    views = [view for of_photo in each(_views, photos, threads) for view in of_photo]
    found = floor_patterns(with_usual_height(views), shared, looks, threads)
    patterns = {room: pattern for room, (pattern, _) in found.items()}
    pictured, _ = read_parquet(crops)
    seen_rooms = set(pictured.loc[pictured["surface"] == "floor", "room_id"])
    seen_rooms -= {room for room, pattern in patterns.items() if boarded(pattern, looks.get(room))}
    like = continued(plan, seen_rooms, patterns)
    rows = [
        _row(room, *found[like.get(room, room)], like.get(room, ""))
        for room in sorted(found | like)
    ]
    result = pd.DataFrame(rows, columns=list(_COLUMNS)).astype(_COLUMNS)
    write_parquet(output, result, {"dataset": dataset, "house": plan.id})
    for row in result[result["length_m"].notna() | result["direction_deg"].notna()].itertuples():
        size = f"{100 * row.width_m:.1f} x {100 * row.length_m:.1f} cm"
        _log.info("%s: %s %s, confidence %.2f", row.room_id, row.kind, size, row.confidence)
    return result


def _views(read: Callable[[], list[FloorView]]) -> list[FloorView]:
    """Return the floors of a photo, with their lines already computed."""
    views = read()
    for view in views:
        lines_of(view)  # the result is cached in the view
    return views


def floor_patterns(
    views: Sequence[FloorView],
    materials: Mapping[str, str],
    looks: Mapping[str, tuple[float, float]],
    threads: int = 1,
) -> dict[str, tuple[FoundPattern, Units]]:
    """Return the pattern of each room's floor that `views` show, and units cut out of them.

    Rooms of one of the `materials` (room -> name) share a pattern, since single photos have errors
    of scale. If it is plain and a room's own pattern is surer, the room keeps its own. `looks` are
    those of :func:`write_patterns`; `threads` materials are processed at a time.
    """
    by_material: dict[tuple[str, str], list[str]] = {}  # rooms of one material; else a room alone
    for room in sorted({room for view in views for room in view.rooms}):
        name = materials.get(room, "")
        by_material.setdefault((name, "" if name else room), []).append(room)

    def of_material(rooms: list[str]) -> list[tuple[FoundPattern, Units]]:
        name, shared = materials.get(rooms[0], ""), None
        if name:
            members = [view for view in views if any(materials.get(r) == name for r in view.rooms)]
            likely = [looks[room] for room in looks if materials.get(room) == name]
            both = tuple(np.mean(likely, axis=0).tolist()) if likely else None
            whole, readings = find_pattern(members, both)
            shared = whole, _units(whole, readings, members)
        room_patterns = []
        for room in rooms:
            room_views = [view for view in views if room in view.rooms]
            own_pattern, readings = find_pattern(room_views, looks.get(room))
            if shared is None or (
                shared[0].kind == "plain" and shared[0].confidence < own_pattern.confidence
            ):
                room_patterns.append((own_pattern, _units(own_pattern, readings, room_views)))
            else:
                room_patterns.append((_turned(shared[0], own_pattern), shared[1]))
        return room_patterns

    groups = list(by_material.values())
    return {
        room: pattern
        for rooms, room_patterns in zip(groups, each(of_material, groups, threads), strict=True)
        for room, pattern in zip(rooms, room_patterns, strict=True)
    }


def continued(
    plan: House, seen: Collection[str], patterns: Mapping[str, FoundPattern]
) -> dict[str, str]:
    """Return, for each room whose floor continues from a neighbour's, that neighbour.

    Such a room has no clearly `seen` floor, and the known floors of its neighbours all have the
    same pattern of units (`LAID`). It is neither a bathroom nor open to the air. If its own photos
    show a pattern of units, that must be of the same kind; the size is that of the neighbour.
    """
    indoors = {r.id for r in plan.rooms if not r.open_air}
    doors = [pair for pair in plan.adjacency() if indoors.issuperset(pair)]
    laid = {name: pattern for name, pattern in patterns.items() if pattern.kind in LAID}
    neighbour_of_room = {}
    for room in plan.rooms:
        if room.id in seen or room.id not in indoors or _WET in room.types:
            continue
        known = set(seen) if room.id in laid else {*seen, *laid}
        beside = sorted({a if b == room.id else b for a, b in doors if room.id in (a, b)} & known)
        first = laid.get(beside[0]) if beside else None
        if first is None or laid.get(room.id, first).kind != first.kind:
            continue
        if all(name in laid and _same(laid[name], first) for name in beside):
            neighbour_of_room[room.id] = beside[0]
    return neighbour_of_room


def _same(one: FoundPattern, other: FoundPattern) -> bool:
    """Return whether two patterns, measured in different photos, may be the same."""
    alike = abs(np.log(one.width_m / other.width_m)) < 2 * FIND.same_size
    return bool(one.kind == other.kind and alike)


def boarded(pattern: FoundPattern, shares: tuple[float, float] | None) -> bool:
    """Return whether a plain floor probably has boards that its photos are too poor to show.

    `shares` are the probabilities that it is of wood and of tiles, by its looks.
    """
    if shares is None or pattern.kind != "plain":
        return False
    return (1.0 - pattern.confidence) * shares[0] / max(sum(shares), 1e-9) > 0.5


def _units(pattern: FoundPattern, readings: Sequence[Reading], views: Sequence[FloorView]) -> Units:
    """Return the units of a pattern; without readings, only a picture of the largest view."""
    if readings:
        return cut_units(pattern, readings)
    return unlaid(max(views, key=lambda view: view.square_m))


def _turned(whole: FoundPattern, own: FoundPattern) -> FoundPattern:
    """Return a material's pattern for one room, with the room's own direction if that is known."""
    if _same(own, whole) and own.located >= FIND.located:
        return replace(whole, direction_deg=own.direction_deg)
    return whole


def _row(room: str, pattern: FoundPattern, units: Units, like: str) -> dict[str, Any]:
    """Return the row of patterns.parquet for a room's floor."""
    sizes = ("width_m", "width_spread", "length_m", "direction_deg", "offset", "slant_deg")
    return {
        "room_id": room,
        "surface": "floor",
        "kind": pattern.kind,
        **{name: round(getattr(pattern, name), 4) for name in (*sizes, "confidence")},
        "joint": [round(float(value), 4) for value in units.joint],
        "joint_m": round(units.joint_m, 5),
        "photos": "|".join(pattern.photos),
        "like": like,
        "units": [jpeg_bytes(unit, quality=92, full_colour=True) for unit in units.images],
        "shown": jpeg_bytes(units.shown, quality=85),
    }
