"""Renders photos of an existing plan with one or more storeys; the examples' photos come from it.

``python -m plan2scene_workshop.homes.plan_photos PLAN FOLDER ROOM...`` writes ``FOLDER/photos/``
and ``FOLDER/photos.csv``; a room that is named twice gets two photos.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from plan2scene.io import atomic_path
from plan2scene.plans.formats import read_plan
from plan2scene.seeds import derive_seed
from plan2scene_workshop.homes.residences import write_assignment
from plan2scene_workshop.homes.style import assign_materials
from plan2scene_workshop.rendering import encode_jpeg, plan_views, render_house

#: Height and width of the photos in pixels, their JPEG quality, and light paths per pixel.
SIZE, QUALITY, SAMPLES = (720, 960), 85, 24


def photograph_plan(plan: str | Path, folder: str | Path, rooms: Sequence[str], seed: int) -> None:
    """Write photos of the named rooms, and their table; materials are drawn for the plan.

    Each storey is rendered alone: photos show only rooms of the same storey, and no stairs between
    storeys. The same seed gives the same bytes.
    """
    house = read_plan(plan, Path(plan).parent.name)
    materials = assign_materials(house, derive_seed(seed, "style"))
    out = Path(folder)
    (out / "photos").mkdir(parents=True, exist_ok=True)
    table: list[tuple[str, str]] = []
    for _, storey in house.storeys():
        wanted = Counter(room for room in rooms if room in {r.id for r in storey.rooms})
        views = [
            view
            for room, count in wanted.items()
            for view in plan_views(storey, [room], count, derive_seed(seed, "views"))
        ]
        photos = render_house(
            storey,
            materials,
            {},
            views,
            derive_seed(seed, "render"),
            height=SIZE[0],
            width=SIZE[1],
            samples_per_pixel=SAMPLES,
        )
        for photo in photos:
            room = photo.view.room_id
            name = f"{room}_{sum(row[0] == room for row in table)}.jpg"
            with atomic_path(out / "photos" / name) as temporary:
                temporary.write_bytes(encode_jpeg(photo.image, QUALITY))
            table.append((room, name))
    write_assignment(out / "photos.csv", table)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("plan")
    parser.add_argument("folder")
    parser.add_argument("rooms", nargs="+")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    photograph_plan(given.plan, given.folder, given.rooms, given.seed)
