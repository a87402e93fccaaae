import json
from pathlib import Path

import pytest
from scene_textures import scene_textures

from plan2scene.house import Door, SurfaceKey
from plan2scene.plans.formats import read_plan
from plan2scene.plans.scene_json import read_scene_json
from plan2scene.plans.scene_writer import house_to_scene, write_scene_json
from plan2scene.plans.validate import validate_house

SHARED = Path(__file__).parents[4] / "shared" / "samples"


def arch(**changes):
    """A 4 x 3 m bedroom and a 2 x 3 m bathroom beside it that share a wall with a door."""
    square = [[0, 0, 0], [4, 0, 0], [4, 0, 3], [0, 0, 3]]
    bath = [[4, 0, 0], [6, 0, 0], [6, 0, 3], [4, 0, 3]]
    hole = {"id": "door", "type": "Door", "box": {"min": [1, 0], "max": [1.9, 2.1]}}
    elements = [
        {"id": "a_f", "type": "Floor", "roomId": "a", "points": [square]},
        {"id": "a_c", "type": "Ceiling", "roomId": "a", "points": [square], "offset": [0, 2.5, 0]},
        {"id": "b_f", "type": "Floor", "roomId": "b", "points": [bath]},
        {"id": "b_c", "type": "Ceiling", "roomId": "b", "points": [bath], "offset": [0, 2.5, 0]},
        wall("w0", ["a", "b"], [4, 0], [4, 3], [hole]),
        wall("w1", "a", [0, 0], [4, 0]),
        wall("w2", "a", [0, 3], [4, 3]),
        wall("w3", "a", [0, 0], [0, 3]),
        wall("w4", "b", [4, 0], [6, 0]),
        wall("w5", "b", [6, 0], [6, 3]),
        wall("w6", "b", [6, 3], [4, 3]),
    ]
    value = {
        "id": "other_name",
        "elements": elements,
        "rooms": [{"id": "a", "types": ["Bedroom"]}, {"id": "b", "types": ["Bathroom"]}],
        "rdr": [["a", "door", "b"], ["b", "door", "a"]],
    }
    value.update(changes)
    return value


def wall(name, room, start, end, holes=()):
    points = [[start[0], 0, start[1]], [end[0], 0, end[1]]]
    found = {"id": name, "type": "Wall", "roomId": room, "height": 2.5, "points": points}
    return found | {"holes": list(holes)}


def read(tmp_path, document):
    path = tmp_path / "plan.json"
    path.write_text(json.dumps(document))
    house = read_plan(path, "h1")
    return house, validate_house(house, file=path)


@pytest.mark.parametrize(
    "wrap",
    [
        lambda a: {"format": "sceneState", "scene": {"up": {"x": 0, "y": 1, "z": 0}, "arch": a}},
        lambda a: {"scene": {"unit": 1.0, "arch": a}},
        lambda a: {"arch": a},
        lambda a: a,
    ],
)
def test_nestings_read_alike(tmp_path, wrap):
    house, warnings = read(tmp_path, wrap(arch()))
    assert warnings == [] and house.id == "h1"
    assert [room.types for room in house.rooms] == [("Bedroom",), ("Bathroom",)]
    assert [room.height for room in house.rooms] == [2.5, 2.5]
    assert len(house.walls) == 7 and house.walls[0].room_ids == ("a", "b")
    assert (house.walls[0].depth, house.walls[0].extra_height) == (0.1, 0.035)
    assert house.doors == (Door("a", "door", "b"),) and house.adjacency() == (("a", "b"),)


@pytest.mark.parametrize("kind", ["door", "passage"])
def test_round_trip(tmp_path, kind):
    document = arch()
    document["elements"][4]["holes"][0]["type"] = kind.title()
    house, _ = read(tmp_path, document)
    assert house.walls[0].openings[0].kind == kind
    again, warnings = read(tmp_path, house_to_scene(house))
    assert again == house and warnings == []


def test_a_written_file_has_the_official_form_and_its_textures_come_back(tmp_path):
    house, _ = read(tmp_path, arch())
    scene = house_to_scene(house)
    assert scene["format"] == "sceneState"
    assert sorted(scene["scene"]["arch"]["rdr"]) == [["a", "door", "b"], ["b", "door", "a"]]
    kinds = [element["type"] for element in scene["scene"]["arch"]["elements"]]
    assert kinds == ["Floor", "Ceiling"] * 2 + ["Wall"] * 7
    assert scene["scene"]["arch"]["elements"][1]["offset"] == [0, 2.5, 0]
    textures = {
        SurfaceKey("a", "floor"): (b"one", 1.25),
        SurfaceKey("a", "wall"): (b"two", 0.5),
        SurfaceKey("b", "wall"): (b"four", 2.0),
        SurfaceKey("b", "ceiling"): (b"three", 1.0),
    }
    path = tmp_path / "scene.json"
    write_scene_json(house, path, textures)
    assert scene_textures(path) == textures and read_scene_json(path, "h1") == house
    text = path.read_text()
    assert "data:img/png;base64,b25l" in text
    wall = next(e for e in json.loads(text)["scene"]["arch"]["elements"] if e["id"] == "w0")
    names = [material["materialId"] for material in wall["materials"]]
    assert names == ["Material_a_wall", "Material_b_wall"]


def test_same_hole_on_both_rooms_walls(tmp_path):
    document = arch()
    shared = document["elements"][4]
    shared["roomId"] = ["a"]
    document["elements"].append({**shared, "id": "w7", "roomId": ["b"]})
    house, warnings = read(tmp_path, document)
    assert [o.id for w in house.walls for o in w.openings] == ["door", "door"]
    assert house.doors == (Door("a", "door", "b"),) and warnings == []


def test_relations_come_from_geometry_without_rdr(tmp_path):
    document = arch()
    del document["rdr"]
    box = {"min": [1, 0], "max": [2, 2]}
    document["elements"][5]["holes"] = [{"id": "front", "type": "Door", "box": box}]
    house, warnings = read(tmp_path, document)
    assert set(house.doors) == {Door("a", "door", "b"), Door("a", "front", None)}
    assert len(warnings) == 1


def test_walls_are_made_only_for_a_room_without_any(tmp_path):
    document = arch()
    document["elements"] = [e for e in document["elements"] if e["id"] not in ("w1", "w2")]
    house, _ = read(tmp_path, document)
    assert len(house.walls) == 5
    document["elements"] = [e for e in document["elements"] if e["type"] != "Wall"]
    house, warnings = read(tmp_path, {**document, "rdr": []})
    assert len(house.walls) == 8
    assert any("room b: expected walls, found none; made from the outline" in w for w in warnings)


LABELS = {"living_room": "Reception", "PS": "Closet", "washing_room": "Bathroom"}


@pytest.mark.parametrize(("label", "expected"), [*LABELS.items(), ("attic", "Unknown")])
def test_labels_of_the_reference_converter(tmp_path, label, expected):
    document = arch(rooms=[{"id": "a", "types": [label]}, {"id": "b", "types": ["Closet"]}])
    house, warnings = read(tmp_path, document)
    assert house.room("a").types == (expected,)
    assert len(warnings) == (1 if label == "attic" else 0)


@pytest.mark.shared
@pytest.mark.skipif(not SHARED.is_dir(), reason="no samples beside the repository")
@pytest.mark.parametrize(
    ("name", "rooms", "walls", "openings", "rdr", "objects"),
    [
        ("r2v/sample_input.scene.json", 5, 20, 7, 11, 0),
        ("rent3dpp/sample.scene.json", 3, 14, 6, 5, 12),
    ],
)
def test_samples(name, rooms, walls, openings, rdr, objects, tmp_path):
    house = read_scene_json(SHARED / name, "sample")
    assert validate_house(house) == []
    assert (len(house.rooms), len(house.walls)) == (rooms, walls)
    assert sum(len(wall.openings) for wall in house.walls) == openings
    assert len(house.objects) == objects
    scene = house_to_scene(house)
    original = json.loads((SHARED / name).read_text())["scene"]["arch"]["rdr"]
    assert sorted(map(str, scene["scene"]["arch"]["rdr"])) == sorted(map(str, original))
    assert len(original) == rdr
    write_scene_json(house, tmp_path / "again.json")
    assert read_scene_json(tmp_path / "again.json", "sample") == house
