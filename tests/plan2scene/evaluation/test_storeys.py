"""Houses of several storeys in the evaluation: figures, and what the user study shows."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from plan2scene.evaluation.houses import propagated_at
from plan2scene.house import Level, Stairs
from plan2scene.images import write_png
from plan2scene.io import read_parquet, write_json
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene.plans.validate import house_faults
from plan2scene.textures.inputs import Visible
from plan2scene_app.study import study_sheet

HIDDEN = {"0.0": [], "0.6": ["p3.jpg"]}
UPSTAIRS = {"bath", "loft"}


@pytest.fixture
def stacked(plan):
    """The house of four rooms with the last two upstairs; stairs in the place of a door."""
    rooms = tuple(replace(r, level="up" if r.id in UPSTAIRS else "low") for r in plan.rooms)
    stairs = Stairs("s", "low", (3.5, 1.5), (6.5, 1.5), 0.9, ("hall", "bath"))
    return replace(
        plan,
        rooms=rooms,
        walls=tuple(wall for wall in plan.walls if "bath" not in wall.room_ids),
        doors=tuple(door for door in plan.doors if door.room_b != "bath"),
        levels=(Level("low", "Low", 0.0, 2.5), Level("up", "Up", 2.8, 2.5)),
        stairs=(stairs,),
    )


def measured(house, embeddings, compare, folder):
    """Return the rows of ``metrics.parquet`` of a house by two methods at two drops."""
    drops = {}
    for drop, hidden in HIDDEN.items():
        (folder / drop).mkdir(parents=True)
        drops[drop] = Visible(propagated_at(house, embeddings, hidden, folder / drop)[1], hidden)
    return read_parquet(compare(house, drops, ("crop", "synth"), folder / "tiles"))[0]


def test_stairs_join_rooms_as_doors_do(house, embeddings, compare, stacked, tmp_path):
    write_scene_json(stacked, tmp_path / "scene.json")
    read = read_scene_json(tmp_path / "scene.json", "h1")
    assert list(house_faults(read)) == [] and len(read.levels) == 2
    high = replace(house, files=replace(house.files, scene=tmp_path / "scene.json"))
    flat, storeys = (
        measured(one, embeddings, compare, tmp_path / name)
        for one, name in ((house, "flat"), (high, "storeys"))
    )
    columns = ["method", "drop", "room_id", "surface", "observed", "color", "freq", "tile", "subs"]
    assert storeys[columns].values.tolist() == flat[columns].values.tolist()
    upstairs = storeys[storeys["room_id"] == "bath"]
    assert dict(zip(upstairs["drop"], upstairs["observed"], strict=True)) == {
        "0.0": True,
        "0.6": False,
    }
    assert np.isfinite(storeys["color"]).all()


def test_a_sheet_of_the_study_shows_every_storey(storey_house, tmp_path, monkeypatch):
    monkeypatch.setattr(study_sheet, "RENDER_SIDE", 240)
    levels = {"ground": 60, "upper": 200}
    entries = {}
    for key in storey_house.surface_keys():
        grey = levels[storey_house.room(key.room_id).level]
        write_png(tmp_path / "x" / f"{key.filename}.png", np.full((8, 8, 3), grey, np.uint8))
        entries[f"{key.room_id}/{key.surface}"] = {"size_m": 1.0}
    write_json(tmp_path / "x" / "textures.json", {"surfaces": entries})
    study_sheet.write_study_sheet(
        tmp_path / "sheet",
        house=storey_house,
        photos={},
        rooms_of_photo={},
        textures={"x": tmp_path / "x"},
    )
    plan, seen = (
        np.asarray(Image.open(tmp_path / "sheet" / f"{name}.jpg")).astype(int)
        for name in ("plan", "x")
    )
    assert [image.shape[0] / image.shape[1] for image in (plan, seen)] == [2.0, 2.0]
    side = seen.shape[1]
    below, above = (seen[k * side + 75 : k * side + 105, 100:165].mean() for k in (0, 1))
    assert below < 90 < 150 < above
