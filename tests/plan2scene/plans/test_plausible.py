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


def plan(factor=1.0):
    document = json.loads(PLAN.read_text())
    for entry in (*document["rooms"], *document["openings"]):
        entry.update({key: scaled(entry[key], factor) for key in KEYS if key in entry})
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
