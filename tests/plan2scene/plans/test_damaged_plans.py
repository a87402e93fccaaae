"""Any damage to a plan is one clear line, or a house that holds and survives the round trip."""

import copy
import json
import random
from pathlib import Path

import pytest
from damage import VALUES, places

from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan
from plan2scene.plans.plan_json import house_of_plan
from plan2scene.plans.r2v import house_of_r2v
from plan2scene.plans.scene_json import house_of_scene
from plan2scene.plans.scene_writer import house_to_scene
from plan2scene.plans.validate import validate_house

EXAMPLES = Path(__file__).parents[3] / "resources" / "examples"


def damaged(document, generator):
    document = copy.deepcopy(document)
    for _ in range(generator.choice([1, 1, 2])):
        container, key = generator.choice(places(document))
        way = generator.random()
        if way < 0.3:
            del container[key]
        elif way < 0.4 and isinstance(container, list):
            container.append(copy.deepcopy(container[key]))
        else:
            container[key] = copy.deepcopy(generator.choice([*VALUES, "living"]))
    return document


@pytest.mark.parametrize("form", ["scene", "plan"])
@pytest.mark.parametrize("example", ["plan.json", "two_storeys/plan.json"])
def test_damaged_json(form, example):
    document, read = json.loads((EXAMPLES / example).read_text()), house_of_plan
    if form == "scene":
        document, read = house_to_scene(house_of_plan(document, "h1")), house_of_scene
    generator = random.Random(0)
    outcomes = {"house": 0, "fault": 0}
    for _ in range(300 if example == "plan.json" else 150):
        try:
            house = read(damaged(document, generator), "h1")
            validate_house(house)
        except InputError as error:
            assert str(error).startswith("house h1")
            assert "\n" not in str(error)
            outcomes["fault"] += 1
        else:
            assert house_of_scene(house_to_scene(house), "h1") == house
            outcomes["house"] += 1
    assert min(outcomes.values()) > 10


def test_damaged_raster_to_vector():
    rows = [f"{40 * i} 0 {40 * i} 80 wall 1 1" for i in range(4)]
    rows += [f"0 {40 * i} 120 {40 * i} wall 1 1" for i in range(3)]
    rows += ["40 10 40 30 door 1 1", "10 10 20 20 bedroom 1 1", "50 10 60 20 toilet 1 1"]
    generator = random.Random(0)
    words = ["0", "1", "-4", "90", "wall", "door", "nan", "x", "1e9", "37.5"]
    outcomes = {"house": 0, "fault": 0}
    for _ in range(100):
        fields = [row.split() for row in rows]
        for _ in range(generator.choice([1, 2, 4])):
            line = generator.choice(fields)
            line[generator.randrange(len(line))] = generator.choice(words)
        try:
            house = house_of_r2v("\n".join(map(" ".join, fields)), "h1", 0.05)
            validate_house(house)
        except InputError as error:
            assert str(error).startswith("house h1: expected")
            outcomes["fault"] += 1
        else:
            assert house_of_scene(house_to_scene(house), "h1") == house
            outcomes["house"] += 1
    assert min(outcomes.values()) > 10


def test_too_much_is_refused_before_it_is_worked_on(tmp_path):
    ring = [[i / 100, (i % 2) / 100] for i in range(999)] + [[10, 5]]
    rooms = [{"id": f"r{i}", "types": ["Closet"], "polygon": ring} for i in range(6)]
    document = {"format": "plan2scene-plan", "version": 1, "rooms": rooms}
    with pytest.raises(InputError, match="at most 5000 corners of all rooms, found 6000"):
        house_of_plan(document, "h1")
    lines = [f"{i} 0 {i} 9000 wall\n0 {i} 9000 {i} wall" for i in range(0, 9000, 8)]
    (tmp_path / "plan.txt").write_text("\n".join(lines))
    with pytest.raises(InputError, match="at most 2000 walls, found 2250"):
        read_plan(tmp_path / "plan.txt", "h1", 0.01)
    lines = [f"{i} 0 {i} 900 wall\n0 {i} 900 {i} wall" for i in range(0, 900, 20)]
    with pytest.raises(InputError, match="close 1 to 1000 rooms, found 1936 rooms"):
        house_of_r2v("\n".join(lines), "h1", 0.01)
