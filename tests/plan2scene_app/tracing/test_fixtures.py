import cv2
import numpy as np
import pytest
import shapely
from flat_picture import PPM, flat_picture

from plan2scene.images import write_png
from plan2scene.plans.formats import read_plan
from plan2scene_app.tracing import trace
from plan2scene_app.tracing.fixtures import (
    TracedFixture,
    with_types_by_fixtures,
    worktops_and_fixtures,
)
from plan2scene_app.tracing.lettering import TextLine
from plan2scene_app.tracing.rooms import TracedRoom
from plan2scene_app.tracing.settings import FIXTURE_LABELS, FIXTURE_PPM
from plan2scene_app.tracing.trace import write_trace


def test_a_worktop_round_a_corner_is_cut_at_its_sink_and_stove():
    labels = np.zeros((160, 160), int)

    def put(kind, *metres):
        x0, y0, x1, y1 = (round(v * FIXTURE_PPM) for v in metres)
        labels[y0:y1, x0:x1] = FIXTURE_LABELS.index(kind)

    put("counter", 0, 0, 3, 0.6)
    put("counter", 0, 0.6, 0.6, 2.5)
    put("stove", 0.05, 1.0, 0.55, 1.6)
    put("sink", 1.5, 0.1, 2.0, 0.5)
    put("toilet", 3, 3, 3.4, 3.7)  # no kitchen has one
    probabilities = np.eye(len(FIXTURE_LABELS))[labels].transpose(2, 0, 1)
    boxes = worktops_and_fixtures(probabilities, ("sink", "stove"))
    assert {(kind, *(round(v / FIXTURE_PPM, 2) for v in box)) for kind, box in boxes} == {
        ("counter", 0.0, 0.0, 1.5, 0.6),
        ("sink_unit", 1.5, 0.0, 2.0, 0.6),
        ("counter", 2.0, 0.0, 3.0, 0.6),
        ("counter", 0.0, 0.6, 0.6, 1.0),
        ("stove", 0.0, 1.0, 0.6, 1.6),
        ("counter", 0.0, 1.6, 0.6, 2.5),
    }


@pytest.mark.parametrize(
    "kind, named, side, fixtures, types, kept",
    [
        ("Unknown", False, 2, ["toilet"], ("Bathroom",), 1),
        ("Bedroom", False, 2, ["toilet", "sink_unit"], ("Bathroom",), 2),
        ("Bedroom", False, 2, ["toilet"], ("Bedroom",), 0),  # a chair, taken for a toilet
        ("Unknown", False, 5, ["toilet", "bath"], ("Unknown",), 0),
        ("Unknown", True, 2, ["toilet"], ("Unknown",), 0),
        ("Reception", False, 5, ["sink_unit", "counter", "stove"], ("Reception", "Kitchen"), 3),
        ("Bedroom", False, 5, ["sink_unit", "counter", "toilet"], ("Bedroom",), 0),
    ],
)
def test_fixtures_tell_what_an_unnamed_room_is(kind, named, side, fixtures, types, kept):
    polygon = shapely.box(0, 0, 10 * side, 10 * side)
    room = TracedRoom(1, polygon, "one", "", (kind,), named, 1.0, ())
    drawn = [TracedFixture(fixture, 1, (0, 0), (5, 5)) for fixture in fixtures]
    (typed,), fitting = with_types_by_fixtures([room], drawn, metres=0.1)
    assert (typed.types, len(fitting)) == (types, kept)


def test_drawn_fixtures_stand_in_the_house(tmp_path, monkeypatch):
    image, thin = flat_picture(), ((0, 0, 0), 1, cv2.LINE_AA)

    def box(*metres):
        return [round(v * PPM) for v in metres]

    for x0, y0, x1, y1 in ((7.15, 5.2, 8.98, 5.98), (7.25, 5.3, 8.88, 5.88), (8.8, 3, 8.98, 3.45)):
        cv2.rectangle(image, box(x0, y0), box(x1, y1), *thin)  # a bath, its inside, a tank
    cv2.circle(image, box(7.4, 5.59), 2, *thin)
    for x, rx, ry in ((8.52, 0.28, 0.19), (8.54, 0.2, 0.13)):  # the bowl
        cv2.ellipse(image, box(x, 3.225), box(rx, ry), 0, 0, 360, *thin)
    write_png(tmp_path / "flat.png", image)
    lines = [TextLine("Bad 19.4 m2", (350.0, 200.0), (80.0, 12.0), 0.99)]
    monkeypatch.setattr(trace, "reader_installed", lambda: True)
    monkeypatch.setattr(trace, "lines_of", lambda image, told: lines)
    _, told = write_trace(tmp_path / "flat.png", tmp_path / "plan.json")
    assert any(line.startswith("fixtures in bad: read from the drawing") for line in told)
    found = {i.type: (*i.p1, *i.p2) for i in read_plan(tmp_path / "plan.json", "flat").icons}
    assert found.keys() == {"bath", "toilet"}
    assert found["bath"] == pytest.approx((6.15, 4.2, 7.98, 4.98), abs=0.25)
    assert found["toilet"] == pytest.approx((7.25, 2.0, 7.98, 2.45), abs=0.25)
