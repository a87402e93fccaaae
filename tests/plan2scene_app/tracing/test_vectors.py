from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy import ndimage
from shapely.geometry import Polygon, box

from plan2scene.plans.plan_json import FORMAT
from plan2scene_app.tracing import rooms as outlines
from plan2scene_app.tracing.openings import find_openings
from plan2scene_app.tracing.picture import main_direction
from plan2scene_app.tracing.regions import find_regions, structure_of
from plan2scene_app.tracing.settings import DOOR, OUTSIDE, PASSAGE, ROOM, WALL, WINDOW
from plan2scene_app.tracing.trace import without_loose_openings

from .conftest import PPM, as_probabilities, flat_labels, line, rooms_alone


def traced(probabilities):
    regions = find_regions(structure_of(probabilities), PPM)
    return regions, outlines.room_polygons(regions)


def described(probabilities):
    """Return what `traced` and its openings are of a flat whose left room has a written name."""
    regions, polygons = traced(probabilities)
    openings = find_openings(regions, polygons, probabilities)
    lines = [line("Chambre 1", 3.0 * PPM, 2.0 * PPM), line("11.31 m²", 3.0 * PPM, 2.4 * PPM)]
    return regions, openings, outlines.describe_rooms(regions, polygons, probabilities, lines)


def test_a_slanted_wall_stays_slanted():
    labels = flat_labels()
    rows, columns = np.indices(labels.shape)
    corner = (columns - 1.1 * PPM) + (rows - 1.1 * PPM)
    labels[(corner < 1.5 * PPM) & (labels >= ROOM)] = 1
    labels[(corner < 1.35 * PPM) & (rows < 2.4 * PPM) & (columns < 2.4 * PPM)] = 0
    regions, polygons = traced(as_probabilities(labels))
    cut = min(polygons.values(), key=lambda p: p.centroid.x)
    assert len(cut.exterior.coords) == 6
    assert cut.area == pytest.approx((regions.rooms == 1).sum(), rel=0.03)


def test_a_narrow_part_of_an_outline_is_none():
    room = box(10.0, 20.0, 200.0, 120.0)
    sharp = room.union(Polygon([(16.0, 20.0), (18.0, 12.0), (18.0, 20.0)]))  # as of a slanted line
    assert outlines.without_spikes(sharp, 5.0).equals(room)
    alcove = room.union(box(10.0, 10.0, 18.0, 20.0))
    assert outlines.without_spikes(alcove, 5.0) is alcove


def test_floor_that_goes_on_is_a_passage():
    labels = flat_labels()
    x0, x1 = round(4.9 * PPM), round(5.2 * PPM)
    labels[:, x0:x1][labels[:, x0:x1] > 1] = 1  # no door
    labels[slice(round(2.1 * PPM), round(2.55 * PPM)), x0:x1] = ROOM
    probabilities = as_probabilities(labels)
    regions, polygons = traced(probabilities)
    assert regions.count == 2
    between = [o for o in find_openings(regions, polygons, probabilities) if o.other]
    assert [(o.kind, o.full) for o in between] == [("passage", False)]


@pytest.mark.parametrize(
    ("label", "box"),
    [(PASSAGE, (5, 1.2, 5.1, 1.7)), (DOOR, (4, 4, 4.9, 4.1)), (PASSAGE, (5, 1.1, 5.1, 4))],
    ids=["a part of it is drawn", "a door around the corner", "all of it is drawn"],
)
def test_rooms_that_meet_without_a_wall_are_open_all_along(label, box):
    labels = flat_labels()
    regions, polygons = traced(as_probabilities(np.where(labels == DOOR, WALL, labels)))
    labels[round(1.1 * PPM) : round(4.0 * PPM), round(4.9 * PPM) : round(5.2 * PPM)] = ROOM
    x0, y0, x1, y1 = (round(value * PPM) for value in box)
    labels[y0:y1, x0:x1] = label
    regions = replace(regions, structure=np.minimum(labels, ROOM))
    between = [o for o in find_openings(regions, polygons, as_probabilities(labels)) if o.other]
    assert [o.kind for o in between] == ["passage"]
    assert between[0].width == pytest.approx(2.9 * PPM, rel=0.1)
    assert between[0].full is (box[3] < 4.0 or label == DOOR)  # else it is drawn with a lintel


def test_the_strip_of_a_cupboard_along_a_wall_is_no_passage():
    labels = np.where(flat_labels() == DOOR, WALL, flat_labels())
    regions, polygons = traced(as_probabilities(labels))
    strip = labels.copy()
    strip[round(1.1 * PPM) : round(4.0 * PPM), round(4.8 * PPM) : round(5.3 * PPM)] = ROOM
    strip[:, round(4.7 * PPM) : round(4.8 * PPM)] = strip[:, round(5.3 * PPM)] = WALL
    regions = replace(regions, structure=np.minimum(strip, ROOM))
    assert not [o for o in find_openings(regions, polygons, as_probabilities(labels)) if o.other]


@pytest.mark.parametrize(("line_px", "thin"), [(1, True), (3, False)])
def test_what_lies_behind_a_thin_line_belongs_to_its_room(line_px, thin):
    labels, _ = rooms_alone()
    labels[33:120, 150:153] = WALL  # without the door between both rooms
    labels[33:120, 137 - line_px : 137] = WALL  # the front of a cupboard of 43 cm
    regions = find_regions(labels, PPM)
    assert regions.count == 2
    assert regions.floors[60, 143] == (regions.floors[60, 60] if thin else 0)


def test_closed_rooms_taken_for_outside_are_rooms_and_a_light_well_is_none():
    labels = flat_labels()
    assert find_regions(np.where(labels >= ROOM, OUTSIDE, labels), PPM).count == 2
    well = np.where(labels == WINDOW, WALL, labels)
    well[well == 8] = OUTSIDE
    well = np.where((labels == DOOR) & (np.arange(labels.shape[1]) > 4.5 * PPM), WINDOW, well)
    assert find_regions(np.minimum(well, ROOM), PPM).count == 1


def test_a_name_is_no_word_of_appliances_and_joins_the_rooms_of_an_open_one(probabilities):
    regions, polygons = traced(probabilities)
    words = {
        "LIVING": (1.8, 1.5, 40),
        "CUB": (1.3, 3.5, 12),
        "DINING": (3.8, 1.6, 40),
        "Dining": (3.5, 3.0, 40),
        "Front": (6.5, 2.0, 30),
        "Bedroom": (6.5, 2.3, 40),
        "FRIDGE": (6.5, 3.7, 30),
    }
    lines = [line(text, x * PPM, y * PPM, (width, 8.0)) for text, (x, y, width) in words.items()]
    rooms = outlines.describe_rooms(regions, polygons, probabilities, lines)
    assert sorted(room.name for room in rooms) == ["Front Bedroom", "LIVING / DINING"]


def test_rooms_are_named_by_text_else_by_furniture(probabilities):
    named, other = sorted(described(probabilities)[2], key=lambda r: not r.named)
    assert (named.id, named.types, named.name) == ("chambre_1", ("Bedroom",), "Chambre 1")
    assert (other.id, other.types, other.named) == ("kitchen", ("Kitchen",), False)
    assert len(named.texts) == 2 and named.confidence > 0.8


@pytest.mark.parametrize(
    ("step", "treads", "kind"),
    [(None, 0.0, "Unknown"), (5, 0.4, "Staircase"), (20, 0.0, "Bathroom"), (0, 0.0, "Bathroom")],
)
def test_marks_tell_what_an_unnamed_room_is(step, treads, kind):
    labels = flat_labels()
    labels[labels == 8] = ROOM
    probabilities = as_probabilities(labels)
    if step == 0:  # the network knows its fixtures
        probabilities = as_probabilities(np.where(labels == ROOM, 9, labels))
    regions, openings, rooms = described(probabilities)
    image = np.full((*labels.shape, 3), 255, np.uint8)
    if step:
        image[:, round(5.1 * PPM) :: step] = 0
    taken = {room.number: treads for room in rooms}
    found = outlines.with_types_by_marks(rooms, openings, regions, image, taken, 1 / PPM)
    assert {room.types for room in found} == {("Bedroom",), (kind,)}
    rooms = [replace(room, named=False) for room in rooms]
    found = outlines.with_types_by_marks(rooms, openings, regions, image, taken, 1 / PPM)
    assert {r.types for r in found} == ({("Staircase",)} if treads else {r.types for r in rooms})


def test_a_plan_that_names_a_bedroom_names_all():
    labels = flat_labels()
    probabilities = as_probabilities(np.where(labels == 8, ROOM + 2, labels))
    regions, openings, rooms = described(probabilities)
    assert [room.types for room in rooms] == [("Bedroom",)] * 2
    basin = np.full((*labels.shape, 3), 255, np.uint8)  # round: as what a door sweeps
    for radius in range(6, 30, 3):
        cv2.circle(basin, (round(6.5 * PPM), round(2.0 * PPM)), radius, (0, 0, 0))
    taken = {room.number: 0.0 for room in rooms}
    found = outlines.with_types_by_marks(rooms, openings, regions, basin, taken, 1 / PPM)
    assert sorted(room.types for room in found) == [("Bathroom",), ("Bedroom",)]


@pytest.mark.parametrize("angle", [0.0, 3.0, -20.0, 40.0])
def test_a_turned_plan_is_straightened(angle):
    walls = np.pad(flat_labels() == 1, 80).astype(np.float32)
    turned = ndimage.rotate(walls, -angle, reshape=False, order=1)
    assert main_direction(turned) == pytest.approx(angle, abs=0.8)


def test_an_opening_without_a_wall_is_left_out():
    square = [[0, 0], [4, 0], [4, 3], [0, 3]]
    door = {"id": "door_0", "kind": "door", "from": [1, 0], "to": [2, 0], "bottom": 0, "top": 2}
    loose = door | {"id": "door_1", "from": [1, 1.5], "to": [2, 1.5]}
    rooms = [{"id": "room", "types": ["Bedroom"], "polygon": square}]
    plan = {"format": FORMAT, "version": 1, "wall_depth": 0.1, "rooms": rooms}
    kept, lines = without_loose_openings({**plan, "openings": [door, loose]}, "plan.png")
    assert kept["openings"] == [door]
    assert lines == ["a door at 1.5, 1.5 m is left out: no wall is near"]
    assert without_loose_openings(kept, "plan.png") == (kept, [])
