from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from plan2scene.house import SurfaceKey
from plan2scene.io import read_parquet, write_json, write_parquet
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene.propagation.house_materials import find_materials
from plan2scene.propagation.propagate import shared_materials


def found(folder, hidden=()):
    names = ("scene.json", "surfaces.parquet", "embeddings.parquet", "light.json")
    output = folder / "materials.parquet"
    find_materials(*(folder / n for n in names), hidden, output, house="h1", dataset="d")
    return read_parquet(output)[0]


@pytest.mark.parametrize(("crops", "materials"), [(3, ["floor-1"] * 2), (30, [])])
def test_crops_that_differ_make_few_of_them_doubtful(shared_house, tmp_path, crops, materials):
    """Means 0 and 1 of crops that lie 1.5 around them: three can do that, thirty can't."""
    rooms = [room.id for room in shared_house.rooms]
    write_scene_json(shared_house, tmp_path / "scene.json")
    rows = [
        {"room_id": room, "n_crops": crops, "embedding": code(mean + off)}
        for mean, room in enumerate(rooms)
        for off in np.linspace(-1.5, 1.5, crops)
    ]
    table = pd.DataFrame(rows).assign(surface="floor", photo="a.png", substance="tile")
    write_parquet(tmp_path / "embeddings.parquet", table, {})
    write_parquet(tmp_path / "surfaces.parquet", table.drop_duplicates("room_id"), {})
    write_json(tmp_path / "light.json", {"gains": {}})
    assert found(tmp_path)["material"].tolist() == materials


def code(value, grey=0.4):
    return np.r_[np.full(8, value), [grey] * 3].astype(np.float32)


def two_floors(folder, plan, codes, substances, gains=None):
    """Write a crop of each floor of a plan's two rooms; return the rooms."""
    write_scene_json(plan, folder / "scene.json")
    rooms = [room.id for room in plan.rooms]
    table = pd.DataFrame({"room_id": rooms, "surface": "floor", "embedding": codes})
    table["n_crops"], table["substance"] = [1, 3], substances
    table["photo"] = ["bright.png", "dark.png"]
    for name in ("surfaces", "embeddings"):
        write_parquet(folder / f"{name}.parquet", table, {})
    write_json(folder / "light.json", {"gains": gains or {}})
    return rooms


def test_a_floor_that_runs_on_is_one_material(shared_house, tmp_path):
    gains = {"bright.png": [1.0] * 3, "dark.png": [1.5] * 3}
    rooms = two_floors(tmp_path, shared_house, [code(0, 0.5), code(0, 0.4)], "tile", gains)
    table = found(tmp_path)
    assert table["material"].tolist() == ["floor-1"] * 2
    assert table["rooms"].tolist() == ["|".join(rooms)] * 2
    assert table["confidence"].between(0.9, 1.0).all()
    shared = shared_materials(tmp_path / "materials.parquet")
    assert shared[SurfaceKey(rooms[0], "floor")] == "floor-1"
    assert table["colour"][0][0] == pytest.approx(0.25 * 0.5 + 0.75 * 0.481, abs=0.01)
    assert shared_materials(None) == {}


@pytest.mark.parametrize(
    ("kind", "width", "apart", "other", "one"),
    [("passage", 0.9, 1.0, "tile", True), ("door", 0.9, 1.0, "tile", False)]
    + [("passage", 0.9, 1.4, "tile", False), ("passage", 2.0, 1.4, "tile", True)]
    + [("passage", 2.0, 1.4, "carpet", False)],
)
def test_floors_run_on_through_passages(shared_house, tmp_path, kind, width, apart, other, one):
    shared, *others = shared_house.walls
    opening = replace(shared.openings[0], kind=kind)
    opening = replace(opening, end=opening.start + width)
    assert opening.end <= shared.length
    plan = replace(shared_house, walls=(replace(shared, openings=(opening,)), *others))
    two_floors(tmp_path, plan, [code(0), code(apart)], ["tile", other])
    assert found(tmp_path)["material"].tolist() == ["floor-1"] * 2 * one


@pytest.mark.parametrize(
    ("substances", "materials"),
    [(["wood", "wood"], ["floor-1"] * 2), (["wood", "tile"], []), (["tile", "tile"], [])],
)
def test_floors_of_wood_are_sooner_one(shared_house, tmp_path, substances, materials):
    """They differ by more than two of stone may."""
    two_floors(tmp_path, shared_house, [code(0), code(1)], substances)
    assert found(tmp_path)["material"].tolist() == materials


def test_a_floor_is_known_by_all_of_its_crops(shared_house, tmp_path):
    """The plainest crop of each room is of something else; the others show one floor."""
    rooms = [room.id for room in shared_house.rooms]
    write_scene_json(shared_house, tmp_path / "scene.json")
    rows = [
        {"room_id": room, "surface": kind, "embedding": code(value), "photo": "odd.png"}
        | {"n_crops": 6, "substance": "tile"}
        for kind in ("floor", "wall")
        for room, value in zip(rooms, (2.0, -2.0), strict=True)
    ]
    write_parquet(tmp_path / "surfaces.parquet", pd.DataFrame(rows), {})
    rows += [row | {"embedding": code(0), "photo": "usual.png"} for row in rows * 5]
    write_parquet(tmp_path / "embeddings.parquet", pd.DataFrame(rows), {})
    write_json(tmp_path / "light.json", {"gains": {}})
    for hidden, materials in (((), ["floor-1"] * 2), (("usual.png",), [])):
        assert found(tmp_path, hidden)["material"].tolist() == materials
