"""Reads the `index.csv` of folders with data for training photos, and splits its rows."""

from __future__ import annotations

import csv
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TypeVar

from plan2scene.errors import InputError
from plan2scene.materials import Material, load_texture_folder

#: One of this many rows of an index is kept for the splits other than train.
HELD_OUT_EVERY = 8

_Row = TypeVar("_Row")


def index_path(folder: str | Path) -> Path:
    """Return the path of a folder's index."""
    return Path(folder) / "index.csv"


def read_index(
    folder: str | Path, what: str, columns: Collection[str] = ()
) -> list[dict[str, str]]:
    """Return the rows of a folder's index; InputError if it is missing, empty or lacks a column."""
    index = index_path(folder)
    try:
        with index.open(newline="", encoding="utf-8-sig") as handle:
            rows = list(csv.DictReader(handle))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"index.csv of {what}", str(error), file=index) from error
    found = [str(name) for name in rows[0]] if rows else []  # None: cells beyond the columns
    if not rows or not set(columns) <= set(found):
        named = f" of columns {', '.join(sorted(columns))}" if columns else ""
        expected = f"index.csv of {what} with rows{named}"
        raise InputError(expected, ", ".join(found) or "no row", file=index)
    return rows


def of_split(rows: Sequence[_Row], *, train: bool) -> list[_Row]:
    """Return the rows of the train split, or the different rows of the other splits."""
    held = HELD_OUT_EVERY - 1
    return [row for k, row in enumerate(rows) if (k % HELD_OUT_EVERY != held) == train]


def textures_of_split(folder: str | Path, split: str, *, size_px: int = 256) -> list[Material]:
    """Return the textures of a split, which the folder's index (columns id, split) names."""
    rows = read_index(folder, "textures", ("id", "split"))
    names = {f"scan-{row['id']}" for row in rows if row["split"] == split}
    found = [m for m in load_texture_folder(folder, size_px=size_px) if m.name in names]
    if not found:
        raise InputError(f"textures of split {split}", "none", file=folder)
    return found
