"""What the workflow reads while it builds its job graph: the house table and hidden photos.

Nothing of a house itself is opened here; a fault of one house is its own jobs' to report.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from plan2scene.datasets import read_house_table, read_unobserved
from plan2scene.errors import InputError
from plan2scene.io import safe_join
from plan2scene.seeds import generator

if TYPE_CHECKING:
    import pandas as pd


def load_houses(path: Path, *, splits: Sequence[str], may_be_absent: bool = False) -> pd.DataFrame:
    """Return the house table indexed by ``house``, only the rows of `splits`.

    Columns ``house, split, plan, assignment, photos``, all str. An absent table is an
    InputError, or an empty table where `may_be_absent` (the data set is yet to be made).
    """
    import pandas as pd

    if not path.is_file() and may_be_absent:
        columns = ["split", "plan", "assignment", "photos"]
        return pd.DataFrame({name: pd.Series(dtype=str) for name in columns}).rename_axis("house")
    table = read_house_table(path)
    chosen = table[table["split"].isin(list(splits))]
    if chosen.empty:
        raise InputError(
            f"a house of split {', '.join(splits)}",
            f"only {', '.join(sorted(set(table['split']))) or 'no houses'}",
            file=path,
        )
    return chosen if chosen.index.name == "house" else chosen.set_index("house")


def photo_paths(folder: Path, names: Iterable[str]) -> list[Path]:
    """Return the paths of those photos that exist; unsafe names are left out."""
    found = []
    for name in names:
        try:
            path = safe_join(folder, name)
        except InputError:
            continue
        if path.is_file():
            found.append(path)
    return found


def hidden_photo_names(
    path: Path, drop: str, photos: Sequence[str], *, seed: int, house: str
) -> list[str]:
    """Return the photos of one house that are hidden at drop fraction `drop` (``"0.6"``), sorted.

    From ``unobserved_photos.json`` when the data set has one with that fraction, else that share
    of the house's photos by a seeded order (nested: what 0.2 hides, 0.4 hides too).
    """
    fraction = float(drop)
    if fraction == 0.0:
        return []
    if path.is_file():
        table = read_unobserved(path)
        if drop not in table:
            raise InputError(f"fraction {drop}", f"only {', '.join(sorted(table))}", file=path)
        return sorted(set(photos) & set(table[drop]))
    order = generator(seed, "hidden_photos", house).permutation(len(photos))
    count = round(fraction * len(photos))
    names = sorted(photos)
    return sorted(names[i] for i in order[:count])
