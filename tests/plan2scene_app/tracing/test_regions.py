"""Passages that nothing marks: found between ends of walls, and nowhere else."""

import numpy as np
import pytest

from plan2scene_app.tracing.openings import find_openings
from plan2scene_app.tracing.regions import find_regions, with_passages
from plan2scene_app.tracing.rooms import room_polygons
from plan2scene_app.tracing.settings import PASSAGE, ROOM, WALL

from .conftest import PPM, as_probabilities


def one_floor():
    """Return labels of a floor of 8 x 5 m within walls of .15 m."""
    labels = np.zeros((6 * PPM, 9 * PPM), np.uint8)
    paint(labels, WALL, 0.35, 0.35, 8.65, 5.65)
    paint(labels, ROOM, 0.5, 0.5, 8.5, 5.5)
    return labels


def paint(labels, label, x0, y0, x1, y1):
    labels[round(y0 * PPM) : round(y1 * PPM), round(x0 * PPM) : round(x1 * PPM)] = label


def passage(labels):
    """Return the box (metres x0, y0, x1, y1) of the pixels that became a passage, or None."""
    rows, columns = np.nonzero((with_passages(labels, PPM) == PASSAGE) & (labels != PASSAGE))
    if not len(rows):
        return None
    return np.array([columns.min(), rows.min(), columns.max() + 1, rows.max() + 1]) / PPM


@pytest.mark.parametrize("turned", [False, True])
def test_two_ends_that_face_each_other(turned):
    labels = one_floor()
    paint(labels, WALL, 4.0, 0.5, 4.1, 1.2)
    paint(labels, WALL, 4.0, 3.2, 4.1, 5.5)
    found = passage(labels.T if turned else labels)
    expected = np.array([4.0, 1.2, 4.1, 3.2])
    assert np.abs(found - (expected[[1, 0, 3, 2]] if turned else expected)).max() < 0.08


def test_an_end_and_the_wall_across():
    labels = one_floor()
    paint(labels, WALL, 4.0, 0.5, 4.1, 3.5)
    assert np.abs(passage(labels) - [4.0, 3.5, 4.1, 5.5]).max() < 0.08


def test_a_wall_that_stands_in_a_floor_or_parts_a_niche_is_none():
    labels = one_floor()
    paint(labels, WALL, 3.0, 2.0, 3.1, 3.5)  # ends on both sides, but parts nothing
    assert passage(labels) is None
    labels = one_floor()
    paint(labels, WALL, 1.2, 0.5, 1.3, 3.5)  # 0.7 m beside the outer wall
    assert passage(labels) is None or passage(labels)[3] - passage(labels)[1] < 2.1


def test_the_rooms_on_both_sides_are_two_with_a_passage_between():
    labels = one_floor()
    paint(labels, WALL, 4.0, 0.5, 4.1, 1.5)
    paint(labels, WALL, 4.0, 3.0, 4.1, 5.5)
    regions = find_regions(with_passages(labels, PPM), PPM)
    polygons = room_polygons(regions)
    (found,) = find_openings(regions, polygons, as_probabilities(labels))
    assert (found.kind, {found.room, found.other}) == ("passage", {1, 2})
    assert found.width / PPM == pytest.approx(1.5, abs=0.1)
