"""Results of a run, as the studio shows them and offers them for download."""

from __future__ import annotations

import io
import re
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from plan2scene.errors import InputError
from plan2scene.images import MAX_PHOTO_PIXELS, decode_image, to_small_srgb
from plan2scene_app.exports.registry import export_house
from plan2scene_app.run import DELIVERED, OF_PHOTOS
from plan2scene_app.studio.projects import Project

_TILE = re.compile(r"[A-Za-z0-9_-][A-Za-z0-9_.-]*\.png")
#: Longer side in pixels of a photo's thumbnail.
THUMB = 240


def results_of(project: Project) -> dict[str, Any]:
    """Return ``{files: {name: time}, tiles: [name]}`` of the existing results; times are in ns."""
    times = {}
    for name in (*DELIVERED, *OF_PHOTOS):
        file = project.house / name
        if file.is_file():
            times[name] = file.stat().st_mtime_ns
    folder = project.house / "textures"
    tiles = sorted(path.name for path in folder.glob("*.png")) if folder.is_dir() else []
    return {"files": times, "tiles": [name for name in tiles if _TILE.fullmatch(name)]}


def result_file(project: Project, name: str) -> Path:
    """Return a result's path; InputError if `name` is not a result or the file does not exist."""
    tile = name.removeprefix("textures/")
    is_tile = tile != name and _TILE.fullmatch(tile)
    if name not in (*DELIVERED, *OF_PHOTOS) and not is_tile:
        raise InputError("a result", "another name")
    path = project.house / name
    if not path.is_file() or project.path.resolve() not in path.resolve().parents:
        raise InputError("a result", f"no {name} yet")
    return path


def zipped(project: Project) -> bytes:
    """Return the results as a ZIP archive."""
    results = results_of(project)
    names = [*results["files"], *(f"textures/{name}" for name in results["tiles"])]
    if not names:
        raise InputError("results", "none yet")
    return _archive(project.name, {name: result_file(project, name) for name in names})


def exported(project: Project, form: str) -> tuple[str, bytes]:
    """Export the house in a format of the registry; return the name and content of one file.

    For USD the file is a ``.usdz``, for every other format a ZIP archive.
    """
    scene, textures = result_file(project, "house.scene.json"), project.house / "textures"
    with tempfile.TemporaryDirectory() as folder:
        export_house(scene, textures, folder, form, house_id=project.name)
        package = Path(folder) / "house.usdz"
        if package.is_file():
            return f"{project.name}.usdz", package.read_bytes()
        files = sorted(p for p in Path(folder).rglob("[!.]*") if p.is_file())
        entries = {path.relative_to(folder).as_posix(): path for path in files}
        return f"{project.name}_{form}.zip", _archive(project.name, entries)


def _archive(name: str, files: Mapping[str, Path]) -> bytes:
    """Return a ZIP archive with all files in one folder; the same files give the same bytes."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for entry_name, path in sorted(files.items()):
            entry = zipfile.ZipInfo(f"{name}/{entry_name}", (1980, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, path.read_bytes())
    return buffer.getvalue()


def thumbnail(path: Path, side: int = THUMB) -> bytes:
    """Return a small JPEG of a photo."""
    from PIL import Image

    pixels = decode_image(
        path, lambda image: to_small_srgb(image, side), max_pixels=MAX_PHOTO_PIXELS
    )
    small = Image.fromarray(pixels)
    small.thumbnail((side, side))
    buffer = io.BytesIO()
    small.save(buffer, "JPEG", quality=82)
    return buffer.getvalue()
