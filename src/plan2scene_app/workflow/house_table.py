"""The house table, which decides the job graph: ``houses.tsv``, or made from the data lists.

Of a house's own files only its photo table is opened here, and only if the house table is made from
the data lists. Faults of one house are reported by its own jobs.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

from plan2scene.datasets.assignments import read_rows
from plan2scene.errors import InputError
from plan2scene.house import MAX_ID_LENGTH
from plan2scene.io import read_text, safe_join
from plan2scene_app.workflow.layout import Layout, require_data_set

COLUMNS = ("house", "split", "plan", "assignment", "photos")
SPLITS = ("train", "val", "test")
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")


class TableRow(NamedTuple):
    """A house of the table: paths, relative to the data set's root, and names of photos."""

    house: str
    split: str
    plan: str
    assignment: str  #: empty for none
    photos: tuple[str, ...]


@dataclass(frozen=True)
class HouseTable:
    """The houses of a data set."""

    file: Path  #: the table's file, or the folder of the data lists
    houses: Mapping[str, TableRow]  #: rows by house, in their order
    warnings: tuple[str, ...] = ()  #: of a table made from data lists: faults of houses

    def __getitem__(self, house: str) -> TableRow:
        """Return the row of a house; InputError with the most similar names if there is none."""
        if house not in self.houses:
            near = get_close_matches(house, self.houses)
            found = f"no such house, but {', '.join(near)}" if near else "no such house"
            raise InputError("a house of the table", found, file=self.file, house=house)
        return self.houses[house]

    def of_splits(
        self, splits: Sequence[str], houses: Sequence[str] | None = None
    ) -> dict[str, TableRow]:
        """Return the rows of some splits; if `houses` are given, only the rows of these.

        InputError if there is no row, or one of `houses` is not in the splits.
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
    """Return the houses of ``houses.tsv``.

    Columns ``house, split, plan, assignment, photos`` (docs/conventions.md); `assignment` and
    `photos` may be empty. Photo names are not checked here: the house's jobs report a bad one.

    Raises InputError for missing or unknown columns, no rows, a repeated house, an unknown split, a
    house name that cannot name a folder, a plan or assignment path that leaves the data set.
    """
    lines = [line for line in read_text(path).splitlines() if line.strip()]
    header = tuple(lines[0].split("\t")) if lines else ()
    if sorted(header) != sorted(COLUMNS):
        expected = f"the columns {', '.join(COLUMNS)} separated by tabs"
        raise InputError(expected, ", ".join(header) or "an empty file", file=path)
    houses: dict[str, TableRow] = {}
    for number, line in enumerate(lines[1:], start=2):
        cells = [cell.strip() for cell in line.split("\t")]
        if len(cells) > len(header):
            found = f"{len(cells)} in row {number}"
            raise InputError(f"{len(header)} cells in each row", found, file=path)
        named = dict(zip_longest(header, cells, fillvalue=""))
        house, split, plan, assignment, photos = (named[name] for name in COLUMNS)
        names = tuple(name for name in photos.split("|") if name)
        row = TableRow(house, split, plan, assignment, names)
        _check_row(row, houses, path)
        houses[row.house] = row
    if not houses:
        raise InputError("at least one house", "none", file=path)
    return HouseTable(path, houses)


def _check_row(row: TableRow, others: Collection[str], path: Path) -> None:
    """Raise InputError if a row cannot become jobs, or its house is already in `others`."""
    name = row.house
    if len(name) > MAX_ID_LENGTH or not _NAME.fullmatch(name):
        expected = f"a house name of letters, digits, '_', '-', '.', at most {MAX_ID_LENGTH}"
        raise InputError(expected, repr(name), file=path)
    if name in others:
        raise InputError("each house once", f"{name} twice", file=path, house=name)
    if row.split not in SPLITS:
        raise InputError(f"a split ({', '.join(SPLITS)})", row.split, file=path, house=name)
    safe_join("", row.plan, file=path, house_id=name)
    if row.assignment:
        safe_join("", row.assignment, file=path, house_id=name)


def table_of_lists(root: str | Path, *, architecture: str = "bare") -> HouseTable:
    """Return the house table of a data set in the Rent3D++ layout, made from its data lists.

    `root` is as for :func:`.layout.find_layout`. `architecture`, ``bare`` or ``full``, says which
    plan is taken if a house has both.

    Raises InputError for no data lists, no houses in them, or a house in two of them. A missing
    plan or a bad photo table is only a warning here; the house's own jobs report it.
    """
    layout = require_data_set(root)
    warnings: list[str] = []
    houses: dict[str, TableRow] = {}
    folder = layout.data / "data_lists"
    lists = [(split, folder / f"{split}.txt") for split in SPLITS]
    if not any(file.is_file() for _, file in lists):
        raise InputError("train.txt, val.txt or test.txt", "none", file=folder)
    for split, file in lists:
        for name in read_text(file).split() if file.is_file() else []:
            row = _row(layout, split, name, architecture, warnings)
            _check_row(row, houses, file)
            houses[name] = row
    if not houses:
        raise InputError("at least one house", "none", file=folder)
    return HouseTable(folder, houses, tuple(warnings))


def _row(
    layout: Layout, split: str, house_id: str, architecture: str, warnings: list[str]
) -> TableRow:
    """Return the row of a house."""
    folders = layout.plan_folders(split, architecture)
    plans = [folder / f"{house_id}.scene.json" for folder in folders]
    plan = next((path for path in plans if path.is_file()), None)
    if plan is None:
        plan = plans[0]
        warnings.append(str(InputError("a plan", "no such file", file=plan, house=house_id)))
    elif architecture == "full" and plan.parent.parent.name != "full_archs":
        expected = f"{house_id}.scene.json in {folders[0]}"
        line = InputError(expected, f"only {plan}", file=layout.root, house=house_id)
        warnings.append(str(line))
    assignment = layout.assignment(split, house_id)
    photos: list[str] = []
    if assignment.is_file():
        try:
            for _, photo in read_rows(assignment, house_id=house_id):
                safe_join("", photo, file=assignment, house_id=house_id)
                photos.append(photo)
        except InputError as error:
            warnings.append(str(error))
    named = layout.relative(assignment) if assignment.is_file() else ""
    return TableRow(house_id, split, layout.relative(plan), named, tuple(dict.fromkeys(photos)))
