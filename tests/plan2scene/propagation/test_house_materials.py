"""Surfaces of different rooms that are one material."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from plan2scene.house import SurfaceKey
from plan2scene.io import read_parquet, write_json, write_parquet
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene.propagation.house_materials import (
    EVIDENCE,
    SeenSurface,
    find_materials,
    grouped,
    pair_evidence,
)
from plan2scene.propagation.propagate import shared_materials


def seen(room, code, colour, crops=3):
    return SeenSurface(room, np.full(8, code, float), np.full(3, colour, float), crops)


def test_floors_go_by_their_code_and_walls_by_their_colour():
    joined = np.ones((3, 3), bool)
    lamps = [seen("a", 0.0, 0.3), seen("b", 0.1, 0.5), seen("c", 1.2, 0.3)]
    floors = pair_evidence(lamps, "floor", joined)
    assert floors[0, 1] > 0 > floors[0, 2]
    assert pair_evidence(lamps, "wall", joined)[0, 1] < 0
    paint = [seen("a", 0.0, 0.7), seen("b", 0.8, 0.72), seen("c", 0.0, 0.5)]
    walls = pair_evidence(paint, "wall", joined)
    assert walls[0, 1] > 0 > walls[0, 2]
    apart = joined.copy()
    apart[0, 1] = apart[1, 0] = False
    assert pair_evidence(lamps, "floor", apart)[0, 1] == -np.inf
    assert pair_evidence([], "floor", np.zeros((0, 0), bool)).shape == (0, 0)


def test_chance_in_a_mean_of_few_crops_is_no_difference():
    joined = np.ones((2, 2), bool)
    sure = [seen("a", 0.0, 0.4, 40), seen("b", 1.0, 0.4, 3)]
    few = [sure[0], replace(sure[1], doubt=np.full(8, 0.75))]
    assert pair_evidence(sure, "floor", joined)[0, 1] == pytest.approx(EVIDENCE.alike - 1.0)
    assert pair_evidence(few, "floor", joined)[0, 1] == pytest.approx(EVIDENCE.alike - 0.5)
    # No more than as if they were alike.
    none = [sure[0], replace(sure[1], doubt=np.full(8, 9.0))]
    assert pair_evidence(none, "floor", joined)[0, 1] == pytest.approx(EVIDENCE.alike)


def test_walls_that_are_alike_in_a_photo_each_may_be_so_by_chance():
    joined = np.ones((2, 2), bool)
    paint = [seen("a", 0.0, 0.6, 10), seen("b", 0.6, 0.67, 10)]
    more = [replace(item, photos=3) for item in paint]
    few, many = (pair_evidence(walls, "wall", joined)[0, 1] for walls in (paint, more))
    assert many > 0 > few
    for kind in ("floor", "ceiling"):
        same = [pair_evidence(walls, kind, joined)[0, 1] for walls in (paint, more)]
        assert same[0] == same[1] > 0


@pytest.mark.parametrize(("crops", "materials"), [(3, ["floor-1"] * 2), (30, [])])
def test_crops_that_differ_make_few_of_them_doubtful(shared_house, tmp_path, crops, materials):
    """Means 0 and 1 of crops that lie 1.5 around them: three can do that, thirty can't."""
    rooms = [room.id for room in shared_house.rooms]
    write_scene_json(shared_house, tmp_path / "scene.json")
    around = np.linspace(-1.5, 1.5, crops)
    rows = [
        {"room_id": room, "surface": "floor", "n_crops": crops, "photo": "a.png"}
        | {"embedding": np.r_[np.full(8, mean + off), [0.4] * 3].astype(np.float32)}
        for mean, room in enumerate(rooms)
        for off in around
    ]
    table = pd.DataFrame(rows)
    write_parquet(tmp_path / "embeddings.parquet", table, {})
    write_parquet(tmp_path / "surfaces.parquet", table.drop_duplicates("room_id"), {})
    write_json(tmp_path / "light.json", {"colours": "photo", "filter": True, "gains": {}})
    names = ("scene.json", "surfaces.parquet", "embeddings.parquet", "light.json")
    output = tmp_path / "materials.parquet"
    find_materials(*(tmp_path / n for n in names), (), output, house="h1", dataset="d")
    assert read_parquet(output)[0]["material"].tolist() == materials


def test_groups_are_joined_by_the_mean_of_their_pairs():
    # b is like both, a and c are not alike: the doubtful one stays alone.
    evidence = np.array([[1.0, 0.6, -0.9], [0.6, 1.0, 0.5], [-0.9, 0.5, 1.0]])
    assert grouped(evidence) == [([0, 1], pytest.approx(0.6))]
    assert grouped(np.full((3, 3), 0.4)) == [([0, 1, 2], pytest.approx(0.4))]
    assert grouped(np.full((3, 3), -np.inf)) == [] and grouped(np.zeros((0, 0))) == []


@pytest.mark.parametrize("colours", ["photo", "corrected"])
def test_a_floor_that_runs_on_is_one_material(shared_house, tmp_path, colours):
    rooms = [room.id for room in shared_house.rooms]
    write_scene_json(shared_house, tmp_path / "scene.json")
    codes = [np.r_[np.zeros(8), [value] * 3].astype(np.float32) for value in (0.5, 0.4)]
    table = pd.DataFrame({"room_id": rooms, "surface": "floor", "embedding": codes})
    table["n_crops"] = [1, 3]
    write_parquet(tmp_path / "surfaces.parquet", table, {})
    table["photo"] = ["bright.png", "dark.png"]
    write_parquet(tmp_path / "embeddings.parquet", table, {})
    gains = {"bright.png": [1.0] * 3, "dark.png": [1.5] * 3}
    write_json(tmp_path / "light.json", {"colours": colours, "filter": True, "gains": gains})
    names = ("scene.json", "surfaces.parquet", "embeddings.parquet", "light.json")
    output = tmp_path / "materials.parquet"
    find_materials(*(tmp_path / n for n in names), (), output, house="h1", dataset="d")
    found, metadata = read_parquet(output)
    assert found["material"].tolist() == ["floor-1"] * 2 and metadata["colours"] == colours
    assert found["rooms"].tolist() == ["|".join(rooms)] * 2
    assert found["confidence"].between(0.9, 1.0).all()
    shared = shared_materials(output)[SurfaceKey(rooms[0], "floor")]
    if colours == "photo":
        assert shared.colour is None
        assert found["colour"][0][0] == pytest.approx(0.25 * 0.5 + 0.75 * 0.481, abs=0.01)
    else:
        assert shared.colour == pytest.approx(np.full(3, 0.425))
    assert shared_materials(None) == {}


def test_a_floor_is_known_by_all_of_its_crops(shared_house, tmp_path):
    """The plainest crop of each room is of something else; the others show one floor."""
    rooms = [room.id for room in shared_house.rooms]
    write_scene_json(shared_house, tmp_path / "scene.json")
    codes = [np.r_[np.full(8, sign * 2.0), [0.4] * 3].astype(np.float32) for sign in (1, -1)]
    rows = [
        {"room_id": room, "surface": kind, "embedding": code, "n_crops": 6, "photo": "odd.png"}
        for kind in ("floor", "wall")
        for room, code in zip(rooms, codes, strict=True)
    ]
    write_parquet(tmp_path / "surfaces.parquet", pd.DataFrame(rows), {})
    plain = np.r_[np.zeros(8), [0.4] * 3].astype(np.float32)
    rows += [row | {"embedding": plain, "photo": "usual.png"} for row in rows * 5]
    write_parquet(tmp_path / "embeddings.parquet", pd.DataFrame(rows), {})
    write_json(tmp_path / "light.json", {"colours": "photo", "filter": True, "gains": {}})
    names = ("scene.json", "surfaces.parquet", "embeddings.parquet", "light.json")
    output = tmp_path / "materials.parquet"
    for hidden, materials in (((), ["floor-1"] * 2), (("usual.png",), [])):
        find_materials(*(tmp_path / n for n in names), hidden, output, house="h1", dataset="d")
        assert read_parquet(output)[0]["material"].tolist() == materials
