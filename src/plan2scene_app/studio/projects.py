"""Projects of the studio: folders whose files ``plan2scene run`` can use as well.

A project holds ``plan.json``, ``photos.csv``, ``photos/``, the picture of its plan, and the results
in ``house/``. ``studio.json`` holds what only the editor needs: the list of photos, the place of
the picture, and the project's title. Every write is atomic; no file of the user is removed.
"""

from __future__ import annotations

import csv
import hashlib
import io
import json
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plan2scene.datasets.assignments import read_rows
from plan2scene.errors import InputError
from plan2scene.house import SurfaceKey
from plan2scene.io import atomic_path, read_json, safe_join, write_json, write_text
from plan2scene.plans.plan_json import FORMAT
from plan2scene_app.check import photo_problem
from plan2scene_app.finishes import check_finish, finishes_file, finishes_text, read_finishes
from plan2scene_app.ids import fit_id

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,59}")
_PHOTO = re.compile(r"(?i).+\.(jpe?g|png|webp|tiff?|bmp|gif|hei[cf]|avif)")
#: Largest number of photos in a project.
MAX_PHOTOS = 500
PLAN, TABLE, EXTRA, PICTURE = "plan.json", "photos.csv", "studio.json", "plan_picture.png"


class Conflict(Exception):  # noqa: N818 - a state, not a fault
    """The project was changed by someone else since it was read."""


@dataclass(frozen=True)
class Project:
    """One project, given by its folder."""

    path: Path

    @property
    def name(self) -> str:
        """The folder's name, which is the house's id."""
        return self.path.name

    @property
    def title(self) -> str:
        """The title that the owner gave it, else its name."""
        name = self._extra().get("name")
        return name if isinstance(name, str) and name else self.name

    @property
    def photos(self) -> Path:
        """The folder of the photos."""
        return self.path / "photos"

    @property
    def house(self) -> Path:
        """The folder of the results."""
        return self.path / "house"

    def revision(self) -> str:
        """Return a hash of the present content of plan, photo table and ``studio.json``."""
        digest = hashlib.sha256()
        for name in (PLAN, TABLE, EXTRA):
            file = self.path / name
            digest.update(file.read_bytes() if file.is_file() else b"-")
            digest.update(b"\0")
        return digest.hexdigest()[:20]

    def state(self) -> dict[str, Any]:
        """Return ``{plan, photos, place, notes, revision}`` in the form of the editor."""
        revision = self.revision()
        extra = self._extra()
        rooms: dict[str, list[str]] = {name: [] for name in extra.get("photos", [])}
        if (self.path / TABLE).is_file():
            for row in read_rows(self.path / TABLE, house_id=self.name):
                rooms.setdefault(row.photo, []).extend([row.room_id] * bool(row.room_id))
        if "photos" not in extra and self.photos.is_dir():
            for file in sorted(self.photos.iterdir()):
                if _PHOTO.fullmatch(file.name):
                    rooms.setdefault(file.name, [])
        plan = read_json(self.path / PLAN) if (self.path / PLAN).is_file() else None
        if plan is not None and not isinstance(plan, dict):
            raise InputError("a plan", "other JSON", file=self.path / PLAN)
        photos = [{"name": name, "rooms": list(dict.fromkeys(r))} for name, r in rooms.items()]
        place = extra.get("place") if (self.path / PICTURE).is_file() else None
        notes = _notes(extra.get("notes", []))
        return {
            "plan": plan,
            "photos": photos,
            "place": place,
            "notes": notes,
            "revision": revision,
        }

    def save(self, state: Mapping[str, Any]) -> str:
        """Write the editor's state; return the new revision.

        Conflict if the files have changed since ``state["revision"]``, InputError if the state does
        not have the editor's form.
        """
        plan, photos, place = (state.get(key) for key in ("plan", "photos", "place"))
        if not isinstance(plan, dict) or plan.get("format") != FORMAT:
            raise InputError(f"a plan of format {FORMAT}", "another")
        rows = _rows(photos)
        if state.get("revision") != self.revision():
            raise Conflict
        extra = self._extra() | {"photos": list(rows), "place": _place(place)}
        extra["notes"] = _notes(state.get("notes", []))
        buffer = io.StringIO()
        writer = csv.writer(buffer, lineterminator="\n")
        writer.writerow(["room_id", "photo"])
        writer.writerows((room, name) for name, rooms in rows.items() for room in rooms or [""])
        for file, text in (
            (PLAN, json.dumps(plan, indent=1, allow_nan=False) + "\n"),
            (TABLE, buffer.getvalue()),
            (EXTRA, json.dumps(extra, indent=1, allow_nan=False) + "\n"),
        ):
            # Snakemake compares times: a file whose content did not change keeps its time.
            if not _has(self.path / file, text):
                write_text(self.path / file, text, flush=True)
        return self.revision()

    def finishes(self) -> list[list[str]]:
        """Return the finishes that the owner has set: rows of room, surface and what."""
        file = finishes_file(self.path / PLAN)
        found = read_finishes(file) if file.is_file() else {}
        return [[*key, what] for key, what in found.items()]

    def finishes_revision(self) -> str:
        """Return a hash of the present file of finishes; empty if there is none."""
        file = finishes_file(self.path / PLAN)
        return hashlib.sha256(file.read_bytes()).hexdigest()[:20] if file.is_file() else ""

    def set_finishes(self, rows: Any) -> None:
        """Write the finishes that the owner chose; InputError for a row that is not valid."""
        chosen = {}
        for row in rows if isinstance(rows, list) else [None]:
            cells = row if isinstance(row, list) else []
            if len(cells) != 3 or not all(isinstance(cell, str) for cell in cells):
                raise InputError("rows of room, surface and what", "others")
            room, surface, what = (cell[:200] for cell in cells)
            check_finish(room, surface, what)
            chosen[SurfaceKey(room, surface)] = what
        write_text(finishes_file(self.path / PLAN), finishes_text(chosen))

    def add_photo(self, name: str, content: bytes) -> None:
        """Store a photo; InputError if it is not valid or another photo has the same name."""
        target = self.photo(name)
        if target.is_file():
            if target.read_bytes() != content:
                raise InputError("a name that no other photo has", name)
            return
        if self.photos.is_dir() and sum(1 for _ in self.photos.iterdir()) >= MAX_PHOTOS:
            raise InputError(f"at most {MAX_PHOTOS} photos", "more")
        with atomic_path(target, flush=True) as temporary:
            temporary.write_bytes(content)
            try:
                photo_problem(temporary)
            except InputError as error:
                raise InputError(error.expected, error.found, file=name) from None

    def photo(self, name: str) -> Path:
        """Return the path of a photo's name; InputError for a name that no photo can have."""
        path = safe_join(self.photos, name)
        if "/" in name or not _PHOTO.fullmatch(name):
            raise InputError(
                "a name of a JPEG, PNG, WebP, TIFF, BMP, GIF, HEIC or AVIF picture", repr(name)
            )
        return path

    def _extra(self) -> dict[str, Any]:
        file = self.path / EXTRA
        extra = read_json(file) if file.is_file() else {}
        names = extra.get("photos", []) if isinstance(extra, dict) else None
        whole = isinstance(names, list) and all(isinstance(name, str) for name in names)
        return extra if whole else {}


def _notes(notes: Any) -> list[str]:
    """Return the doubts of the plan's reading that the user has not dismissed, checked."""
    if not isinstance(notes, list) or not all(isinstance(note, str) for note in notes):
        raise InputError("notes that are texts", "others")
    return [note[:2000] for note in notes[:500]]


class Projects:
    """All projects of a folder."""

    def __init__(self, root: Path) -> None:
        self.root = root.resolve()
        self.root.mkdir(parents=True, exist_ok=True)

    def names(self) -> list[str]:
        """Return the projects' names."""
        folders = (path for path in self.root.iterdir() if path.is_dir() and not path.is_symlink())
        return sorted(path.name for path in folders if _NAME.fullmatch(path.name) and _is(path))

    def get(self, name: str) -> Project:
        """Return a project; InputError if there is none with that name."""
        if name not in self.names():
            raise InputError(f"a home in {self.root}", f"no {name}: was it moved or deleted?")
        return Project(self.root / name)

    def make(self, name: str) -> Project:
        """Make an empty project with the title `name`; its folder's name is an id made from it."""
        title = " ".join(name.encode("utf-8", "replace").decode().split())[:60]
        if not title or any(title == self.get(other).title for other in self.names()):
            raise InputError("a name that no other project has", repr(title))
        stem = folder_name = fit_id(title, "home")
        number = 1
        while os.path.lexists(self.root / folder_name):
            number += 1
            folder_name = f"{stem[:50]}_{number}"
        project = Project(self.root / folder_name)
        project.path.mkdir()
        write_json(project.path / EXTRA, {"photos": [], "place": None, "name": title})
        return project


def _is(path: Path) -> bool:
    return any((path / name).is_file() for name in (PLAN, EXTRA))


def _has(path: Path, text: str) -> bool:
    return path.is_file() and path.read_bytes() == text.encode("utf-8")


def _rows(photos: Any) -> dict[str, list[str]]:
    """Return the rooms of each photo, checked, from the list that the editor sent."""
    if not isinstance(photos, list) or len(photos) > MAX_PHOTOS:
        raise InputError(f"a list of at most {MAX_PHOTOS} photos", "another")
    rows: dict[str, list[str]] = {}
    for photo in photos:
        name, rooms = (photo.get("name"), photo.get("rooms")) if isinstance(photo, dict) else (0, 0)
        if not isinstance(name, str) or not isinstance(rooms, list):
            raise InputError("a name and rooms of each photo", "others")
        safe_join("", name)
        rows[name] = [str(room)[:150] for room in rooms]
    return rows


def _place(place: Any) -> dict[str, Any] | None:
    """Return the place of the picture, checked, and whether two points gave its scale."""
    if not isinstance(place, dict):
        return None
    try:
        numbers = {key: float(place[key]) for key in ("x", "z", "metres_per_pixel", "opacity")}
    except (KeyError, TypeError, ValueError):
        raise InputError("the place of the picture", "another") from None
    numbers["visible"] = bool(place.get("visible"))
    return numbers | ({"measured": True} if place.get("measured") is True else {})
