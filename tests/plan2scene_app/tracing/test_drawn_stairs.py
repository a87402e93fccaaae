import numpy as np
import pytest
from shapely.geometry import box

from plan2scene_app.tracing.drawings import Storey
from plan2scene_app.tracing.drawn_stairs import covered, find_treads, flights_of
from plan2scene_app.tracing.rooms import TracedRoom

from .conftest import PPM


def page_with_treads(count, depth, *, turned=False, left=60, top=50):
    """Return a page (300, 300, 3) with lines of .9 m between two stringers, `depth` px apart."""
    page = np.full((300, 300, 3), 255, np.uint8)
    for number in range(count):
        page[top + number * depth, left : left + 27] = 0
    page[top : top + (count - 1) * depth, [left - 1, left + 27]] = 0
    return page.transpose(1, 0, 2) if turned else page


@pytest.mark.parametrize("turned", [False, True])
def test_lines_at_even_distances_are_treads(turned):
    (treads,) = find_treads(page_with_treads(9, 8, turned=turned), PPM)
    assert treads.upright is not turned
    expected = (60, 46, 87, 118)
    found = treads.box if not turned else np.array(treads.box)[[1, 0, 3, 2]]
    assert found == pytest.approx(expected, abs=2)
    floor = np.zeros((300, 300), bool)
    floor[40:140, 60:87] = True
    assert covered([treads], floor.T if turned else floor) == pytest.approx(0.72, abs=0.04)


@pytest.mark.parametrize(("count", "depth"), [(4, 8), (9, 3), (9, 15)])
def test_few_or_other_lines_are_none(count, depth):
    assert find_treads(page_with_treads(count, depth), PPM) == []


def test_uneven_lines_and_tiles_are_no_treads():
    page = page_with_treads(9, 8)
    page[50:120:8, 60:87] = 255
    for y in (50, 56, 68, 73, 85, 92, 103):
        page[y, 60:87] = 0
    assert find_treads(page, PPM) == []
    page = page_with_treads(5, 8)
    page[50:83, 60:87:6] = 0
    assert find_treads(page, PPM) == []


def room(number, drawing, *bounds):
    types = ("Corridor",)
    return TracedRoom(number, box(*bounds), f"r{number}", "", types, False, 1.0, (), drawing)


STOREYS = [Storey(1, "ground", 0, (0.0, 0.0), True), Storey(2, "first", 1, (-150.0, 0.0), True)]


@pytest.mark.parametrize("lower_drawn", [True, False])
def test_a_flight_goes_up_from_where_one_walks_on(lower_drawn):
    # One walks on from above in the picture (y 10 to 46); on the upper storey off below.
    rooms = [room(1, 1, 50, 10, 140, 122), room(2, 2, 200, 46, 300, 200)]
    upper = find_treads(page_with_treads(7, 8, left=210, top=66), PPM)
    lower = find_treads(page_with_treads(9, 8), PPM) if lower_drawn else []
    (flight,) = flights_of([*lower, *upper], rooms, STOREYS, 1 / PPM)
    assert flight.storey == 0 and flight.width == pytest.approx(27, abs=2)
    (x0, y0), (x1, y1) = flight.start, flight.end
    assert x0 == x1 == pytest.approx(73.5, abs=1) and y0 < y1
    assert y0 == pytest.approx(46 if lower_drawn else 62, abs=2)
    assert y1 == pytest.approx(118, abs=2)


def test_a_flight_ends_before_a_wall_and_lies_in_a_room():
    rooms = [room(1, 1, 50, 10, 140, 122), room(2, 2, 200, 44, 300, 112)]
    (flight,) = flights_of(find_treads(page_with_treads(9, 8), PPM), rooms, STOREYS, 1 / PPM)
    assert flight.end[1] == pytest.approx(112 - 0.35 * PPM, abs=1)  # one steps off before it
    treads = find_treads(page_with_treads(9, 8, left=160), PPM)
    assert flights_of(treads, rooms, STOREYS, 0.03) == []
