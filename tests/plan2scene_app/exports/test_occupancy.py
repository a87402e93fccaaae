import numpy as np
import pytest
from scipy import ndimage

from plan2scene.mesh.assembly import assemble
from plan2scene_app.exports.occupancy import FREE, OCCUPIED, occupancy


@pytest.mark.parametrize("name", ["gap_house", "shared_house"])
def test_rooms_join_through_doors_and_nothing_leaks_out(request, name):
    grid, _ = occupancy(assemble(request.getfixturevalue(name)).storeys[0])
    _, count = ndimage.label(grid == FREE)
    assert count == 1
    outside, _ = ndimage.label(grid != OCCUPIED)
    assert outside[0, 0] not in np.unique(outside[grid == FREE])
