from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy import ndimage
from shapely.geometry import box

from plan2scene_app.tracing import ink as marks
from plan2scene_app.tracing import rooms as outlines
from plan2scene_app.tracing.double_walls import with_filled_walls
from plan2scene_app.tracing.looks import Look
from plan2scene_app.tracing.named_areas import without_counters
from plan2scene_app.tracing.openings import TracedOpening, find_openings
from plan2scene_app.tracing.picture import Frame
from plan2scene_app.tracing.regions import find_regions
from plan2scene_app.tracing.settings import DOOR, OUTSIDE, PASSAGE, ROOM, WALL, WINDOW
from plan2scene_app.tracing.thin_walls import with_thin_walls

from .conftest import PPM, as_probabilities, flat_labels, rooms_alone, solid_page


def traced(labels, sure=0.9):
    regions = find_regions(labels, PPM)
    polygons = outlines.room_polygons(regions)
    return regions, polygons, find_openings(regions, polygons, as_probabilities(labels, sure))


@pytest.mark.parametrize("arc", [True, False])
def test_an_arc_makes_a_window_a_door(arc):
    labels = flat_labels()
    page = solid_page(labels)
    if arc:
        cv2.ellipse(page, (180, 33), (45, 45), 0, 0, 90, (0, 0, 0), 1)
    found = marks.with_drawn_doors(labels, page, PPM)
    assert found[31, 200] == (DOOR if arc else WINDOW)
    assert (found == ROOM).sum() == (labels == ROOM).sum()


def test_a_gap_in_a_wall_between_rooms_is_a_door():
    labels, page = rooms_alone()
    labels[60:87, 150:153] = WALL  # the door between both rooms
    assert (marks.with_drawn_doors(labels, page, PPM)[62:85, 151] == DOOR).all()
    page[:] = 255  # walls that are not solid
    assert marks.with_drawn_doors(labels, page, PPM) is labels


def test_a_solid_wall_that_the_network_misses_goes_on():
    labels = flat_labels()
    page = solid_page(labels)
    cv2.rectangle(page, (5, 5), (20, 20), (0, 0, 0), -1)  # a mark beside the plan is no wall
    partly = labels.copy()
    partly[:, 230:] = np.where(partly[:, 230:] == WALL, OUTSIDE, partly[:, 230:])
    found = marks.with_drawn_walls(partly, page, PPM)
    assert (found[labels == WALL] == WALL).all()
    assert (found[5:21, 5:21] == labels[5:21, 5:21]).all()


@pytest.mark.parametrize(("ink", "kind"), [(255, PASSAGE), (215, PASSAGE), (0, WALL)])
def test_a_wide_gap_between_rooms_with_a_faint_line_is_a_passage(ink, kind):
    labels, page = rooms_alone()
    page[50:110, 150:153] = 255
    page[50:110, 151] = ink  # a threshold, or a wall drawn as one line
    labels[50:110, 150:153] = WALL
    labels[60:80, 150:153] = WINDOW
    found = marks.with_drawn_doors(labels, page, PPM)[50:110, 151]
    assert (found[2:-2] == kind).mean() > 0.6 and (PASSAGE in found) == (kind == PASSAGE)


def test_where_doors_swing_a_blank_gap_is_a_passage():
    labels, _ = rooms_alone()
    hinges = (60, 105, 180)
    for hinge in hinges:
        labels[120:123, hinge : hinge + 27] = DOOR
    page = solid_page(labels)
    for hinge in hinges:
        cv2.ellipse(page, (hinge, 121), (27, 27), 0, -90, 0, (0, 0, 0), 1)
    found = marks.with_drawn_doors(labels, page, PPM)
    assert (found[62:85, 151] == PASSAGE).all() and (found[121, 62:85] == DOOR).all()
    page[120:123] = np.where(labels[120:123, :, None] == WALL, 0, 255)
    page[93:120] = page[125:150] = 255
    page[labels == WALL] = 0  # without the swings all gaps are doors
    assert (marks.with_drawn_doors(labels, page, PPM)[62:85, 151] == DOOR).all()


@pytest.mark.parametrize("goes_on", [False, True])
def test_an_open_leaf_is_no_wall_unless_a_wall_goes_on_behind_it(goes_on):
    labels, _ = rooms_alone()
    labels[80:120, 88:91] = WALL  # the open leaf, and as much again
    page = solid_page(labels)
    page[80 : 80 if goes_on else 95, 86:93] = 255
    cv2.ellipse(page, (88, 121), (27, 27), 0, 180, 270, (0, 0, 0), 1)  # from 2.0 to 2.9 m
    found = marks.with_drawn_doors(labels, page, PPM)
    assert (found[95:119, 89] == (WALL if goes_on else ROOM)).all()
    assert (found[121, 62:85] == DOOR).all()


def test_a_door_whose_swing_is_drawn_is_a_sure_one():
    labels, page = rooms_alone()
    cv2.ellipse(page, (60, 121), (27, 27), 0, -90, 0, (0, 0, 0), 1)
    regions, _, seen = traced(labels, 0.4)
    found = marks.with_swings(seen, page, regions.wall_px)
    sure = [opening for opening in found if opening.confidence > 0.7]
    assert [opening.kind for opening in sure] == ["door"] and sure[0].start[1] > 115


def test_counters_with_thin_lines_before_them_are_part_of_a_named_kitchen():
    labels, _ = rooms_alone()
    labels[33:51, 195:237] = ROOM
    labels[51:54, 195:240] = labels[30:54, 195:198] = WALL
    page = solid_page(labels)
    page[33:54, 195:239] = 255
    page[52, 195:239] = page[33:52, 196] = 0  # one thin line around a counter
    labels[52, 205:220] = DOOR
    kitchen, bedroom = (170.0, 80.0), (90.0, 80.0)
    found = without_counters(labels, page, [kitchen, bedroom], [kitchen], PPM)
    assert (found[40:60, 210] == ROOM).all() and (found[50:60, 151] == WALL).all()
    named = without_counters(labels, page, [kitchen, (215.0, 40.0)], [kitchen], PPM)
    assert (named == labels).all()
    assert (without_counters(labels, page, [kitchen], [], PPM) == labels).all()


@pytest.mark.parametrize("leaves", [2, 0])
def test_leaves_in_a_gap_that_the_network_takes_for_floor_are_a_door(leaves):
    labels, _ = rooms_alone()
    labels[50:95, 150:153] = ROOM  # a gap of 1.5 m, all floor
    page = solid_page(labels)
    for hinge, start in ((50, 0), (94, 270))[:leaves]:
        cv2.ellipse(page, (151, hinge), (22, 22), 0, start, start + 90, (0, 0, 0), 1)
    found = marks.with_drawn_doors(labels, page, PPM)[51:94, 151]
    assert (found == (DOOR if leaves else ROOM)).all()


def test_a_leaf_that_opens_towards_another_door_leaves_that_whole():
    labels, _ = rooms_alone()
    labels[labels == DOOR] = WALL
    labels[91:118, 150:153] = labels[120:123, 120:147] = DOOR
    page = solid_page(labels)
    for hinge, start in (((150, 118), 180), ((120, 120), 270)):
        cv2.ellipse(page, hinge, (27, 27), 0, start, start + 90, (0, 0, 0), 1)
    found = marks.with_drawn_doors(labels, page, PPM)
    assert (found[121, 120:147] == DOOR).all() and (found[92:117, 151] == DOOR).all()


@pytest.mark.parametrize(("doors", "found"), [(20, [DOOR]), (6, [DOOR, WINDOW])])
def test_a_gap_that_is_half_a_door_and_half_a_window_is_a_door(doors, found):
    labels, _ = rooms_alone()
    labels[30:33, 180 : 180 + doors] = DOOR  # of a window of 45 pixels
    changed = marks.with_drawn_doors(labels, solid_page(labels), PPM)
    assert np.unique(changed[31, 180:225]).tolist() == found


def test_two_doors_that_meet_in_a_corner_are_two():
    labels = flat_labels()
    labels[30:33, 212:243] = labels[30:60, 240:243] = DOOR
    _, _, doors = traced(np.minimum(labels, ROOM))
    widths = sorted(round(o.width / PPM, 1) for o in doors if o.kind == "door")
    assert widths == pytest.approx([0.9, 0.9, 0.9, 1.0], abs=0.15)


def test_thin_lines_part_named_rooms_and_gaps_in_them_are_doors():
    labels = np.zeros((300, 420), np.uint8)
    labels[30:270, 30:390], labels[36:264, 36:384] = WALL, ROOM
    page = solid_page(labels)
    page[36:120, 200] = page[150:264, 200] = 90  # a wall with a gap of a metre
    page[160, 201:384] = 90  # a wall across
    page[60:90, 60] = page[60:90, 90] = page[60, 60:90] = page[90, 60:91] = 90  # a table
    names = [(100.0, 200.0), (300.0, 80.0), (300.0, 220.0)]
    sizes = [(100.0, 200.0, 41.5), (300.0, 80.0, 25.1)]
    unseen = labels.copy()
    assert with_thin_walls(unseen, page, names, sizes, PPM)[0] is unseen
    labels[36:80, 199:202] = labels[150:220, 199:202] = labels[158:163, 210:300] = WALL
    labels[130:140, 199:202] = PASSAGE  # a third of the gap, which the network sees
    found, ppm = with_thin_walls(labels, page, names, sizes, PPM)
    assert ppm == pytest.approx(30, rel=0.03)
    assert (found[125:145, 200] == DOOR).all() and (found[160, 210:380] == WALL).all()
    assert found[75, 62] == ROOM
    assert with_thin_walls(labels, page, names[:1], sizes, PPM)[0] is labels


@pytest.mark.parametrize(
    ("arcs", "leaves", "kind"), [(2, 2, "door"), (2, 0, "window"), (0, 0, "window")]
)
def test_leaves_drawn_at_a_window_make_it_a_door(arcs, leaves, kind):
    labels, page = rooms_alone()
    for hinge, start in ((180, 270), (225, 180))[:arcs]:  # two leaves that open outwards
        cv2.ellipse(page, (hinge, 31), (22, 22), 0, start, start + 90, (0, 0, 0), 1)
        if leaves:
            cv2.line(page, (hinge, 31), (hinge, 9), (0, 0, 0), 1)
    regions, _, openings = traced(labels)

    def kinds(upstairs):
        found = marks.with_swung_windows(openings, page, regions.wall_px, upstairs)
        return sorted(opening.kind for opening in found)

    assert kinds(()) == sorted(["door", "door", kind])
    askew = TracedOpening("window", (180.0, 27.0), (225.0, 35.0), 1, 0, 0.9)  # its outline is
    assert [o.kind for o in marks.with_swung_windows([askew], page, regions.wall_px)] == [kind]
    assert kinds([1, 2]) == ["door", "door", "window"]  # no balcony is behind it


@pytest.mark.parametrize(("missed", "pier"), [(True, False), (False, True)])
def test_a_window_is_as_long_as_its_lines(missed, pier):
    labels, page = rooms_alone()
    page[[30, 32], 180:225] = 0  # two lines for the window's 45 pixels
    if pier:
        page[30:33, 195:210] = 0
    if missed:
        labels[30:33, 192:213] = WALL  # the network sees its ends alone
    regions, polygons, openings = traced(labels)
    found = marks.with_whole_windows(openings, polygons, page, regions.wall_px, PPM)
    widths = [opening.width for opening in found if opening.kind == "window"]
    assert widths == pytest.approx([15, 15] if pier else [45], abs=2)
    assert [o for o in found if o.kind == "door"] == [o for o in openings if o.kind == "door"]


@pytest.mark.parametrize(
    ("blank", "lines", "kind"),
    [
        (slice(193, 212), 1, "door"),  # between two panes one can walk out
        (slice(0, 0), 1, "window"),
        (slice(200, 204), 1, "window"),  # too narrow
        (slice(193, 212), 3, "window"),  # the wall goes on to both sides: two windows
    ],
)
def test_panes_beside_a_blank_are_a_sliding_door(blank, lines, kind):
    labels, page = rooms_alone()
    page[31 : 31 + lines, 180:225] = 0
    page[30:33, blank] = 255
    regions, polygons, openings = traced(labels)
    found = marks.with_sliding_doors(openings, polygons, page, regions.wall_px, PPM, set())
    (outer,) = [o for o in found if not o.other and o.start[1] < 40 and o.start[0] > 150]
    assert outer.kind == kind and outer.width == pytest.approx(45, abs=2)
    assert len(found) == len(openings)


def test_windows_beside_sliding_panes_are_of_their_door():
    labels, _ = rooms_alone()
    labels[30:33, 162:237] = WALL
    page = solid_page(labels)
    page[30:33, 180:225] = 255
    page[31, [*range(180, 193), *range(212, 225)]] = 0  # panes that slide
    labels[30:33, 162:180] = labels[30:33, 225:237] = WINDOW
    labels[30:33, 193:212] = PASSAGE
    regions, polygons, openings = traced(labels)
    found = marks.with_sliding_doors(openings, polygons, page, regions.wall_px, PPM, set())
    (outer,) = [o for o in found if not o.other and o.start[1] < 40]
    assert outer.kind == "door" and outer.width == pytest.approx(75, abs=3)


def test_the_slanted_lines_of_a_bay_are_no_panes():
    labels, page = rooms_alone()
    cv2.line(page, (180, 33), (189, 28), (0, 0, 0), 1)
    cv2.line(page, (224, 33), (215, 28), (0, 0, 0), 1)
    regions, polygons, openings = traced(labels)
    found = marks.with_sliding_doors(openings, polygons, page, regions.wall_px, PPM, set())
    assert found == openings


def test_the_outline_of_an_island_is_no_wall_but_a_pillar_is():
    labels, page = rooms_alone()
    bare = labels.copy()
    for side in ((slice(60, 90), slice(170, 172)), (slice(60, 90), slice(200, 202))):
        labels[side], page[side] = WALL, 0  # thin lines
    labels[62:88, 172:200] = OUTSIDE  # what they enclose
    pillar = slice(60, 70), slice(80, 90)
    labels[pillar], page[pillar] = WALL, 0
    found = marks.without_standing_lines(labels, page, PPM)
    expected = bare.copy()
    expected[62:88, 172:200] = OUTSIDE
    expected[pillar] = WALL
    assert (found == expected).all()


def test_the_widest_window_to_a_terrace_without_a_door_is_one():
    wide = TracedOpening("window", (0.0, 0.0), (80.0, 0.0), 1, 2, 0.9)
    kept = [replace(wide, end=(70, 0)), replace(wide, other=0), replace(wide, room=3, other=1)]
    kept += [replace(wide, room=4, end=(30, 0)), replace(wide, room=5)]  # room 5 has a door
    kept += [replace(wide, room=5, kind="door")]  # one door to a terrace is enough
    door, *others = outlines.with_terrace_doors([wide, *kept], {2}, 60.0)
    assert door == replace(wide, kind="door", confidence=0.5) and others == kept


def test_a_window_all_along_a_terrace_is_its_rail():
    terrace, room = box(0, 0, 100, 50), box(0, 50, 100, 150)
    rail = TracedOpening("window", (5.0, 0.0), (95.0, 0.0), 1, 0, 0.9)
    inner, outer = (replace(rail, start=(5.0, y), end=(95.0, y)) for y in (50.0, 150.0))
    kept = [replace(inner, other=2), replace(outer, room=2), replace(rail, kind="door")]
    kept += [replace(rail, end=(80.0, 0.0))]  # walls are beside it
    assert outlines.without_rails([rail, *kept], {1: terrace, 2: room}, {1}) == kept


def test_a_wide_window_of_a_garage_to_the_outside_is_its_door():
    wide = TracedOpening("window", (0.0, 0.0), (80.0, 0.0), 1, 0, 0.9)
    kept = [replace(wide, **other) for other in ({"end": (30, 0)}, {"other": 2}, {"room": 2})]
    door, *others = outlines.with_garage_doors([wide, *kept], [1], 60.0)
    assert door == replace(wide, kind="door") and others == kept


@pytest.mark.parametrize("hatched", [False, True])
def test_walls_drawn_as_two_lines_are_filled_also_where_they_are_not_seen(hatched):
    labels = np.minimum(flat_labels(), ROOM).repeat(3, 0).repeat(3, 1)
    wall, slants = labels == WALL, np.indices(labels.shape).sum(0) % 16 < 2
    lines = wall & ((hatched & slants) | ~ndimage.binary_erosion(wall, np.ones((3, 3))))
    page, seen = solid_page(np.where(lines, WALL, 0)), labels.copy()
    seen[:, :100] = OUTSIDE
    looks = [Look(1, Frame(page, np.eye(2, 3)), np.zeros(0), seen)]
    filled = with_filled_walls(page, looks)
    assert (filled[wall] == 0).all() and (filled[~wall] == 255).all()
    assert with_filled_walls(filled, looks) is filled
