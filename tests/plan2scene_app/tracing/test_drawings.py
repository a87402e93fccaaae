import cv2
import numpy as np
import pytest

from plan2scene_app.tracing.drawings import find_drawings, shows_a_home, storey_told, storeys_of
from plan2scene_app.tracing.looks import Look, drawn_homes
from plan2scene_app.tracing.named_areas import with_named_areas
from plan2scene_app.tracing.open_rooms import with_open_rooms
from plan2scene_app.tracing.picture import Frame
from plan2scene_app.tracing.regions import find_regions
from plan2scene_app.tracing.rooms import room_polygons
from plan2scene_app.tracing.settings import DOOR, OUTSIDE, ROOM, STAIRS, WALL, WINDOW

from .conftest import PPM, as_probabilities, flat_labels, line, solid_page


def test_parts_with_blank_paper_between_are_drawings():
    page = np.full((600, 1000, 3), 255, np.uint8)
    cv2.rectangle(page, (40, 300), (440, 560), (0, 0, 0), 6)
    cv2.rectangle(page, (500, 60), (900, 360), (0, 0, 0), 6)
    cv2.rectangle(page, (200, 400), (260, 460), (0, 0, 0), 2)  # a table in the first
    cv2.circle(page, (950, 550), 20, (0, 0, 0), 2)  # a compass
    numbers, count = find_drawings(page)
    assert count == 2 and numbers[580, 20] == 0 and numbers[550, 950] == 0
    assert {int(numbers[y, x]) for x, y in ((40, 400), (200, 430))} == {int(numbers[300, 100])}
    assert numbers[60, 700] not in (0, numbers[300, 100])
    assert shows_a_home(np.minimum(flat_labels(), ROOM))
    assert not shows_a_home(np.where(flat_labels() >= ROOM, ROOM, WALL).astype(np.uint8))
    look = Look(1, Frame(page, np.eye(2, 3)), np.zeros(0), np.minimum(flat_labels(), ROOM))
    photo = np.random.default_rng(0).integers(0, 255, page.shape, np.uint8)
    assert drawn_homes([look], page) == [look] and drawn_homes([look], photo) == []
    table = np.where(flat_labels() == DOOR, WINDOW, np.minimum(flat_labels(), ROOM))
    assert not shows_a_home(table.astype(np.uint8))


CAPTIONS = {
    0: "GROUND FL|Planta baja",
    1: "1st Floor|Obergeschoss",
    -1: "Keller",
    None: "Obergeschoß|Bedroom|a first look at the new house",
}


@pytest.mark.parametrize("height", CAPTIONS)
def test_captions(height):
    assert {storey_told(text) for text in CAPTIONS[height].split("|")} == {height}


def test_storeys_lie_on_one_another_by_walls_and_stairs():
    owner, rooms = np.zeros((200, 500), np.int32), np.zeros((200, 500), np.int32)
    owner[:, :250], owner[:, 250:] = 1, 2
    rooms[50:150, 20:220], rooms[60:160, 290:370] = 1, 2
    labels = np.zeros(owner.shape, np.uint8)
    labels[50:80, 100:140] = labels[60:90, 310:350] = STAIRS
    lines = [line("Ground floor", 330, 180), line("First floor", 120, 170)]
    low, high = storeys_of(owner, rooms, as_probabilities(labels), lines, PPM)
    assert (low.drawing, high.drawing, low.floor, high.floor) == (2, 1, 0, 1)
    assert low.shift == (0, 0) and high.shift == pytest.approx((210, 10), abs=4)
    low, _ = storeys_of(owner, rooms, as_probabilities(labels), [], PPM)
    assert low.drawing == 1 and not low.told


def test_dashed_lines_around_a_name_close_a_room():
    labels = np.minimum(flat_labels(), ROOM)
    page = solid_page(labels)
    for x in range(243, 264, 6):
        page[60, x : x + 4] = page[90, x : x + 4] = 0
    page[60:91, 266] = 0
    found = with_named_areas(labels, page, [(255.0, 75.0), (20.0, 20.0)], [], PPM)
    assert found[75, 255] == ROOM and found[20, 20] == OUTSIDE and found[75, 266] == WALL
    labels[65:85, 245:260] = ROOM  # a part is seen, without borders
    found = with_named_areas(labels, page, [(255.0, 75.0)], [(255.0, 75.0)], PPM)
    assert found[61, 262] == ROOM and found[75, 266] == WALL
    page[60:91, 266] = 255
    assert (with_named_areas(labels, page, *2 * [[(255.0, 75.0)]], PPM) == labels).all()


@pytest.mark.parametrize("sized", [True, False])
def test_an_open_floor_with_two_names_is_divided(sized):
    structure = np.full((200, 330), OUTSIDE, np.uint8)
    structure[20:180, 20:310], structure[24:176, 24:306] = WALL, ROOM
    regions = find_regions(structure, PPM)
    page = np.full((200, 330, 3), 255, np.uint8)
    lines = [line("Kitchen", 90, 100), line("Living", 260, 100)]
    metres = 1 / PPM
    if sized:
        lines.append(line(f"{152 / PPM:.2f} x {180 / PPM:.2f} m", 90, 114))
    else:
        page[24:176, 204] = 200  # a faint line
    polygons = room_polygons(regions)
    found = with_open_rooms(regions, polygons, page, lines, metres)
    assert found.count == 2 and found.floors[100, 90] != found.floors[100, 260]
    assert np.count_nonzero(found.floors[100] == found.floors[100, 90]) == pytest.approx(180, abs=4)
    same = [line("Lounge", 90, 100), line("Living", 260, 100)]
    assert with_open_rooms(regions, polygons, page, same, metres) is regions
    regions.structure[20:24, 190:220] = DOOR  # a line that would halve a door divides nothing
    halved = with_open_rooms(regions, polygons, page, lines[:2], metres)
    assert halved.floors[100, 90] == halved.floors[100, 260]
