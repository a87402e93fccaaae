"""Rooms at eye level before and after: repeated tiles on the left, surface maps on the right.

    python benchmarks/room_pairs.py results/demo docs/pictures/rooms.jpg HOUSE/ROOM...

The tiles are those that the metrics read, with the same light, camera and exposure.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
from pathlib import Path

import numpy as np

from plan2scene.floorplans import read_scene_json
from plan2scene.images import jpeg_bytes
from plan2scene.mesh import build_parts, load_textures
from plan2scene.mesh.eye_level import draw_rooms

METHOD = "exemplar"
GAP = 8


def pair(results: Path, house_id: str, room_id: str) -> np.ndarray:
    """Return one room twice, (h, 2 w + gap, 3) uint8 sRGB."""
    house = read_scene_json(results / "houses" / house_id / "scene.json", house_id)
    parts = build_parts(house)
    folder = results / "drop_0.0" / METHOD / house_id / "textures"
    with tempfile.TemporaryDirectory() as name:
        tiles = Path(name) / "tiles"
        shutil.copytree(folder, tiles, ignore=shutil.ignore_patterns("maps.json"))
        shown = [load_textures(place, house) for place in (tiles, folder)]
    pictures = [draw_rooms(house, textures, parts, [room_id])[0] for textures in shown]
    return np.hstack([pictures[0], np.full((len(pictures[0]), GAP, 3), 255, np.uint8), pictures[1]])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path, help="results/{dataset}")
    parser.add_argument("output", type=Path)
    parser.add_argument("rooms", nargs="+", help="HOUSE/ROOM")
    given = parser.parse_args()
    rows = [pair(given.results, *room.split("/")) for room in given.rooms]
    between = np.full((GAP, rows[0].shape[1], 3), 255, np.uint8)
    sheet = np.vstack([piece for row in rows for piece in (row, between)][:-1])
    given.output.write_bytes(jpeg_bytes(sheet, quality=88))
    print(f"{given.output}: {sheet.shape[1]} x {sheet.shape[0]}")


if __name__ == "__main__":
    main()
