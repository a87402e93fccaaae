import json

import pytest
from places import PLAN

from plan2scene.errors import InputError
from plan2scene.plans.plan_json import house_of_plan
from plan2scene.plans.validate import validate_house

KEYS = ("polygon", "from", "to")


def scaled(value, factor):
    """Return the example's JSON in another unit: lengths of the drawing times `factor`."""
    if isinstance(value, dict):
        return {key: scaled(item, factor) for key, item in value.items()}
    if isinstance(value, list):
        return [scaled(item, factor) for item in value]
    return value * factor if isinstance(value, float | int) and value is not True else value


def plan(factor=1.0, **changes):
    document = json.loads(PLAN.read_text())
    for entry in (*document["rooms"], *document["openings"]):
        entry.update({key: scaled(entry[key], factor) for key in KEYS if key in entry})
    document["rooms"][0].update(changes)
    return document


def warnings_of(document):
    return "\n".join(validate_house(house_of_plan(document, "h1")))


@pytest.mark.parametrize("factor", [100.0, 39.37], ids=["centimetres", "inches"])
def test_another_unit_is_refused(factor):
    with pytest.raises(InputError, match=r"home in metres.*m2 \(are these centimetres\?\)"):
        warnings_of(plan(factor))


def test_feet_and_decimetres_are_told():
    assert "usual door of 0.4 to 1.6 m, found 2." in warnings_of(plan(3.2808))
    assert "usual room of 0.3 to 60 m2, found 0.0" in warnings_of(plan(0.08))
    assert "usual room" in warnings_of(plan(5))


@pytest.mark.parametrize(
    ("long", "wide", "line"),
    [
        (0.2, 0.2, "of 0.05 to 500 m2, found 0.04 m2"),
        (60, 60, "of 0.05 to 500 m2, found 3600.00 m2"),
        (3, 0.05, "at least 0.2 m wide, found about 0.05 m"),
    ],
)
def test_a_room_of_an_absurd_size_is_told(long, wide, line):
    document = plan()
    ring = [[8, 0], [8 + long, 0], [8 + long, wide], [8, wide]]
    document["rooms"].append({"id": "odd", "types": ["Closet"], "polygon": ring})
    assert f"room odd: expected a room {line}" in warnings_of(document)


@pytest.mark.parametrize("height", [0.05, 0.4, 31, 100])
def test_absurd_heights_are_refused(height):
    with pytest.raises(InputError, match=r"a height of 0\.5 to 30 m, found"):
        warnings_of(plan(height=height))


def test_islands_and_slits_are_told():
    document = plan()
    shed = [[90, 0], [93, 0], [93, 3], [90, 3]]
    document["rooms"].append({"id": "shed", "types": ["Closet"], "polygon": shed})
    line = "room shed: expected rooms within 5 m of each other, found 1 apart"
    assert line in warnings_of(document)
    slit = {"kind": "door", "from": [91, 0], "to": [91.001, 0], "bottom": 0, "top": 2}
    document["openings"].append(slit)
    assert "of at least 0.2 m, found 0.001 m" in warnings_of(document)


@pytest.mark.parametrize(
    ("name", "word"), [("LIVING", "upper and lower case"), ("CON", "takes as a file name")]
)
def test_names_that_other_systems_do_not_take_are_told(name, word):
    document = json.loads(json.dumps(plan()).replace('"bath"', f'"{name}"'))
    ids = [room["id"] for room in document["rooms"]]
    document["rooms"][-1]["id"] = name
    assert "living" in ids and word in warnings_of(document)
