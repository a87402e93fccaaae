"""From labels of pixels to rooms and openings."""

import numpy as np
import pytest
from scipy import ndimage
from shapely.geometry import Point

from plan2scene_app.tracing.lettering import TextLine
from plan2scene_app.tracing.openings import find_openings
from plan2scene_app.tracing.picture import main_direction
from plan2scene_app.tracing.regions import find_regions, structure_of
from plan2scene_app.tracing.rooms import describe_rooms, room_polygons
from plan2scene_app.tracing.settings import ROOM

from .conftest import FLOORS, PPM, as_probabilities, flat_labels


def traced(probabilities):
    regions = find_regions(structure_of(probabilities), PPM)
    return regions, room_polygons(regions)


def test_rooms_meet_in_the_middle_of_walls(probabilities):
    regions, polygons = traced(probabilities)
    assert regions.count == 2
    assert regions.wall_px == pytest.approx(0.1 * PPM, abs=0.5)
    for x0, y0, x1, y1 in FLOORS.values():
        middle = Point((x0 + x1) / 2 * PPM, (y0 + y1) / 2 * PPM)
        (own,) = (p for p in polygons.values() if p.contains(middle))
        wide = np.array([x0 - 0.05, y0 - 0.05, x1 + 0.05, y1 + 0.05]) * PPM
        assert np.abs(np.array(own.bounds) + 0.5 - wide).max() < 1.2
        assert len(own.exterior.coords) == 5
    one, other = polygons.values()
    assert one.intersection(other).area < 1e-6
    assert one.intersection(other).length == pytest.approx(3.0 * PPM, rel=0.05)


def test_rooms_are_rectangles_in_spite_of_ragged_borders():
    labels = flat_labels()
    rng = np.random.default_rng(0)
    rows, columns = np.indices(labels.shape)
    moved = labels[
        np.clip(rows + rng.integers(-1, 2, labels.shape), 0, labels.shape[0] - 1),
        np.clip(columns + rng.integers(-1, 2, labels.shape), 0, labels.shape[1] - 1),
    ]
    _, polygons = traced(as_probabilities(moved))
    assert [len(p.exterior.coords) for p in polygons.values()] == [5, 5]


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


def test_openings_lie_on_walls(probabilities):
    regions, polygons = traced(probabilities)
    found = find_openings(regions, polygons, probabilities)
    doors = sorted((o for o in found if o.kind == "door"), key=lambda o: bool(o.other))
    windows = [o for o in found if o.kind == "window"]
    assert len(found) == 3 and len(doors) == 2 and len(windows) == 1
    assert doors[0].other == 0 and {doors[1].room, doors[1].other} == {1, 2}
    assert [o.width / PPM for o in doors] == pytest.approx([0.9, 0.9], abs=0.06)
    assert windows[0].width / PPM == pytest.approx(1.5, abs=0.06)
    outlines = [polygon.exterior for polygon in polygons.values()]
    for opening in found:
        assert min(line.distance(Point(opening.start)) for line in outlines) < 1e-6
    assert all(o.confidence == pytest.approx(0.9, abs=0.01) for o in found)


def test_floor_that_goes_on_is_a_passage():
    labels = flat_labels()
    x0, x1 = round(4.9 * PPM), round(5.2 * PPM)
    labels[:, x0:x1][labels[:, x0:x1] > 1] = 1  # no door
    gap = slice(round(2.1 * PPM), round(2.55 * PPM))
    labels[gap, x0:x1] = ROOM
    probabilities = as_probabilities(labels)
    regions, polygons = traced(probabilities)
    assert regions.count == 2
    kinds = [o.kind for o in find_openings(regions, polygons, probabilities) if o.other]
    assert kinds == ["passage"]


def test_rooms_are_named_by_text_else_by_furniture(probabilities):
    regions, polygons = traced(probabilities)
    lines = [
        TextLine("Chambre 1", (3.0 * PPM, 2.0 * PPM), (40, 8), 0.9),
        TextLine("11.31 m²", (3.0 * PPM, 2.4 * PPM), (40, 8), 0.9),
    ]
    named, other = sorted(
        describe_rooms(regions, polygons, probabilities, lines), key=lambda r: not r.named
    )
    assert (named.id, named.types, named.name) == ("chambre_1", ("Bedroom",), "Chambre 1")
    assert (other.id, other.types, other.named) == ("kitchen", ("Kitchen",), False)
    assert len(named.texts) == 2 and named.confidence > 0.8


@pytest.mark.parametrize("angle", [0.0, 3.0, -20.0, 40.0])
def test_a_turned_plan_is_straightened(angle):
    walls = np.pad(flat_labels() == 1, 80).astype(np.float32)
    turned = ndimage.rotate(walls, -angle, reshape=False, order=1)
    assert main_direction(turned) == pytest.approx(angle, abs=0.8)
