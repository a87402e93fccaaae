"""Find the problems of a data set or a plan before anything runs.

For an unpacked copy of Rent3D++, parts that are missing as a whole are reported first.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

from plan2scene.datasets.assignments import check_assignment, read_assignment
from plan2scene.datasets.import_plan import add_object_boxes
from plan2scene.errors import InputError
from plan2scene.house import SURFACES, House
from plan2scene.images import MAX_PHOTO_PIXELS, MAX_PIXELS, check_reducible, decode_image
from plan2scene.io import safe_join
from plan2scene.plans.formats import read_plan
from plan2scene.plans.plan_file import PlanFile
from plan2scene.plans.validate import house_faults, name_oddities, validate_house
from plan2scene_app.panoramas import panorama_of
from plan2scene_app.pdf import page_picture
from plan2scene_app.workflow.drops import read_unobserved
from plan2scene_app.workflow.house_table import SPLITS, TableRow, read_table, table_of_lists
from plan2scene_app.workflow.layout import Layout, find_layout

if TYPE_CHECKING:
    from PIL import Image

#: Drop fractions that the paper's table needs.
_TABLE_FRACTIONS = ("0.0", "0.6")
#: Splits for which the authors distribute object boxes.
_BOXED_SPLITS = ("test",)


def missing_parts(layout: Layout, houses: Sequence[TableRow]) -> Iterator[str]:
    """Yield a line for each part of Rent3D++ that this copy lacks.

    `houses` are the rows of its house table.
    """
    for split in SPLITS:
        file = layout.data / "data_lists" / f"{split}.txt"
        if not file.is_file():
            yield str(InputError("a list of houses", "no such file", file=file))
    if not layout.photos.is_dir():
        yield str(InputError("the folder of photos", "no such folder", file=layout.photos))
    yield from _fractions(layout)
    names = {s: [row.house for row in houses if row.split == s] for s in SPLITS}
    for split in SPLITS:
        folder = layout.plan_folders(split, "full")[0]
        expected = f"plans of {len(names[split])} houses (for dataset.architecture: full only)"
        lacking = [n for n in names[split] if not (folder / f"{n}.scene.json").is_file()]
        yield from _lacking(expected, lacking, folder)
    for split in _BOXED_SPLITS:
        expected = f"object boxes of {len(names[split])} houses (textures don't need them)"
        lacking = [n for n in names[split] if not layout.object_boxes(split, n).is_file()]
        yield from _lacking(expected, lacking, layout.data / "object_aabbs" / split)
    yield from _crops(layout, houses)


def _lacking(expected: str, names: Sequence[str], folder: Path) -> Iterator[str]:
    """Yield one line that says how many files `folder` lacks; none if `names` is empty."""
    if names:
        found = f"{len(names)} lacking, the first {names[0]}"
        yield str(InputError(expected, found, file=folder))


def _fractions(layout: Layout) -> Iterator[str]:
    """Yield a line for each drop fraction that is missing in the list of photos to hide."""
    if not layout.unobserved.is_file():
        expected = "the photos to hide at each drop fraction (they are drawn by the seed instead)"
        yield str(InputError(expected, "no such file", file=layout.unobserved))
        return
    try:
        known = read_unobserved(layout.unobserved)
    except InputError:
        return  # :func:`_check_unobserved` reports this error
    for fraction in _TABLE_FRACTIONS:
        if fraction not in known:
            found = ", ".join(sorted(known)) or "none"
            expected = f"drop fraction {fraction}, which the table needs"
            yield str(InputError(expected, found, file=layout.unobserved))


def _crops(layout: Layout, houses: Sequence[TableRow]) -> Iterator[str]:
    """Yield what is missing of the ready-made crops: the folder, kinds of surface, photos."""
    folder = layout.processed / "surface_crops"
    if layout.surface_crops is None:
        expected = "ready crops (without them crops are sampled from the photos)"
        yield str(InputError(expected, "no such folder", file=folder))
        return
    cropped: set[str] = set()
    for surface in SURFACES:
        crops = [path.name for path in (folder / surface).glob("*_crop*.png")]
        cropped |= {name.rsplit("_", 2)[0] for name in crops}
        if not crops:
            yield str(InputError(f"crops of a {surface}", "none", file=folder / surface))
    photos = {name for row in houses for name in row.photos}
    lacking = sorted(name for name in photos if PurePosixPath(name).stem not in cropped)
    yield from _lacking(f"crops of {len(photos)} photos", lacking, folder)


#: Number of last bytes in which a JPEG's end marker is searched (some cameras append data).
_JPEG_TAIL = 65_536


@dataclass(frozen=True)
class Problem:
    """One line about an input: an `error` stops its house, a `warning` doesn't."""

    level: str  # "error" or "warning"
    line: str

    def __str__(self) -> str:
        return f"{self.level}: {self.line}"


def _warnings(lines: Iterable[str]) -> list[Problem]:
    return [Problem("warning", line) for line in lines]


def check_plan(
    path: str | Path,
    house_id: str,
    metres_per_pixel: float | None = None,
    dxf_layers: Mapping[str, str] | None = None,
) -> tuple[House | None, list[Problem]]:
    """Return the house of a plan (None if it has an error) and every problem found.

    A plan that is a picture gives None and a warning: it has no house before it is traced.
    """
    plan = PlanFile(Path(path), house_id)
    try:
        if plan.path.is_file() and plan.is_picture:
            decode_image(
                path,
                _verified_format,
                house_id=house_id,
                max_pixels=MAX_PHOTO_PIXELS,
                page_of=page_picture(),
            )
            expected = "a plan with rooms (plan2scene trace shows what is read of a picture)"
            return None, _warnings([str(plan.fault(expected, plan.binary))])
        house = read_plan(path, house_id, metres_per_pixel, dxf_layers)
        faults = [Problem("error", str(fault)) for fault in house_faults(house, file=path)]
        if faults:
            return None, [*_warnings(house.warnings), *faults]
        return house, _warnings(validate_house(house, file=path))
    except InputError as error:
        return None, [Problem("error", str(error))]


def check_dataset(
    root: str | Path,
    *,
    table: str = "houses.tsv",
    metres_per_pixel: float | None = None,
    dxf_layers: Mapping[str, str] | None = None,
) -> list[Problem]:
    """Return the problems of a data set (docs/conventions.md): table, plans, assignments, photos.

    If the house table is missing, its rows are derived from the data lists (nothing is written to
    `root`). For an unpacked copy of Rent3D++, parts that are missing as a whole come first.
    """
    layout = find_layout(root)
    problems: list[Problem] = []
    try:
        if (layout.data / table).is_file():
            houses = read_table(layout.data / table)
        else:
            houses = table_of_lists(root)
            # An unpacked copy of Rent3D++ never has the table: do not mention that it is missing.
            note = "" if layout.is_rent3dpp else f"no {table}; "
            problems += _warnings(note + line for line in houses.warnings)
    except InputError as error:
        return [Problem("error", str(error))]
    rows = list(houses.houses.values())
    if layout.is_rent3dpp:
        problems += _warnings(missing_parts(layout, rows))
    for expected, found, house_id in name_oddities("house names", [row.house for row in rows]):
        fault = InputError(expected, found, file=layout.data / table, house=house_id)
        problems.append(Problem("warning", str(fault)))
    listed_photos: set[str] = set()
    checked: set[str] = set()
    for row in rows:
        listed_photos |= set(row.photos)
        plan = check_plan(layout.root / row.plan, row.house, metres_per_pixel, dxf_layers)
        problems += _check_house(layout, layout.data / table, row, plan, checked)
    problems += _check_unobserved(layout.unobserved, listed_photos)
    return problems


def _check_house(
    layout: Layout,
    table: Path,
    row: TableRow,
    plan: tuple[House | None, list[Problem]],
    checked: set[str],
) -> Iterator[Problem]:
    """Yield the problems of one house, beginning with those of its plan.

    Photos in `checked` were opened before and are not opened again; new ones are added to it.
    """
    house_id, names = row.house, set(row.photos)
    house, problems = plan
    yield from problems
    if house is not None and (boxes := layout.object_boxes(row.split, house_id)).is_file():
        yield from _warnings(add_object_boxes(house, boxes)[1])
    file = layout.root / row.assignment if row.assignment else None
    try:
        rows = read_assignment(file, house, house_id=house_id)
        if house is not None:
            yield from _warnings(check_assignment(house, rows, layout.photos, file=file or ""))
    except InputError as error:
        yield Problem("error", str(error))
        rows = ()
    for photo in sorted({row.photo for row in rows} - names):
        found = f"{photo}, which the house table doesn't list"
        fault = InputError("photos of the house table", found, file=file or "", house=house_id)
        yield Problem("warning", str(fault))
    assigned = {row.photo for row in rows}
    for photo in sorted(names):
        try:
            path = safe_join(layout.photos, photo, file=table, house_id=house_id)
        except InputError as error:
            yield Problem("error", str(error))
            continue
        if photo in checked or (photo in assigned and not path.is_file()):
            continue
        checked.add(photo)
        try:
            photo_problem(path, house_id=house_id)
            if panorama_of(path) is not None:
                expected = "a flat photo (plan2scene views cuts others)"
                raise InputError(expected, "a 360-degree one", file=path, house=house_id)
        except InputError as error:
            # Only a warning: the masks stage leaves the photo out, and the house is still made.
            yield Problem("warning", str(error))


def _check_unobserved(path: Path, known: set[str]) -> Iterator[Problem]:
    """Yield what is wrong with the list of photos to hide."""
    if not path.is_file():
        return
    try:
        table = read_unobserved(path)
    except InputError as error:
        yield Problem("error", str(error))
        return
    unknown = sorted({name for names in table.values() for name in names} - known)
    if unknown:
        found = f"{len(unknown)} others, the first {unknown[0]}"
        yield Problem("warning", str(InputError("photos of the house table", found, file=path)))


def photo_problem(path: str | Path, *, house_id: str = "") -> None:
    """Raise InputError for a photo that cannot be opened: not an image, too large or cut short.

    Only the header is decoded. A JPEG must have its end marker; a PNG's checksums are verified.
    Damage inside a JPEG is found only when a stage decodes it.
    """
    kind = decode_image(path, _verified_format, house_id=house_id, max_pixels=MAX_PHOTO_PIXELS)
    if kind == "JPEG":
        with Path(path).open("rb") as file:
            file.seek(max(0, Path(path).stat().st_size - _JPEG_TAIL))
            if b"\xff\xd9" not in file.read():
                found = "one cut short (no end marker)"
                raise InputError("a whole JPEG", found, file=path, house=house_id)


def _verified_format(image: Image.Image) -> str:
    """Return the name of an opened image's format, after verifying the checksums of a PNG.

    ValueError for an image that is so large that it must be reduced, but whose mode prevents that.
    """
    if image.width * image.height > MAX_PIXELS:
        check_reducible(image)
    if image.format == "PNG":
        image.verify()
    return image.format or ""
