import numpy as np
import shapely

from plan2scene.seeds import generator
from plan2scene_app.tracing.settings import DOOR, FIXTURE_LABELS, LABEL_OF_TYPE, ROOM, WALL, WINDOW
from plan2scene_workshop.homes.floorplans import generate_house
from plan2scene_workshop.plans.drawing import draw_plan
from plan2scene_workshop.plans.fixture_training import FixtureSettings, fixture_view
from plan2scene_workshop.plans.fixtures import fixture_plan
from plan2scene_workshop.plans.style import draw_style


def label_at(drawn, x, z):
    column, row = (np.array([x, z]) - drawn.origin) * drawn.ppm
    return int(drawn.labels[int(row), int(column)])


def test_labels_are_of_the_rooms_and_the_openings_in_walls_that_close_them():
    rng = generator(0, "test drawing")
    drawn = draw_plan(generate_house("drawn_1", 3), draw_style(rng), 24.0, rng)
    for room, types in zip(drawn.plan.rooms, drawn.plan.types, strict=True):
        spot = room.buffer(-0.3).representative_point()
        assert label_at(drawn, spot.x, spot.y) == LABEL_OF_TYPE[types[0]]
    kinds = {"door": DOOR, "window": WINDOW}
    for gap in drawn.plan.gaps:
        middle = (gap.start + gap.end) / 2
        if gap.kind in kinds:
            assert label_at(drawn, *middle) == kinds[gap.kind]
    # Nothing but labels of walls and openings parts two rooms, or a room and the outside.
    for axis in (0, 1):
        a, b = np.delete(drawn.labels, -1, axis), np.delete(drawn.labels, 0, axis)
        rooms = (a >= ROOM) & (b >= ROOM)
        assert (a[rooms] == b[rooms]).all()
        assert not (((a == 0) & (b >= ROOM)) | ((b == 0) & (a >= ROOM))).any()
    assert (drawn.labels == WALL).any()


def test_fixtures_are_labelled_where_they_are_drawn():
    rng = generator(0, "test fixtures")
    drawn = fixture_plan(1, 3, rng, held_out=False)
    assert {"toilet", "stove", "counter"} <= {FIXTURE_LABELS[k] for k in np.unique(drawn.labels)}
    rooms = zip(drawn.plan.rooms, drawn.plan.types, strict=True)
    wet = [room for room, types in rooms if {"Bathroom", "Kitchen"}.intersection(types)]
    rows, columns = np.nonzero(drawn.labels)
    spots = np.c_[columns, rows] / drawn.ppm + drawn.origin
    assert shapely.union_all(wet).buffer(0.05).contains(shapely.points(spots)).all()
    view = fixture_view(drawn, FixtureSettings(side=96), rng)
    assert [part.shape for part in view] == [(96, 96, 3), (96, 96)]
