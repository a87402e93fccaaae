"""Where the parts of a data set lie on disk: in our layout, or in an unpacked copy of Rent3D++."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from plan2scene.errors import InputError

#: Folders of a Rent3D++ copy that may hold its ``data_lists/``, in the order of the search.
_INPUT_FOLDERS = ("input", "data/input")


@dataclass(frozen=True)
class Layout:
    """The folders of one data set; paths in the house table are relative to `root`.

    `data`, which is `root` or a folder in it, holds ``data_lists/``, ``archs_no_objects/``,
    ``photo_assignments/``, ``photos/``, ``object_aabbs/`` and ``unobserved_photos.json``.
    `processed` holds ``full_archs/`` and ``surface_crops/``; it need not exist.
    """

    root: Path
    data: Path
    processed: Path

    @property
    def is_rent3dpp(self) -> bool:
        """Whether it is a copy of Rent3D++ as unpacked (``input/`` beside ``processed/``)."""
        return self.data != self.root

    @property
    def photos(self) -> Path:
        """Folder of the photos."""
        return self.data / "photos"

    @property
    def unobserved(self) -> Path:
        """The list of photos to hide; need not exist."""
        return self.data / "unobserved_photos.json"

    @property
    def surface_crops(self) -> Path | None:
        """Folder of ready crops, None where there is none."""
        folder = self.processed / "surface_crops"
        return folder if folder.is_dir() else None

    def plan_folders(self, split: str, architecture: str) -> list[Path]:
        """Return the folders where the plans of a split may lie, the wanted architecture first.

        `architecture` is ``bare`` (rooms only) or ``full`` (with object models placed in them).
        """
        bare = [self.data / "archs_no_objects" / split]
        full = [self.processed / "full_archs" / split, self.data / "full_archs" / split]
        return [*full, *bare] if architecture == "full" else [*bare, *full]

    def assignment(self, split: str, house_id: str) -> Path:
        """Return the path of a house's photo table, which need not exist."""
        return self.data / "photo_assignments" / split / f"{house_id}.photoroom.csv"

    def object_boxes(self, split: str, house_id: str) -> Path:
        """Return the path of a house's object boxes, which need not exist."""
        return self.data / "object_aabbs" / split / f"{house_id}.objectaabb.json"

    def relative(self, path: Path) -> str:
        """Return a path as it is written in the house table, relative to `root`."""
        return path.relative_to(self.root).as_posix()


def find_layout(root: str | Path) -> Layout:
    """Return the layout of a data set, recognised by the place of its ``data_lists/``.

    `root` is a folder in our own layout (docs/conventions.md), or one of these folders of a
    Rent3D++ copy: the folder that contains ``input/`` and ``processed/``, the folder that contains
    ``data/``, or ``input/`` itself. Any other folder is treated as our own layout; later code
    reports what is missing.
    """
    root = Path(root)
    if (root / "data_lists").is_dir() or (root / "houses.tsv").is_file():
        absolute = root.absolute()
        if absolute.name == "input" and (absolute.parent / "processed").is_dir():
            return Layout(root.parent, root, root.parent / "processed")
        return Layout(root, root, root / "processed")
    for name in _INPUT_FOLDERS:
        data = root / name
        if (data / "data_lists").is_dir():
            return Layout(root, data, data.parent / "processed")
    return Layout(root, root, root / "processed")


def require_data_set(root: str | Path) -> Layout:
    """Return the layout of a data set that has data lists; InputError if there is none."""
    layout = find_layout(root)
    if layout.is_rent3dpp or (layout.data / "data_lists").is_dir():
        return layout
    found = "none of these" if Path(root).is_dir() else "no such folder"
    expected = "a Rent3D++ copy (data_lists/ in it, in its input/ or in its data/input/)"
    raise InputError(expected, found, file=root)
