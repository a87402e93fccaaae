"""Drawn plans and the network that learns from them."""

import numpy as np
import pytest
import shapely
import torch

from plan2scene.photos.labels.network import SegmentationNet
from plan2scene.seeds import generator
from plan2scene_app.tracing.settings import DOOR, LABEL_OF_TYPE, PLAN_LABELS, ROOM, WALL, WINDOW
from plan2scene_workshop.homes.floorplans import generate_house
from plan2scene_workshop.plans.drawing import draw_plan
from plan2scene_workshop.plans.lettering import area_text, length_text
from plan2scene_workshop.plans.settings import PlanSettings
from plan2scene_workshop.plans.structure import structure_of
from plan2scene_workshop.plans.style import CHOICES, HELD_OUT, draw_style
from plan2scene_workshop.plans.training import train_network
from plan2scene_workshop.plans.views import Drawings, draw_view


@pytest.fixture(scope="module")
def house():
    return generate_house("drawn_1", 3)


@pytest.fixture(scope="module")
def drawn(house):
    rng = generator(0, "test drawing")
    return draw_plan(house, draw_style(rng), 24.0, rng)


def label_at(drawn, x, z):
    column, row = (np.array([x, z]) - drawn.origin) * drawn.ppm
    return int(drawn.labels[int(row), int(column)])


def test_every_room_has_its_label_inside(drawn):
    for room, types in zip(drawn.plan.rooms, drawn.plan.types, strict=True):
        spot = room.buffer(-0.3).representative_point()
        assert label_at(drawn, spot.x, spot.y) == LABEL_OF_TYPE[types[0]]


def test_openings_lie_in_walls_that_close_the_rooms(drawn):
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


def test_the_same_drawing_comes_twice(house, drawn):
    rng = generator(0, "test drawing")
    again = draw_plan(house, draw_style(rng), 24.0, rng)
    np.testing.assert_array_equal(again.image, drawn.image)
    np.testing.assert_array_equal(again.labels, drawn.labels)


def test_styles_held_out_are_not_trained_on():
    for key, choices in HELD_OUT.items():
        assert set(choices) - set(CHOICES.get(key, {"sans": 1.0}))
    rng = generator(0, "styles")
    own = {draw_style(rng).wall for _ in range(60)}
    assert own == set(CHOICES["wall"])
    assert draw_style(rng, held_out=True).wall in HELD_OUT["wall"]


def test_inner_doors_become_passages_of_their_walls(house):
    depths = {"inner_depth": 0.1, "outer_depth": 0.3, "rail_depth": 0.05, "cut_corners": 0.0}
    plain = structure_of(house, generator(1, "passages"), **depths)
    opened = structure_of(house, generator(1, "passages"), **depths, opened=1.0)
    kinds = [[gap.kind for gap in plan.gaps] for plan in (plain, opened)]
    assert kinds[1].count("passage") > kinds[0].count("passage")
    assert kinds[1].count("window") == kinds[0].count("window")
    assert [g for g in opened.gaps if g.kind == "door" and g.outer] != []
    gaps = [shapely.LineString([g.start, g.end]) for g in opened.gaps if g.kind == "passage"]
    walls = shapely.union_all([room.exterior for room in opened.rooms]).buffer(0.01)
    assert all(walls.contains(line) and 0.7 < line.length <= 3.5 for line in gaps)
    assert (
        shapely.union_all([opened.inner, opened.outer]).area < plain.inner.area + plain.outer.area
    )


def test_cut_corners_keep_the_floor(house):
    rng = generator(1, "corners")
    depths = {"inner_depth": 0.1, "outer_depth": 0.3, "rail_depth": 0.05}
    plain = structure_of(house, rng, cut_corners=0.0, **depths)
    cut = structure_of(house, rng, cut_corners=1.0, **depths)
    corners = [sum(len(r.exterior.coords) for r in plan.rooms) for plan in (plain, cut)]
    assert corners[1] > corners[0]
    overlap = sum(r.area for r in cut.rooms) - shapely.union_all(list(cut.rooms)).area
    assert overlap == pytest.approx(0, abs=1e-3)


@pytest.mark.parametrize(
    ("unit", "texts"),
    [("m", {"3.20", "3,20"}), ("cm", {"320"}), ("mm", {"3200"}), ("ft", {"10'6\"", "10' 6\""})],
)
def test_lengths_are_written_in_their_unit(unit, texts):
    rng = generator(0, "lengths")
    assert {length_text(3.2, unit, rng) for _ in range(20)} == texts


def test_areas_are_written_in_their_unit():
    rng = generator(0, "areas")
    assert all(area_text(20.0, "ft", rng).startswith("215 ") for _ in range(5))
    metric = {area_text(14.5, "m", rng).rstrip("²2 qm") for _ in range(40)}
    assert metric == {"14", "14.5", "14,5", "14.50", "14,50"}


def test_views_keep_picture_and_labels_together(drawn):
    image, labels = draw_view(drawn, 96, generator(2, "view"))
    assert image.shape == (96, 96, 3) and image.dtype == np.uint8
    assert labels.shape == (96, 96) and labels.max() < len(PLAN_LABELS)


def test_training_learns_and_repeats():
    settings = PlanSettings(
        drawings=2, batch=2, side=64, steps=8, held_out=1, ema_decay=0.5, evaluate_every=8
    )
    states = []
    for _ in range(2):
        torch.manual_seed(0)
        network = SegmentationNet(
            widths=(4, 4, 8, 8, 8), depths=(1, 1, 1, 1), decoder=8, labels=len(PLAN_LABELS)
        )
        trained = train_network(network, settings, seed=0)
        states.append(trained.network.state_dict())
        assert 0 <= trained.score <= 1
    assert all(torch.equal(states[0][name], states[1][name]) for name in states[0])


def test_drawings_are_drawn_once():
    drawings = Drawings(PlanSettings(), 0)
    assert drawings.get(3) is drawings.get(3)
