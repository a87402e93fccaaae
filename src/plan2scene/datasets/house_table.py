"""What the workflow reads while it builds its job graph: the house table.

Nothing of a house itself is opened here but its photo table, and that only where the house table
is worked out from the data lists; a fault of one house is its own jobs' to report. Nothing is
written.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NamedTuple

from plan2scene.datasets.layout import Layout, find_layout
from plan2scene.datasets.table import read_house_rows, rows_of_lists
from plan2scene.errors import InputError
from plan2scene.io import safe_join


class TableRow(NamedTuple):
    """A house of the table: paths relative to the data set's root, names of photos."""

    house: str
    split: str
    plan: str
    assignment: str
    photos: tuple[str, ...]


@dataclass(frozen=True)
class HouseTable:
    """The houses of a data set.

    Parameters
    ----------
    file : Path
        The table, or the folder of the data lists that it is worked out from; for messages.
    houses : mapping
        Its rows by house, in their order.
    warnings : tuple of str
        A line for each thing that a table worked out goes on without.
    """

    file: Path
    houses: Mapping[str, TableRow]
    warnings: tuple[str, ...] = ()

    def __getitem__(self, house: str) -> TableRow:
        """Return the row of a house; InputError with the nearest names for one that is not here."""
        if house not in self.houses:
            near = get_close_matches(house, self.houses)
            found = f"no such house, but {', '.join(near)}" if near else "no such house"
            raise InputError("a house of the table", found, file=self.file, house=house)
        return self.houses[house]

    def of_splits(
        self, splits: Sequence[str], houses: Sequence[str] | None = None
    ) -> dict[str, TableRow]:
        """Return the rows of some splits, and only of some `houses` of them where they are named.

        No row, and a house that is not among them, is an InputError.
        """
        chosen = {name: row for name, row in self.houses.items() if row.split in splits}
        expected = f"a house of split {', '.join(splits)}"
        if not chosen:
            found = f"only {', '.join(sorted({row.split for row in self.houses.values()}))}"
            raise InputError(expected, found, file=self.file)
        for name in houses or ():
            if name not in chosen:
                raise InputError(expected, "no such house", file=self.file, house=name)
        return chosen if houses is None else {name: chosen[name] for name in houses}


def read_table(path: Path) -> HouseTable:
    """Return the houses of ``houses.tsv``; InputError as `table.read_house_rows`."""
    return HouseTable(path, _by_house(read_house_rows(path)))


def table_of(dataset: Mapping[str, Any]) -> HouseTable:
    """Return the house table of a data set, worked out from the data lists where none is named.

    `dataset` is that section of the configuration. InputError where there is no data set under
    its ``root``.
    """
    layout = find_layout(dataset["root"])
    if dataset["table"] is not None:
        return read_table(layout.data / dataset["table"])
    rows, warnings = rows_of_lists(dataset["root"], architecture=dataset["architecture"])
    return HouseTable(layout.data / "data_lists", _by_house(rows), tuple(warnings))


def _by_house(rows: Iterable[Mapping[str, str]]) -> dict[str, TableRow]:
    """Return the rows of a table by house."""
    found = {}
    for row in rows:
        photos = tuple(name for name in row["photos"].split("|") if name)
        found[row["house"]] = TableRow(
            row["house"], row["split"], row["plan"], row["assignment"], photos
        )
    return found


def chosen_crops(layout: Layout, crops: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``{"source", "folder"}`` of the section ``crops``, the choice ``auto`` made.

    Ready crops of Rent3D++ are taken where the data set has them (or a folder is named), else
    crops are sampled from the photos.
    """
    source, folder = crops["source"], crops["folder"]
    if source == "sampled":
        return {"source": source, "folder": folder}
    if folder is None and layout.surface_crops is not None:
        folder = str(layout.surface_crops)
    if source == "auto":
        source = "sampled" if folder is None else "precomputed"
    if source == "precomputed" and folder is None:
        expected = "crops.folder, or surface_crops/ with the data set"
        raise InputError(expected, "neither", file=layout.processed)
    return {"source": source, "folder": folder}


def check_official(config: Mapping[str, Any]) -> None:
    """Raise InputError, one line, where ``weights: official`` lacks a checkpoint it needs."""
    if config["weights"] != "official":
        return
    given = config["official"]
    for name in ("texture", "propagation", "naivesynth"):
        # A propagation network knows the embeddings of one texture model only.
        if given[name] is None and name != "naivesynth":
            raise InputError(f"a path for official.{name}", "null", file="configuration")
        _check_file(f"official.{name}", given[name])


def check_metrics(section: Mapping[str, Any]) -> None:
    """Raise InputError, one line, where a network of section ``metrics`` is no file."""
    for name in ("vgg16", "inception"):
        _check_file(f"metrics.{name}", section[name])


def _check_file(name: str, path: str | None) -> None:
    if path is not None and not Path(path).is_file():
        raise InputError(f"a checkpoint ({name})", "no such file", file=path)


def photo_paths(folder: Path, names: Iterable[str]) -> list[Path]:
    """Return the paths of those photos that exist; unsafe names are left out."""
    return [path for name in safe_names(names) if (path := folder / name).is_file()]


def safe_names(names: Iterable[str]) -> list[str]:
    """Return those names of photos that a path can have; of others their house's jobs tell."""
    found = []
    for name in names:
        try:
            safe_join("", name)
        except InputError:
            continue
        found.append(name)
    return found
