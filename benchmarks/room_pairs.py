"""Draw rooms at eye level before and after, in pairs from the same position.

    python benchmarks/room_pairs.py results/demo docs/pictures/rooms.jpg HOUSE/ROOM...
    python benchmarks/room_pairs.py results/demo docs/pictures/surfaces.jpg --lit HOUSE/ROOM...

The right picture (after) is like those of a house's `rooms.jpg`. The left one (before) is like the
first version's house: repeated tiles (those that the metrics read), no light, and only floors,
walls, ceilings, doors and windows. With `--lit` only the tiles differ. The first argument may also
be OUT of `plan2scene run`: `python benchmarks/room_pairs.py OUT pairs.jpg ROOM...`.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
from pathlib import Path

import numpy as np

from plan2scene.images import jpeg_bytes
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.rays import Rays
from plan2scene.mesh.texture_files import load_textures
from plan2scene.plans.scene_json import read_scene_json
from plan2scene_app.pictures.baked_light import even_light
from plan2scene_app.pictures.lit_picture import painter_of
from plan2scene_app.pictures.room_views import camera_in

METHOD = "exemplar"
GAP = 8
#: Kinds of parts that the first version did not have.
LATER = frozenset({"skirting", "object", "railing", "stairs"})


def files(results: Path, house_id: str) -> tuple[Path, Path]:
    """Return the paths of a house's scene.json and textures, in a data set or a single house."""
    if not house_id:
        return results / "house.scene.json", results / "textures"
    textures = results / "drop_0.0" / METHOD / house_id / "textures"
    return results / "houses" / house_id / "scene.json", textures


def pair(results: Path, house_id: str, room_id: str, *, lit: bool) -> np.ndarray:
    """Return the pair of pictures of one room, (h, 2 w + gap, 3) uint8 sRGB."""
    scene, folder = files(results, house_id)
    house = read_scene_json(scene, house_id or "house")
    parts = assemble(house).parts
    with tempfile.TemporaryDirectory() as name:
        tiles = Path(name) / "tiles"
        shutil.copytree(folder, tiles, ignore=shutil.ignore_patterns("maps.json"))
        repeated, whole = (load_textures(place, house) for place in (tiles, folder))
    camera = camera_in(house, room_id, Rays.of(parts))
    after = painter_of(house, whole, parts)(camera)
    if lit:
        before = painter_of(house, repeated, parts)(camera)
    else:
        first = [part for part in parts if part.extras["kind"] not in LATER]
        before = painter_of(house, repeated, first, light=even_light())(camera)
    return np.hstack([before, np.full((len(before), GAP, 3), 255, np.uint8), after])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="results/{dataset}, or OUT of plan2scene run")
    parser.add_argument("output", type=Path)
    parser.add_argument("rooms", nargs="+", help="HOUSE/ROOM, or ROOM of one house")
    parser.add_argument("--lit", action="store_true", help="the same light and things before")
    given = parser.parse_args()
    names = [("/" + name).rsplit("/", 1) for name in given.rooms]
    rows = [pair(given.results, house.strip("/"), room, lit=given.lit) for house, room in names]
    between = np.full((GAP, rows[0].shape[1], 3), 255, np.uint8)
    sheet = np.vstack([piece for row in rows for piece in (row, between)][:-1])
    given.output.write_bytes(jpeg_bytes(sheet, quality=88))
    print(f"{given.output}: {sheet.shape[1]} x {sheet.shape[0]}")


if __name__ == "__main__":
    main()
