"""Finishes: materials and colours that an owner sets by hand; they override what photos show.

They are read from ``{plan}.finishes.csv`` beside the plan, with the columns room, surface, what:

- room: the id or name of a room, or ``*`` for all rooms; for a door, the id of its opening. A name
  of several rooms stands for all of them.
- surface: floor, wall, ceiling, ``wall.{id}`` for one accent wall, door, or trim (skirting, frames
  of doors and windows, linings). Doors and trim may only be white or of one colour.
- what: ``white``; a colour such as ``#c8a472``; a name in :data:`LIBRARY`; ``same:{room}`` for
  the texture of that room; ``photo:{name}`` for a texture made from the crops of that photo.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Mapping
from pathlib import Path

from plan2scene.errors import InputError
from plan2scene.house import House, SurfaceKey
from plan2scene.io import read_csv

#: Prefix of the `source` of a texture that is set by hand.
BY_HAND = "set by hand: "
COLUMNS = ["room", "surface", "what"]
SURFACES = ("floor", "wall", "ceiling", "door", "trim")
#: Surfaces that have a colour but no texture.
_PLAIN = ("door", "trim")
_COLOUR = re.compile(r"#[0-9a-fA-F]{6}")
#: Largest size of the table in bytes: a house has at most some hundreds of surfaces.
_MOST = 1_000_000
#: The materials that the owner can choose by name: substance, kind and main colour (sRGB) of each
#: procedural material.
LIBRARY: Mapping[str, tuple[str, str, str]] = {
    "oak planks": ("wood", "planks", "#c8a472"),
    "pale ash planks": ("wood", "planks", "#d8bd94"),
    "walnut planks": ("wood", "planks", "#6b4a32"),
    "oak herringbone": ("wood", "herringbone", "#b98f5e"),
    "white tiles": ("tile", "grid", "#ecebe6"),
    "grey tiles": ("tile", "grid", "#9b9a96"),
    "black and white tiles": ("tile", "checker", "#e8e6e0"),
    "terrazzo": ("tile", "terrazzo", "#d9d4ca"),
    "beige carpet": ("carpet", "cut", "#c9b99f"),
    "grey carpet": ("carpet", "loop", "#8d8c8a"),
    "rough plaster": ("plaster", "plaster", "#e6e1d6"),
    "concrete": ("plaster", "concrete", "#a5a29c"),
}
#: Seeds of materials; another seed than 1 where that gives it another second colour.
SEEDS: Mapping[str, int] = {"black and white tiles": 136}


def finishes_file(plan: str | Path) -> Path:
    """Return the path of a plan's finishes: ``home.finishes.csv`` beside ``home.json``."""
    return Path(plan).with_name(f"{Path(plan).name.split('.')[0]}.finishes.csv")


def read_finishes(path: str | Path, house: House | None = None) -> dict[SurfaceKey, str]:
    """Return the finishes by room and surface; InputError for a row that is not valid.

    With the `house`, rooms are found by their names, too.
    """
    if Path(path).stat().st_size > _MOST:
        raise InputError(f"at most {_MOST} bytes", "more", file=path)
    rows = [row for row in read_csv(path) if any(row)]
    if not rows or [cell.lower() for cell in rows[0]] != COLUMNS:
        found = ", ".join(rows[0]) if rows else "no table"
        raise InputError(f"the columns {', '.join(COLUMNS)}", found, file=path)
    finishes = {}
    for row in rows[1:]:
        if len(row) != len(COLUMNS):
            raise InputError(f"{len(COLUMNS)} cells in each row", str(row), file=path)
        room, surface, what = row
        check_finish(room, surface, what, file=path)
        called = house.rooms_called(room) if house is not None else []
        form, _, other = what.partition(":")
        if house is not None and form == "same" and len(same := house.rooms_called(other)) == 1:
            what = f"same:{same[0].id}"
        for name in [found.id for found in called] or [room]:
            finishes[SurfaceKey(name, surface)] = what
    return finishes


def check_finish(room: str, surface: str, what: str, *, file: object = "") -> None:
    """Raise InputError for an unknown surface, or for a finish that this surface cannot have."""
    kind = surface.partition(".")[0]
    if kind not in SURFACES or not room:
        expected = f"a room and a surface of {', '.join(SURFACES)}"
        raise InputError(expected, repr(surface), file=file, room=room)
    plain = what == "white" or _COLOUR.fullmatch(what) is not None
    other = what in LIBRARY or re.match(r"(same|photo):.", what) is not None
    if not plain and (kind in _PLAIN or not other):
        more = "" if kind in _PLAIN else f", same:ROOM, photo:NAME, {', '.join(LIBRARY)}"
        raise InputError(f"white, a colour such as #c8a472{more}", repr(what), file=file, room=room)


def finishes_text(finishes: Mapping[SurfaceKey, str]) -> str:
    """Return the finishes as the text of their CSV file."""
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(COLUMNS)
    writer.writerows((*key, what) for key, what in sorted(finishes.items()))
    return buffer.getvalue()
