import pytest
from shapely.geometry import box

from plan2scene_app.tracing.openings import TracedOpening, within_walls

#: A hall above two rooms; the wall of the left one ends at x = 100.
ROOMS = {1: box(0, 0, 200, 50), 2: box(0, 60, 100, 200), 3: box(110, 60, 200, 200)}


@pytest.mark.parametrize(
    ("start", "end", "expected"),
    [(40, 104, (40, 100)), (104, 40, (100, 40)), (-6, 60, (0, 60)), (40, 90, (40, 90))]
    + [(20, 150, (20, 150))],  # far beyond: it is between other rooms, too
)
def test_an_opening_ends_with_the_shorter_wall(start, end, expected):
    opening = TracedOpening("passage", (start, 55.0), (end, 55.0), 1, 2, 0.9)
    (kept,) = within_walls([opening], ROOMS, 10.0)
    assert (kept.start[0], kept.end[0]) == pytest.approx(expected)
    assert kept.start[1] == kept.end[1] == 55.0


def test_an_opening_to_the_outside_keeps_its_wall():
    opening = TracedOpening("window", (-4.0, 100.0), (-4.0, 203.0), 2, 0, 0.9)
    (kept,) = within_walls([opening], ROOMS, 10.0)
    assert kept.start == (-4.0, 100.0) and kept.end == pytest.approx((-4.0, 200.0))
