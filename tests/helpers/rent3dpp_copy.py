"""A synthetic data set laid out on disk as Rent3D++ is: what its users have, for tests and trials.

Layout: ``docs/rent3dpp.md``. Of the synthetic data set nothing is lost but its truth.
"""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np

from plan2scene.datasets.assignments import read_rows
from plan2scene.house import IconBox, PlacedObject
from plan2scene.io import atomic_path, read_json, read_parquet, write_json
from plan2scene.plans.formats import read_plan
from plan2scene.plans.geometry import room_polygon
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene_app.workflow.house_table import read_table
from plan2scene_workshop.homes.residences import SPLITS

#: Heads of the room column that photo tables in the wild have; houses take turns.
ROOM_HEADERS = ("room_id", "roomId")
#: What is drawn into rooms of a type, with its sides in metres.
ICONS = {
    "Kitchen": ("cooking_counter", 0.6, 1.2),
    "Bathroom": ("toilet", 0.4, 0.7),
    "Bedroom": ("closet", 0.6, 0.6),
}
#: Splits whose object boxes the authors hand out.
_BOXED_SPLITS = ("test",)


def write_rent3dpp_copy(source, target, *, crops=None):
    """Write the houses of a data set (docs/conventions.md) as a Rent3D++ copy; return their names.

    `source` has ``houses.tsv`` and ``unobserved_photos.json``, `target` gets ``input/`` and
    ``processed/``. ``processed/surface_crops/`` is made of ``houses/{house}/crops.parquet`` in
    the results folder `crops`.
    """
    source, target = Path(source), Path(target)
    data, processed = target / "input", target / "processed"
    names: dict[str, list[str]] = {split: [] for split in SPLITS}
    for number, row in enumerate(read_table(source / "houses.tsv").houses.values()):
        house_id, split = row.house, row.split
        names[split].append(house_id)
        house = read_plan(source / row.plan, house_id)
        icons = drawn_icons(house)
        plan = Path(split) / f"{house_id}.scene.json"
        write_scene_json(replace(house, icons=()), data / "archs_no_objects" / plan)
        furnished = replace(house, icons=(), objects=tuple(map(_model, range(len(icons)), icons)))
        write_scene_json(furnished, processed / "full_archs" / plan)
        if split in _BOXED_SPLITS:
            _write_boxes(data / "object_aabbs" / split / f"{house_id}.objectaabb.json", icons)
        _copy_photos(source, data, row, ROOM_HEADERS[number % len(ROOM_HEADERS)])
        if crops is not None:
            _write_crops(Path(crops) / "houses" / house_id / "crops.parquet", processed)
    for split, members in names.items():
        with atomic_path(data / "data_lists" / f"{split}.txt") as temporary:
            temporary.write_text("".join(f"{name}\n" for name in members), encoding="utf-8")
    write_json(data / "unobserved_photos.json", read_json(source / "unobserved_photos.json"))
    return [name for members in names.values() for name in members]


def drawn_icons(house):
    """Return an icon for each room of a type of :data:`ICONS`, within the room's outline."""
    return tuple(
        _icon(room, *ICONS[kind]) for room in house.rooms for kind in room.types if kind in ICONS
    )


def _icon(room, kind, width, depth):
    middle = room_polygon(room).representative_point()
    low = (round(middle.x - width / 2, 3), round(middle.y - depth / 2, 3))
    return IconBox(kind, low, (round(middle.x + width / 2, 3), round(middle.y + depth / 2, 3)))


def _model(index, icon):
    matrix = np.eye(4)
    matrix[:3, 3] = [(icon.p1[0] + icon.p2[0]) / 2, 0.0, (icon.p1[1] + icon.p2[1]) / 2]
    return PlacedObject(f"synthetic.{icon.type}", index, -1, tuple(matrix.T.ravel().tolist()))


def _write_boxes(path, icons):
    objects = [
        {"type": icon.type, "bound_box": {"p1": list(icon.p1), "p2": list(icon.p2)}}
        for icon in icons
    ]
    write_json(path, {"objects": objects})


def _copy_photos(source, data, row, header):
    """Write the photo table of a house under the given head, and copy its photos."""
    (data / "photos").mkdir(parents=True, exist_ok=True)
    for name in row.photos:
        shutil.copy2(source / "photos" / name, data / "photos" / name)
    if not row.assignment:
        return
    rows = read_rows(source / row.assignment, house_id=row.house)
    lines = [f"{header},photo", *(f"{room},{photo}" for room, photo in rows)]
    table = data / "photo_assignments" / row.split / f"{row.house}.photoroom.csv"
    with atomic_path(table) as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _write_crops(table, processed):
    """Write the crops of a house as ``surface_crops/{surface}/{photo}_{mask}_crop{k}.png``."""
    frame, _ = read_parquet(table)
    for crop_id, data in zip(frame["crop_id"], frame["png"], strict=True):
        with atomic_path(processed / "surface_crops" / f"{crop_id}.png") as temporary:
            temporary.write_bytes(data)
