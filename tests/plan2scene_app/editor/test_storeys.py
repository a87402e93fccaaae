import json

import pytest

from plan2scene.plans.formats import read_plan
from plan2scene.plans.validate import validate_house

#: Whole plan: `drawing.plan` is that of the floor shown.
WHOLE = "editor.store.state.plan"


def whole(drawing):
    return drawing.page.evaluate(WHOLE)


def press_button(drawing, name):
    drawing.page.get_by_role("button", name=name, exact=True).click()


def set_field(drawing, label, text):
    drawing.page.get_by_label(label, exact=True).fill(text)
    drawing.page.keyboard.press("Enter")


@pytest.fixture
def two_floors(drawing):
    drawing.two_rooms()
    press_button(drawing, "Copy to the top")
    drawing.press("PageDown", "t")
    drawing.click(4.5, 2.8)
    drawing.click(4.5, 0.2)
    drawing.press("v")
    return drawing


def test_a_copied_floor_and_stairs_make_a_house_of_two_storeys(two_floors, tmp_path):
    drawing = two_floors
    bath = {"id": "bath", "type": "bath", "from": [0.1, 0.1], "to": [0.9, 1.8]}
    drawing.page.evaluate(
        "(bath) => editor.store.changePlan({ fixtures: [bath] })", {**bath, "level": "ground"}
    )
    plan = whole(drawing)
    assert [level["id"] for level in plan["levels"]] == ["ground", "floor_1"]
    assert plan["levels"][1]["elevation"] == pytest.approx(2.8 + 0.3)
    assert [r["id"] for r in plan["rooms"]] == ["room", "room_2", "room_3", "room_4"]
    assert [r["level"] for r in plan["rooms"]] == ["ground"] * 2 + ["floor_1"] * 2
    drawing.page.get_by_role("button", name="Turn round").click()
    drawing.press("Control+z")
    (stairs,) = whole(drawing)["stairs"]
    place = {"from": [4.5, 2.8], "to": [4.5, 0.2], "width": 0.9}
    assert stairs == place | {"id": "stairs", "level": "ground"}
    set_field(drawing, "Lies at", "0.2 m")
    assert whole(drawing)["heights"] == "usual"
    set_field(drawing, "Ceilings at", "260 cm")
    assert "heights" not in whole(drawing)
    set_field(drawing, "Floor name", "Parterre")
    (tmp_path / "plan.json").write_text(json.dumps(whole(drawing)))
    house = read_plan(tmp_path / "plan.json", "home")
    assert [(level.name, level.elevation, level.height) for level in house.levels] == [
        ("Parterre", 0.2, 2.6),
        ("Floor 1", 3.1, 2.8),
    ]
    assert {room.height for room in house.rooms if room.level == "ground"} == {2.6}
    assert [icon.level for icon in house.icons] == ["ground"]
    assert house.stairs[0].room_ids == ("room_2", "room_4") and len(house.doors) == 2
    told = {line.split("expected ")[1].split(", found")[0] for line in validate_house(house)}
    assert told == {problem["expected"] for problem in drawing.page.evaluate("editor.problems")}


def test_what_is_drawn_is_on_the_floor_that_is_shown(two_floors):
    drawing = two_floors
    drawing.press("PageUp", "r")
    drawing.drag((5, 0), (8, 3))
    drawing.press("v")
    assert len(drawing.plan["rooms"]) == 3
    drawing.drag((3, 2.6), (3.5, 2.6))
    drawing.press("PageDown")
    assert len(drawing.plan["rooms"]) == 2
    assert {x for room in drawing.plan["rooms"] for x, _ in room["polygon"]} == {0, 3, 5}
    upper = [room for room in whole(drawing)["rooms"] if room["level"] == "floor_1"]
    assert {x for room in upper for x, _ in room["polygon"]} == {0, 3.5, 5, 8}
    for _ in range(2):
        drawing.press("Control+z")
    assert len(whole(drawing)["rooms"]) == 4


def test_a_problem_leads_to_its_floor_and_a_floor_is_removed(two_floors):
    drawing = two_floors
    drawing.page.get_by_role("button", name="+ Below", exact=True).click()
    assert drawing.page.evaluate("editor.store.floor.elevation") == pytest.approx(-3.1)
    found = drawing.page.evaluate("editor.problems.map((p) => p.expected)")
    assert "rooms on level basement" in found
    drawing.press("r")
    drawing.drag((0, 0), (9, 3))
    set_field(drawing, "Height", "3.3")
    drawing.press("PageUp", "v")
    drawing.page.locator("#problems li button", has_text="a ceiling below level ground").click()
    assert drawing.page.evaluate("[editor.store.level, editor.selection.id]") == [
        "basement",
        "room_5",
    ]
    drawing.press("Escape")
    press_button(drawing, "Remove this floor")
    assert {room["level"] for room in whole(drawing)["rooms"]} == {"ground", "floor_1"}
    assert drawing.page.evaluate("editor.store.level") == "ground"
    drawing.press("Control+z")
    assert len(whole(drawing)["rooms"]) == 5
