"""The occupancy map: what is free, walled and unknown."""

import numpy as np
import pytest
import yaml
from PIL import Image
from scipy import ndimage

from plan2scene.mesh.assembly import assemble
from plan2scene_app.exports.occupancy import (
    FREE,
    OCCUPIED,
    RESOLUTION_M,
    UNKNOWN,
    occupancy,
    write_map,
)


def at(grid, origin, x, z):
    """Return the value at a plan point."""
    column = int((x - origin[0]) / RESOLUTION_M)
    row = grid.shape[0] - 1 - int((-z - origin[1]) / RESOLUTION_M)
    return grid[row, column]


def test_values_where_the_plan_says(gap_house):
    grid, origin = occupancy(assemble(gap_house).storeys[0])
    assert at(grid, origin, 1.5, 2.0) == FREE
    assert at(grid, origin, 4.5, 2.0) == FREE
    assert at(grid, origin, 3.05, 1.4) == FREE  # the door, open
    assert at(grid, origin, 3.05, 3.0) == OCCUPIED
    assert at(grid, origin, -0.05, 2.0) == OCCUPIED
    assert at(grid, origin, -0.4, -0.4) == UNKNOWN


def test_free_area_is_the_rooms_less_what_walls_touch(gap_house):
    grid, _ = occupancy(assemble(gap_house).storeys[0])
    free = (grid == FREE).sum() * RESOLUTION_M**2
    assert free == pytest.approx(3.0 * 4.0 + 2.9 * 4.0, rel=0.07)


@pytest.mark.parametrize("name", ["gap_house", "shared_house"])
def test_rooms_join_through_doors_and_nothing_leaks_out(request, name):
    grid, _ = occupancy(assemble(request.getfixturevalue(name)).storeys[0])
    _, count = ndimage.label(grid == FREE)
    assert count == 1
    outside, _ = ndimage.label(grid != OCCUPIED)
    assert outside[0, 0] not in np.unique(outside[grid == FREE])


def test_files(gap_house, tmp_path):
    write_map(gap_house, {}, tmp_path)
    grid, origin = occupancy(assemble(gap_house).storeys[0])
    facts = yaml.safe_load((tmp_path / "map.yaml").read_text())
    assert facts["resolution"] == RESOLUTION_M
    assert facts["origin"][:2] == pytest.approx(origin)
    assert np.array_equal(np.asarray(Image.open(tmp_path / facts["image"])), grid)
