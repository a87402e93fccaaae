"""What a Rent3D++ copy lacks as a whole; faults of single houses are :mod:`.check`'s."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path, PurePosixPath

from plan2scene.datasets.layout import Layout
from plan2scene.datasets.table import SPLITS, read_unobserved
from plan2scene.errors import InputError
from plan2scene.house import SURFACES

#: Fractions that the paper's table needs.
_TABLE_FRACTIONS = ("0.0", "0.6")
#: Splits whose object boxes the authors hand out.
_BOXED_SPLITS = ("test",)


def missing_parts(layout: Layout, houses: Sequence[dict[str, str]]) -> Iterator[str]:
    """Yield a line for each part that a copy of Rent3D++ has and this one lacks.

    `houses` are the rows of its house table.
    """
    for split in SPLITS:
        file = layout.data / "data_lists" / f"{split}.txt"
        if not file.is_file():
            yield str(InputError("a list of houses", "no such file", file=file))
    if not layout.photos.is_dir():
        yield str(InputError("the folder of photos", "no such folder", file=layout.photos))
    yield from _fractions(layout)
    names = {s: [row["house"] for row in houses if row["split"] == s] for s in SPLITS}
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
    """Yield the line of a folder that lacks the files of `names`, if there are any."""
    if names:
        found = f"{len(names)} lacking, the first {names[0]}"
        yield str(InputError(expected, found, file=folder))


def _fractions(layout: Layout) -> Iterator[str]:
    """Yield what the list of photos to hide lacks."""
    if not layout.unobserved.is_file():
        expected = "the photos to hide at each drop fraction (they are drawn by the seed instead)"
        yield str(InputError(expected, "no such file", file=layout.unobserved))
        return
    try:
        known = read_unobserved(layout.unobserved)
    except InputError:
        return  # the caller's check of that file tells it
    for fraction in _TABLE_FRACTIONS:
        if fraction not in known:
            found = ", ".join(sorted(known)) or "none"
            expected = f"drop fraction {fraction}, which the table needs"
            yield str(InputError(expected, found, file=layout.unobserved))


def _crops(layout: Layout, houses: Sequence[dict[str, str]]) -> Iterator[str]:
    """Yield what ready crops lack: the folder, surfaces, photos that none is of."""
    folder = layout.processed / "surface_crops"
    if layout.surface_crops is None:
        expected = "ready crops (without them crops are sampled from the photos)"
        yield str(InputError(expected, "no such folder", file=folder))
        return
    shown: set[str] = set()
    for surface in SURFACES:
        crops = [path.name for path in (folder / surface).glob("*_crop*.png")]
        shown |= {name.rsplit("_", 2)[0] for name in crops}
        if not crops:
            yield str(InputError(f"crops of a {surface}", "none", file=folder / surface))
    photos = {name for row in houses for name in row["photos"].split("|") if name}
    lacking = sorted(name for name in photos if PurePosixPath(name).stem not in shown)
    yield from _lacking(f"crops of {len(photos)} photos", lacking, folder)
