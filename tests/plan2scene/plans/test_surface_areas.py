"""The areas of surfaces are the bounds of the mesh's texture coordinates."""

from pathlib import Path

import numpy as np
import pytest

from plan2scene.house import SurfaceKey
from plan2scene.mesh.assembly import build_parts
from plan2scene.plans.formats import read_plan
from plan2scene.plans.surface_areas import MARGIN_M, surface_areas

EXAMPLES = Path(__file__).parents[3] / "resources" / "examples"


@pytest.mark.parametrize("plan", ["plan.json", "two_storeys/plan.json"])
def test_areas_hold_the_texture_coordinates_of_all_faces(plan):
    house = read_plan(EXAMPLES / plan, "h")
    areas = surface_areas(house)
    found = {}
    for part in build_parts(house):
        if part.surface is not None and part.uv is not None:
            found.setdefault(part.surface, []).append(part.uv)
    assert areas.keys() == found.keys()
    for key, uvs in found.items():
        uv = np.concatenate(uvs)
        assert np.allclose(areas[key].low, uv.min(axis=0) - MARGIN_M, atol=1e-9), key
        assert np.allclose(areas[key].high, uv.max(axis=0) + MARGIN_M, atol=1e-9), key


def test_a_wall_is_unrolled_around_its_room(l_house):
    areas = surface_areas(l_house)
    wall = areas[SurfaceKey("hall", "wall")]
    assert wall.size == pytest.approx((18.0 + 0.1, 2.5 + 0.1), abs=0.01)
    assert areas[SurfaceKey("hall", "ceiling")].size == pytest.approx((5.1, 4.1), abs=0.01)
