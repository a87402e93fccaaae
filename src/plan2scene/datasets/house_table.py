"""What the workflow reads while it builds its job graph: the house table.

Nothing of a house itself is opened here but its photo table, and that only where the house table
is worked out from the data lists; a fault of one house is its own jobs' to report.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TextIO

from plan2scene.datasets.layout import Layout, find_layout
from plan2scene.datasets.table import make_house_table, read_house_rows
from plan2scene.errors import InputError
from plan2scene.io import safe_join


class TableRow(NamedTuple):
    """A house of the table: paths relative to the data set's root, names of photos."""

    house: str
    split: str
    plan: str
    assignment: str
    photos: tuple[str, ...]


def load_houses(
    path: Path,
    *,
    splits: Sequence[str],
    houses: Sequence[str] | None = None,
    may_be_absent: bool = False,
) -> dict[str, TableRow]:
    """Return the rows of the house table by house, only those of `splits`, and of `houses` if any.

    A house that is not among them is an InputError. An absent table is one too, or no rows where
    `may_be_absent` (the data set is yet to be made).
    """
    if not path.is_file() and may_be_absent:
        return {}
    rows = read_house_rows(path)
    chosen = {row["house"]: _table_row(row) for row in rows if row["split"] in splits}
    if not chosen:
        found = f"only {', '.join(sorted({row['split'] for row in rows})) or 'no houses'}"
        raise InputError(f"a house of split {', '.join(splits)}", found, file=path)
    for name in houses or ():
        if name not in chosen:
            found = "no such house"
            raise InputError(f"a house of split {', '.join(splits)}", found, file=path, house=name)
    return chosen if houses is None else {name: chosen[name] for name in houses}


def _table_row(row: Mapping[str, str]) -> TableRow:
    photos = tuple(name for name in row["photos"].split("|") if name)
    return TableRow(row["house"], row["split"], row["plan"], row["assignment"], photos)


def table_of(
    dataset: Mapping[str, Any], results: str | Path, *, make: bool, warn: TextIO | None = None
) -> Path:
    """Return the path of the house table, worked out from the data lists where none is named.

    Raises InputError in one line, where there is no data set under ``dataset.root``.

    Parameters
    ----------
    dataset : mapping
        Section of the configuration.
    results : path
        Folder of this data set's results: a table that is worked out is written here, the data
        set itself is never written to.
    make : bool
        Work it out anew (reads every photo table) though there is one; it is written only when
        it differs.
    warn : text file, optional
        Gets a line of what the table goes on without.
    """
    layout = find_layout(dataset["root"])
    if dataset["table"] is not None:
        return layout.data / dataset["table"]
    path = Path(results) / "houses.tsv"
    if make or not path.is_file():
        architecture = dataset.get("architecture", "bare")
        lines = make_house_table(dataset["root"], path, architecture=architecture)
        if lines and warn is not None:
            more = f" (and {len(lines) - 1} more: plan2scene check)" if len(lines) > 1 else ""
            warn.write(f"plan2scene: warning: {lines[0]}{more}\n")
    return path


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
