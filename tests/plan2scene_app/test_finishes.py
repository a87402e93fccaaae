import filecmp
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from places import PLAN

from plan2scene.colour import median_colour
from plan2scene.errors import InputError
from plan2scene.house import SurfaceKey
from plan2scene.images import jpeg_bytes, png_bytes, read_image, write_png
from plan2scene.io import read_json, write_json, write_parquet
from plan2scene.plans.formats import read_plan
from plan2scene_app.finishes import LIBRARY, finishes_file, finishes_text, read_finishes
from plan2scene_app.set_by_hand import set_by_hand

NAMES = ("a/floor", "a/wall", "a/wall.w1", "b/floor", "b/wall", "b/ceiling")


@pytest.fixture
def house(tmp_path):
    for folder in (tmp_path / "found", tmp_path / "set"):
        folder.mkdir()
        for k, name in enumerate(NAMES):
            image = np.full((32, 32, 3), 40 * k, np.uint8)
            write_png(folder / f"{name.replace('/', '_')}.png", image)
        (folder / "a_wall.jpg").write_bytes(jpeg_bytes(image, quality=85))
        index = {name: {"size_m": 0.7, "observed": True, "source": "x"} for name in NAMES}
        write_json(folder / "textures.json", {"surfaces": index})
        whole = {"origin_m": [0, 0], "extent_m": [4, 3]}
        write_json(folder / "maps.json", {"surfaces": dict.fromkeys(("a/wall", "b/wall"), whole)})
        write_json(folder / "doors.json", {"": [1, 2, 3], "d1": [4, 5, 6]})
    image = png_bytes(np.full((128, 128, 3), (200, 30, 20), np.uint8))
    row = {"crop_id": "c", "photo": "p.jpg", "room_id": "b", "surface": "floor", "png": image}
    row |= {"metres": 0.5, "sharpness": 1.0, "detail": b"", "window": [0.0] * 4}
    write_parquet(tmp_path / "crops.parquet", pd.DataFrame([row]), {"house": "h"})
    paint = {"room_id": ["b"], "surface": ["floor"], "paint": [[0.4, 0.05, 0.02]]}
    paint = pd.DataFrame(paint | {"white": [False], "photos": ["p.jpg"]})
    write_parquet(tmp_path / "paint.parquet", paint, {"house": "h"})
    return tmp_path


def test_rooms_may_be_called_by_their_names(tmp_path):
    (tmp_path / "f.csv").write_text("room,surface,what\nLiving Room,floor,white\nx,wall,same:BAD\n")
    *rooms, bath = (plan := read_plan(PLAN, "h1")).rooms
    living = tuple(replace(room, name="living room") for room in rooms)
    plan = replace(plan, rooms=(*living, replace(bath, name="Bad")))
    named = {SurfaceKey(room.id, "floor"): "white" for room in rooms}
    named[SurfaceKey("x", "wall")] = f"same:{bath.id}"
    assert read_finishes(tmp_path / "f.csv", plan) == named


def test_each_kind_of_finish_and_nothing_else(house, caplog):
    chosen = {
        ("*", "wall"): "white",
        ("a", "wall.w1"): "#204060",
        ("a", "floor"): "photo:p.jpg",
        ("b", "ceiling"): "same:gone",
        **dict.fromkeys([("gone", "floor"), ("a", "wall.w9"), ("d9", "door")], "white"),
        ("d2", "door"): "#6b4a32",
        ("a", "trim"): "#204060",
    }
    table = house / "home.finishes.csv"
    table.write_text(finishes_text({SurfaceKey(*key): what for key, what in chosen.items()}))
    assert finishes_file(house / "home.scene.json") == table
    inputs = house / "crops.parquet", house / "paint.parquet"
    set_by_hand(house / "set", read_finishes(table), *inputs, openings=["d2"])
    different = filecmp.dircmp(house / "found", house / "set").diff_files
    changed = {"a_floor.png", "a_wall.png", "a_wall.w1.png", "b_wall.png"}
    assert set(different) == changed | {"textures.json", "maps.json", "doors.json"}
    tiles = {name: median_colour(read_image(house / "set" / name)) for name in changed}
    assert tiles["a_wall.w1.png"] == pytest.approx(np.array([32, 64, 96]) / 255, abs=1e-3)
    assert (tiles["a_wall.png"] == tiles["b_wall.png"]).all()
    assert tiles["a_wall.png"].min() > 0.85  # white paint, which is not paper
    red, green, blue = tiles["a_floor.png"]  # the paint of what the crops show
    assert red == pytest.approx(0.665, abs=0.02) and max(green, blue) < 0.3
    entries = read_json(house / "set" / "textures.json")["surfaces"]
    assert entries["a/wall"]["source"] == "set by hand: white"
    assert entries["a/floor"]["evidence"]["words"] == "set by hand: as in photo p.jpg"
    assert entries["b/ceiling"]["source"] == "x"
    assert read_json(house / "set" / "maps.json") == {"surfaces": {}}
    assert not (house / "set" / "a_wall.jpg").exists()
    doors = {"": [1, 2, 3], "d1": [4, 5, 6], "d2": [107, 74, 50], "d9": [234] * 3}
    assert read_json(house / "set" / "doors.json") == doors
    assert read_json(house / "set" / "trim.json") == {"a": [32, 64, 96]}
    lines = [record.getMessage() for record in caplog.records]
    assert [line[10:20] for line in lines[:3]] == ["a/wall.w9 ", "d9/door is", "gone/floor"]


def test_the_same_as_in_another_room_follows_it_and_no_circle(house):
    key = SurfaceKey
    chosen = {key("a", "floor"): "same:b", key("b", "floor"): "white"}
    chosen |= {key("a", "wall"): "same:b", key("b", "wall"): "same:a"}
    inputs = house / "crops.parquet", house / "paint.parquet"
    set_by_hand(house / "set", chosen, *inputs, openings=())
    same = [read_image(house / "set" / f"{room}_floor.png") for room in ("a", "b")]
    assert np.array_equal(*same) and same[0].min() > 200
    for room in ("a", "b"):
        names = [house / folder / f"{room}_wall.png" for folder in ("found", "set")]
        assert filecmp.cmp(*names, shallow=False)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("room,what\n", "the columns room, surface, what"),
        ("room,surface,what\na,wall\n", "3 cells"),
        ("room,surface,what\na,roof,white\n", "a surface of floor, wall, ceiling, door, trim"),
        ("room,surface,what\na,trim,same:b\n", "white, a colour such as #c8a472, found"),
        ("room,surface,what\na,wall,whitish\n", "white, a colour such as #c8a472, same:ROOM"),
        (f"room,surface,what\na,door,{next(iter(LIBRARY))}\n", "white, a colour such as #c8a472,"),
    ],
)
def test_a_row_that_no_house_can_follow_is_one_line(tmp_path, text, expected):
    (tmp_path / "h.finishes.csv").write_text(text)
    with pytest.raises(InputError, match=expected):
        read_finishes(tmp_path / "h.finishes.csv")
