import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from rent3dpp_copy import drawn_icons, write_rent3dpp_copy

from plan2scene.datasets.import_plan import add_object_boxes, import_plan, read_object_boxes
from plan2scene.errors import InputError
from plan2scene.images import png_bytes, write_png
from plan2scene.io import write_json, write_parquet
from plan2scene.plans.formats import read_plan
from plan2scene.plans.scene_writer import write_scene_json
from plan2scene_app.check import check_dataset
from plan2scene_app.workflow.config import chosen_crops, table_of
from plan2scene_app.workflow.house_table import table_of_lists
from plan2scene_app.workflow.layout import find_layout
from plan2scene_workshop.homes.floorplans import generate_house
from plan2scene_workshop.homes.residences import write_dataset_index

HOUSES = dict(home_train_0="train", home_val_0="val", home_test_0="test", home_test_1="test")


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    png = png_bytes(np.full((128, 128, 3), 90, np.uint8))
    for house in HOUSES:
        ids = [f"{n}/{house}_{k}_0_crop0" for n in ("floor", "wall", "ceiling") for k in "012"]
        frame = pd.DataFrame({"crop_id": ids, "png": [png] * len(ids)})
        write_parquet(folder / "houses" / house / "crops.parquet", frame, {"house": house})
    return folder


@pytest.fixture
def source(tmp_path):
    root = tmp_path / "source"
    for house_id, split in HOUSES.items():
        house = generate_house(house_id, 4)
        write_scene_json(house, root / f"archs_no_objects/{split}/{house_id}.scene.json")
        photos = [f"{house_id}_{k}.png" for k in range(3)]
        for name in photos:
            write_png(root / "photos" / name, np.zeros((6, 8, 3), np.uint8))
        lines = ["room_id,photo", *(f"{house.rooms[0].id},{name}" for name in photos)]
        table = root / f"photo_assignments/{split}/{house_id}.photoroom.csv"
        table.parent.mkdir(parents=True, exist_ok=True)
        table.write_text("\n".join(lines) + "\n")
    write_dataset_index(root, HOUSES, 1)
    return root


@pytest.fixture
def copy(source, results, tmp_path):
    assert write_rent3dpp_copy(source, tmp_path / "copy", crops=results) == list(HOUSES)
    return tmp_path / "copy"


def lines_of(root):
    return [str(problem) for problem in check_dataset(root)]


def dataset(root, **changes):
    return {"root": str(root), "table": None, "architecture": "bare"} | changes


def test_a_whole_copy_is_read_without_a_problem(copy, tmp_path):
    assert lines_of(copy) == []
    assert sorted(path.name for path in copy.iterdir()) == ["input", "processed"]
    plans = {}
    for kind in ("bare", "full"):
        row = table_of(dataset(copy, architecture=kind))["home_test_0"]
        plans[kind] = read_plan(copy / row.plan, "home_test_0")
    assert plans["bare"].rooms == plans["full"].rooms and plans["bare"].objects == ()
    assert len(plans["full"].objects) == len(drawn_icons(plans["bare"])) > 0
    plan = copy / "input/archs_no_objects/test/home_test_0.scene.json"
    boxes = copy / "input/object_aabbs/test/home_test_0.objectaabb.json"
    house = import_plan(plan, tmp_path / "o.json", house_id="home_test_0", object_boxes=boxes)
    assert house.icons == drawn_icons(house)
    assert read_plan(tmp_path / "o.json", "home_test_0").icons == house.icons
    before = set(copy.rglob("*"))
    assert "home_val_0" in table_of(dataset(copy)).houses
    (copy / "input/data_lists/val.txt").write_text("")
    assert "home_val_0" not in table_of(dataset(copy)).houses
    assert set(copy.rglob("*")) == before


@pytest.mark.parametrize("place", ["", "input", ".."])
def test_the_path_may_be_of_the_copy_or_its_input_or_what_holds_data(copy, place, tmp_path):
    root = copy / place if place != ".." else tmp_path / "holder"
    if place == "..":
        root.mkdir()
        copy.rename(root / "data")
        copy = root / "data"
    layout = find_layout(root)
    assert layout.data.resolve() == (copy / "input").resolve()
    assert layout.surface_crops.resolve() == (copy / "processed/surface_crops").resolve()
    assert layout.is_rent3dpp
    for row in table_of_lists(root).houses.values():
        assert (layout.root / row.plan).is_file() and (layout.root / row.assignment).is_file()


@pytest.mark.parametrize(
    ("document", "word"),
    [
        ([], "object boxes"),
        ({"boxes": []}, "a list objects"),
        ({"objects": {}}, "a list for objects"),
        ({"objects": [{"type": "bed"}]}, "bound_box"),
        ({"objects": [{"type": "bed", "bound_box": {"p1": [0, 0], "p2": ["a", 1]}}]}, "corner"),
        ({"objects": [{"bound_box": {"p1": [0, 0], "p2": [1, 1]}}]}, "a type"),
    ],
)
def test_faulty_object_boxes_are_a_line_and_the_house_goes_on(copy, tmp_path, document, word):
    house = generate_house("h", 4)
    write_json(tmp_path / "b.json", document)
    with pytest.raises(InputError, match=word):
        read_object_boxes(tmp_path / "b.json", "h")
    same, warnings = add_object_boxes(house, tmp_path / "b.json")
    assert same == house and [word in line for line in warnings] == [True]
    boxes = copy / "input/object_aabbs/test/home_test_0.objectaabb.json"
    write_json(boxes, document)
    assert [line.startswith(f"warning: file {boxes}") for line in lines_of(copy)] == [True]


def test_each_missing_part_is_one_line(copy):
    data = copy / "input"
    (data / "data_lists/train.txt").unlink()
    (data / "unobserved_photos.json").write_text(json.dumps({"0.0": [], "0.2": []}))
    (data / "object_aabbs/test/home_test_1.objectaabb.json").unlink()
    (copy / "processed/full_archs/test/home_test_0.scene.json").unlink()
    for path in (copy / "processed/surface_crops/ceiling").iterdir():
        path.unlink()
    for surface in ("floor", "wall"):
        (copy / f"processed/surface_crops/{surface}/home_val_0_1_0_crop0.png").unlink()
    (data / "photos/home_val_0_2.png").unlink()
    lines = lines_of(copy)
    expected = [
        "train.txt: expected a list of houses, found no such file",
        "expected drop fraction 0.6, which the table needs, found 0.0, 0.2",
        "found 1 lacking, the first home_test_0",
        "found 1 lacking, the first home_test_1",
        "expected crops of a ceiling, found none",
        "expected crops of 9 photos, found 1 lacking, the first home_val_0_1.png",
        "found no such file",
    ]
    assert len(lines) == len(expected)
    assert all(part in line for part, line in zip(expected, lines, strict=True))
    assert all(line.startswith("warning: ") for line in lines)


def test_an_empty_path_is_one_line(tmp_path):
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(InputError, match=r"expected a Rent3D\+\+ copy .* found none of these"):
        table_of(dataset(empty))
    with pytest.raises(InputError, match="found no such folder"):
        table_of(dataset(tmp_path / "no"))
    assert len(lines_of(empty)) == 1


def test_ready_crops_are_used_where_there_are_some(copy, source):
    folder = str(copy / "processed/surface_crops")
    with_crops, without = find_layout(copy), find_layout(source)
    auto = {"source": "auto", "folder": None}
    assert chosen_crops(with_crops, auto) == {"source": "precomputed", "folder": folder}
    assert chosen_crops(without, auto)["source"] == "sampled"
    assert chosen_crops(with_crops, auto | {"source": "sampled"})["source"] == "sampled"
    other = {"source": "auto", "folder": "other"}
    assert chosen_crops(without, other) == {"source": "precomputed", "folder": "other"}
    with pytest.raises(InputError, match=r"crops\.folder"):
        chosen_crops(without, auto | {"source": "precomputed"})


@pytest.mark.shared
def test_boxes_of_the_reference_converter_fit_its_plan():
    folder = Path(__file__).parents[4] / "shared" / "samples" / "r2v"
    if not folder.is_dir():
        pytest.skip("no shared samples beside the repository")
    house = read_plan(folder / "sample_input.scene.json", "sample")
    house, warnings = add_object_boxes(house, folder / "sample_input.objectaabb.json")
    assert {box.type for box in house.icons} >= {"toilet", "cooking_counter", "washing_basin"}
    assert warnings == []
