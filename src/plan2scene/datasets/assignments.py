"""Photo assignments: which photo shows which room of a house."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from functools import partial
from pathlib import Path, PurePosixPath
from typing import NamedTuple

from plan2scene.errors import InputError
from plan2scene.house import House
from plan2scene.io import absent, read_csv, safe_join

_log = logging.getLogger("plan2scene")
MAX_ROWS = 10_000  #: Largest number of rows of one house's photo table


class PhotoAssignment(NamedTuple):
    """A row of a photo table: a room and a photo that shows it; a photo may show several rooms."""

    #: Empty if the table gives no room: the places stage then looks for it.
    room_id: str
    photo: str


def read_assignment(
    path: str | Path | None,
    house: House | None = None,
    *,
    house_id: str = "",
    traced: bool = False,
    told: bool = False,
) -> tuple[PhotoAssignment, ...]:
    """Return the rows of a photo table in file order, repeated rows once.

    `path` is a CSV with the columns ``room_id`` (or ``roomId``) and ``photo``; others are ignored.
    A room may be empty, or its whole column missing: the places stage looks for such rooms. A room
    that equals the column ``guess`` counts as empty, too (``photos.csv`` of a run). None, an empty
    file or a table without rows give no rows; :func:`check_assignment` warns of that. With a
    `house` each room must be one of its rooms, by id or by name; without it, `house_id` names the
    house in messages. With `traced` the table may be older than the plan: a room that the plan
    lacks counts as empty, with a warning that says so unless it is `told` already.

    Raises InputError for a missing column, a row without a photo, a room that the plan lacks, a
    photo name with ``..`` or a leading ``/``, or two photos with the same stem (masks are
    ``{stem}.png``).
    """
    name = house.id if house is not None else house_id
    rows = [] if not path else read_rows(path, house_id=name)
    fault = partial(InputError, file=path, house=name)
    kept: dict[PhotoAssignment, None] = {}
    stems: dict[str, str] = {}
    for row in rows:
        called = house.rooms_called(row.room_id) if house is not None and row.room_id else []
        line, found = None, f"{row.room_id!r} for photo {row.photo}"
        if len(called) > 1:
            ids = " or ".join(room.id for room in called)
            found += f", the name of {len(called)} rooms"
            line = fault(f"the id of one room ({ids})", found)
        elif called:
            row = row._replace(room_id=called[0].id)
        elif house is not None and row.room_id:
            known = ", ".join(sorted(room.id for room in house.rooms))
            line = fault(f"a room of the plan ({known[:150]})", found, room=row.room_id)
        if line is not None:
            if not traced:
                raise line
            if not told:
                _log.warning("%s; its room is looked for", line)
            row = row._replace(room_id="")
        safe_join("", row.photo, file=path, house_id=name)
        stem = PurePosixPath(row.photo).stem
        if stems.setdefault(stem, row.photo) != row.photo:
            both = f"{stems[stem]} and {row.photo}"
            raise fault("photo names that differ before the extension", both)
        kept[row] = None
    return tuple(kept)


def read_rows(path: str | Path, *, house_id: str = "") -> list[PhotoAssignment]:
    """Return the rows of a photo table without checking its rooms and photo names."""
    fault = partial(InputError, file=path, house=house_id)
    if not Path(path).is_file():
        raise fault("a photo table", "no such file")
    table = read_csv(path)
    if not any(map(any, table)):
        return []
    header = [cell.lower() for cell in table[0]]
    room = next((header.index(n) for n in ("room_id", "roomid") if n in header), None)
    photo, guess = (header.index(n) if n in header else None for n in ("photo", "guess"))
    misnamed = room is None and any("room" in name for name in header)
    if photo is None or misnamed:
        raise fault("columns room_id and photo", ", ".join(table[0]))
    if len(table) - 1 > MAX_ROWS:
        raise fault(f"at most {MAX_ROWS} rows", str(len(table) - 1))
    rows = []
    for number, cells in enumerate(table[1:], start=2):
        if not any(cells):
            continue
        if not any(cells[photo : photo + 1]):
            raise fault("a photo in each row", f"row {number}: {','.join(cells)}")
        room_cell = "".join(cells[room : room + 1]) if room is not None else ""
        guessed = guess is not None and cells[guess : guess + 1] == [room_cell]
        rows.append(PhotoAssignment("" if guessed else room_cell, cells[photo]))
    return rows


def check_assignment(
    house: House,
    assignments: Sequence[PhotoAssignment],
    photos_dir: str | Path,
    *,
    file: str | Path = "",
) -> list[str]:
    """Return a warning for each fault that does not stop the house: no rows, a missing photo.

    `assignments` are those of :func:`read_assignment` for this house.
    """
    if not assignments:
        return [str(InputError("at least one photo", "none", file=file, house=house.id))]
    warnings: dict[str, None] = {}
    for room_id, photo in assignments:
        path = safe_join(photos_dir, photo, file=file, house_id=house.id)
        if not path.is_file():
            expected = f"photo {photo} in {photos_dir}"
            line = InputError(expected, absent(path), file=file, house=house.id, room=room_id)
            warnings[str(line)] = None
    return list(warnings)


def rooms_of_photos(
    path: str | Path | None, house: House, *, traced: bool = False
) -> dict[str, list[str]]:
    """Return the rooms that each photo shows, in the order of a photo table (`read_assignment`).

    A photo's list is empty if the table gives no room for it.
    """
    rooms: dict[str, list[str]] = {}
    for row in read_assignment(path, house, traced=traced, told=True):
        rooms.setdefault(row.photo, []).extend([row.room_id] if row.room_id else [])
    return rooms
