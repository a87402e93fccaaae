import copy
import json
from pathlib import Path

import pytest

from plan2scene.errors import InputError
from plan2scene.plans.formats import read_plan
from plan2scene.plans.validate import house_faults, validate_house

EXAMPLES = Path(__file__).parents[3] / "resources" / "examples"
EXAMPLE = json.loads((EXAMPLES / "plan.json").read_text())
STOREYS = json.loads((EXAMPLES / "two_storeys" / "plan.json").read_text())


def square(x0, z0, x1, z1):
    return [[x0, z0], [x1, z0], [x1, z1], [x0, z1]]


def room(name, ring, types=("Bedroom",), **more):
    return {"id": name, "types": list(types), "polygon": ring, **more}


def plan(*rooms, openings=(), **more):
    found = {"format": "plan2scene-plan", "version": 1, "rooms": list(rooms)}
    return found | {"openings": list(openings), **more}


def hole(kind, start, end, bottom=0.0, top=2.0, **more):
    return {"kind": kind, "from": start, "to": end, "bottom": bottom, "top": top, **more}


def changed(path, value, example=EXAMPLE):
    document = copy.deepcopy(example)
    *way, last = path
    entry = document
    for key in way:
        entry = entry[key]
    if value is None:
        del entry[last]
    else:
        entry[last] = value
    return document


ATTIC = {"id": "attic", "elevation": 5.6, "height": 2.2}
STOREY_CHANGES = {
    "no level of a room": (["rooms", 0, "level"], None),
    "a level of no text": (["rooms", 7, "level"], 7),
    "an unknown level": (["rooms", 0, "level"], "attic"),
    "an unknown level of a door": (["openings", 0, "level"], "attic"),
    "no levels": (["levels"], None),
    "a level without rooms": (["levels"], [*STOREYS["levels"], ATTIC]),
    "levels of one id": (["levels", 1, "id"], "ground"),
    "levels too near": (["levels", 1, "elevation"], 0.3),
    "a ceiling above the next floor": (["rooms", 1, "height"], 2.9),
    "a level that is not high": (["levels", 0, "height"], 1.5),
    "no stairs": (["stairs"], []),
    "stairs of no level": (["stairs", 0, "level"], None),
    "stairs on top": (["stairs", 0, "level"], "upper"),
    "stairs beside the house": (["stairs", 0, "from"], [-3, 4.6]),
    "stairs into a wall": (["stairs", 0, "to"], [0.45, -1]),
    "stairs along a wall": (["stairs", 0, "to"], [0.05, 1]),
    "stairs through a wall": (["stairs", 0, "to"], [3.5, 3]),
    "steep stairs": (["stairs", 0, "to"], [0.45, 3.4]),
    "short stairs": (["stairs", 0, "to"], [0.45, 4.3]),
    "wide stairs": (["stairs", 0, "width"], 20),
    "stairs far away": (["stairs", 0, "to"], [0.45, 4000]),
    "stairs id twice": (["stairs"], STOREYS["stairs"] * 2),
    "a window of the other level": (["openings", 5, "level"], "upper"),
    "a door that only the other level has a wall for": (["openings", 3, "level"], "upper"),
    "a room over another": (["rooms", 4, "level"], "ground"),
}
A, B = room("a", square(0, 0, 4, 3)), room("b", square(4, 0, 7, 3), ["Kitchen", "reception"])
BOW = [[0, 0], [3, 3], [3, 0], [0, 3]]
PLANS = {
    "example": EXAMPLE,
    "two rooms": plan(A, B, openings=[hole("door", [4, 1], [4, 1.9])]),
    "gap": plan(A, room("b", square(4.15, 0, 7, 3)), openings=[hole("door", [4.08, 1], [4.08, 2])]),
    "turned": plan(A, room("b", square(4, 0, 7, 3)[::-1])),
    "with a hole": plan(room("a", square(0, 0, 6, 6), holes=[square(2, 2, 3, 3)])),
    "no version": changed(["version"], None),
    "wrong version": changed(["version"], 2),
    "no rooms": changed(["rooms"], []),
    "unknown key": changed(["rooms", 0, "colour"], "red"),
    "id with a space": changed(["rooms", 1, "id"], "my hall"),
    "text for a number": changed(["rooms", 1, "height"], "2.7"),
    "no height": changed(["rooms", 1, "height"], None),
    "height of 0": changed(["rooms", 1, "height"], 0),
    "height of 0.4": changed(["rooms", 1, "height"], 0.4),
    "height of 1.7": changed(["rooms", 4, "height"], 1.7),
    "height of 40": changed(["rooms", 1, "height"], 40),
    "thick walls": changed(["wall_depth"], 2),
    "two points": changed(["rooms", 0, "polygon"], [[0, 0], [1, 1]]),
    "three numbers": changed(["rooms", 0, "polygon", 0], [0, 0, 0]),
    "unknown type": changed(["rooms", 0, "types"], ["Ballroom"]),
    "unknown label": changed(["rooms", 0, "types"], ["ballroom"]),
    "no types": changed(["rooms", 0, "types"], []),
    "type twice": changed(["rooms", 0, "types"], ["Kitchen", "Kitchen"]),
    "unknown kind": changed(["openings", 0, "kind"], "gate"),
    "top below bottom": changed(["openings", 5, "top"], 0.5),
    "below the floor": changed(["openings", 5, "bottom"], -0.5),
    "above the wall": changed(["openings", 5, "top"], 2.9),
    "opening far from walls": changed(["openings", 5, "from"], [2, 2]),
    "opening without length": changed(["openings", 5, "from"], EXAMPLE["openings"][5]["to"]),
    "opening over the corner": changed(["openings", 5, "from"], [0, -0.6]),
    "opening id twice": changed(["openings", 1, "id"], "front_door"),
    "far away": changed(["rooms", 0, "polygon", 0], [-2000, 0]),
    "room id twice": plan(A, room("a", square(4, 0, 7, 3))),
    "crossing itself": plan(A, room("b", [[x + 5, z] for x, z in BOW])),
    "a spike": plan(room("a", [[0, 0], [4, 0], [6, 0], [4, 0], [4, 3], [0, 3]])),
    "no area": plan(A, room("b", [[4, 0], [5, 0], [6, 0]])),
    "points repeated": plan(room("a", [[0, 0], [0, 0], [1, 1], [1, 1]])),
    "centimetres": plan(room("a", square(0, 0, 400, 300)), room("b", square(400, 0, 700, 300))),
    "feet": plan(
        room("a", square(0, 0, 13, 10)),
        room("b", square(13, 0, 23, 10)),
        openings=[hole("door", [13, 3], [13, 5.8])],
    ),
    "a doll's house": plan(room("a", square(0, 0, 0.4, 0.3)), room("b", square(0.4, 0, 0.7, 0.3))),
    "overlap": plan(A, room("b", square(3.5, 0, 7, 3))),
    "one in another": plan(room("a", square(0, 0, 8, 8)), room("b", square(2, 2, 4, 4))),
    "skew overlap": plan(A, room("b", [[3, 1], [6, -1], [8, 2], [5, 4]])),
    "islands": plan(A, room("b", square(20, 0, 24, 3)), room("c", square(24, 0, 28, 3))),
    "a narrow hole": plan(A, openings=[hole("window", [1, 0], [1.1, 0], 1, 2)]),
    "holes over each other": plan(
        A, openings=[hole("window", [1, 0], [2, 0], 1, 2), hole("door", [1.5, 0], [2.4, 0])]
    ),
    "holes above each other": plan(
        A, openings=[hole("window", [1, 0], [2, 0], 2.1, 2.5), hole("door", [1.1, 0], [2, 0])]
    ),
    "ids by case": plan(room("Bed", square(0, 0, 4, 3)), room("bed", square(4, 0, 7, 3))),
    "a device": plan(room("aux.1", square(0, 0, 4, 3))),
    **{f"storeys: {name}": changed(*change, STOREYS) for name, change in STOREY_CHANGES.items()},
    "storeys": STOREYS,
    "very wide": plan(*(room(f"r{k}", square(4 * k, 0, 4 * k + 4, 3)) for k in range(30))),
}


def verdict(document, path):
    path.write_text(json.dumps(document))
    try:
        house = read_plan(path, "home")
        if fault := next(house_faults(house), None):
            return {("error", fault.expected)}
        phrases = (line.split("expected ", 1)[1] for line in validate_house(house))
        return {("warning", phrase.rsplit(", found ", 1)[0]) for phrase in phrases}
    except InputError as error:
        return {("error", error.expected)}


@pytest.fixture(scope="module")
def verdicts_of_the_page(browser, empty_page):
    page = browser.new_page()
    page.goto(empty_page.as_uri())
    script = "(plans) => plans.map((plan) => editor.check(plan))"
    found = page.evaluate(script, list(PLANS.values()))
    page.close()
    return dict(zip(PLANS, found, strict=True))


@pytest.mark.parametrize("name", PLANS)
def test_page_and_reader_agree(name, verdicts_of_the_page, tmp_path):
    told = {(p["level"], p["expected"]) for p in verdicts_of_the_page[name]}
    read = verdict(PLANS[name], tmp_path / "plan.json")
    if any(level == "error" for level, _ in read):
        # The reader stops where it can't go on; what it says, the page says.
        assert read <= told
    else:
        assert told == read
