import logging
from dataclasses import replace

import numpy as np
import pytest
from sample_houses import one_room

from plan2scene.house import IconBox
from plan2scene.mesh.assembly import assemble
from plan2scene.mesh.fittings import KINDS


@pytest.fixture
def room_of_four():
    return one_room("Bathroom", 3.0, 4.0, name="r")


def objects_of(house, *icons):
    parts = assemble(replace(house, icons=icons)).parts
    return [part for part in parts if part.extras["kind"] in ("object", "stairs")]


def test_icons_say_what_they_are(room_of_four):
    known = {"washing_basin": "sink", "cooking_counter": "stove", "CornerBathTub": "bath"}
    known |= {"sink_unit": "sink_unit", "counter": "counter"}
    known |= {"toilet": "toilet", "Closet CoatCloset": "wardrobe", "stairs": "stairs"}
    unknown = ("special", "entrance", "piano")
    icons = [IconBox(drawn, (1.0, 0.1), (1.9, 0.9)) for drawn in (*known, *unknown)]
    made = [part.extras["category"] for part in objects_of(room_of_four, *icons)]
    assert made == list(known.values())


@pytest.mark.parametrize("category", sorted(KINDS))
def test_models_fill_their_size_and_are_closed(category, room_of_four):
    width, depth, height = KINDS[category].size
    ends = np.array([c for a, b, _ in KINDS[category].blocks(width, depth, height) for c in (a, b)])
    assert ends.min(axis=0) == pytest.approx([0, 0, 0], abs=1e-9)
    assert ends[:, [0, 2]].max(axis=0) == pytest.approx([width, depth])
    assert height - 1e-9 <= ends[:, 1].max() <= height + 0.15  # taps stand above
    for low, high, _ in KINDS[category].blocks(width, depth, height):
        assert (np.array(high) > np.array(low)).all()
    (part,) = objects_of(room_of_four, IconBox(category, (1.0, 0.1), (1.9, 0.9)))
    assert part.name == f"r/object/{category}"
    assert part.extras["category"] == category and part.extras["room_id"] == "r"
    # Boxes: every edge belongs to two faces when corners are joined.
    mesh = part.mesh.copy()
    mesh.merge_vertices(merge_norm=True)
    assert mesh.volume > 0


def test_a_counter_is_as_long_and_deep_as_it_is_drawn(room_of_four):
    (part,) = objects_of(room_of_four, IconBox("counter", (0.5, 0.0), (2.7, 0.65)))
    assert part.mesh.bounds[:, [0, 2]].ravel() == pytest.approx([0.5, 0.02, 2.7, 0.65], abs=1e-6)


@pytest.mark.parametrize(
    ("icon", "axis", "face"),
    [
        (((1.2, 0.1), (1.8, 0.8)), 1, 0.0),  # z = 0
        (((1.2, 3.2), (1.8, 3.9)), 1, 4.0),
        (((0.1, 1.5), (0.8, 2.1)), 0, 0.0),  # x = 0
        (((2.3, 1.5), (2.95, 2.1)), 0, 3.0),
    ],
)
def test_a_toilet_stands_with_its_back_to_the_wall_it_is_drawn_at(room_of_four, icon, axis, face):
    (part,) = objects_of(room_of_four, IconBox("toilet", *icon))
    low, high = part.mesh.bounds[:, [0, 2]]
    assert min(abs(low[axis] - face), abs(high[axis] - face)) == pytest.approx(0.02, abs=1e-4)
    assert high[axis] - low[axis] == pytest.approx(0.68, abs=1e-4)
    assert high[1 - axis] - low[1 - axis] == pytest.approx(0.38, abs=1e-4)
    middle = (icon[0][1 - axis] + icon[1][1 - axis]) / 2
    assert (low + high)[1 - axis] / 2 == pytest.approx(middle, abs=1e-4)
    top = part.mesh.vertices[part.mesh.vertices[:, 1] > 0.7][:, [0, 2]]
    assert np.abs(top[:, axis] - face).max() < 0.25


def test_stairs_fill_their_box_up_to_the_ceiling_in_steps_to_walk(room_of_four):
    (part,) = objects_of(room_of_four, IconBox("stairs", (0.5, 0.5), (1.4, 3.5)))
    assert part.extras["kind"] == "stairs"
    low, high = part.mesh.bounds
    assert low == pytest.approx([0.5, 0.0, 0.5]) and high == pytest.approx([1.4, 2.5, 3.5])
    assert np.diff(np.unique(part.mesh.vertices[:, 1].round(4))).max() <= 0.19


def test_what_stands_in_no_room_is_left_out_with_a_warning(room_of_four, caplog):
    with caplog.at_level(logging.WARNING, logger="plan2scene"):
        assert objects_of(room_of_four, IconBox("toilet", (6.0, 6.0), (7.0, 7.0))) == []
    assert "toilet" in caplog.text and "no room" in caplog.text
