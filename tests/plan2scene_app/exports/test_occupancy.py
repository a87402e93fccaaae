import numpy as np
import pytest
from scipy import ndimage

from plan2scene.mesh.assembly import assemble
from plan2scene_app.exports.occupancy import FREE, OCCUPIED, RESOLUTION_M, UNKNOWN, occupancy


def at(grid, origin, x, z):
    column = int((x - origin[0]) / RESOLUTION_M)
    return grid[(grid.shape[0] - 1 - int((-z - origin[1]) / RESOLUTION_M)), column]


def test_values_where_the_plan_says(gap_house):
    grid, origin = occupancy(assemble(gap_house).storeys[0])
    assert at(grid, origin, 1.5, 2.0) == FREE and at(grid, origin, 4.5, 2.0) == FREE
    assert at(grid, origin, 3.05, 1.4) == FREE  # the door, open
    assert at(grid, origin, 3.05, 3.0) == OCCUPIED and at(grid, origin, -0.05, 2.0) == OCCUPIED
    assert at(grid, origin, -0.4, -0.4) == UNKNOWN


@pytest.mark.parametrize("name", ["gap_house", "shared_house"])
def test_rooms_join_through_doors_and_nothing_leaks_out(request, name):
    grid, _ = occupancy(assemble(request.getfixturevalue(name)).storeys[0])
    _, count = ndimage.label(grid == FREE)
    assert count == 1
    outside, _ = ndimage.label(grid != OCCUPIED)
    assert outside[0, 0] not in np.unique(outside[grid == FREE])
