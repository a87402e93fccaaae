"""Tiles made up for what a house shows nowhere."""

import numpy as np
import pytest

from plan2scene.colour import median_colour
from plan2scene.house import SUBSTANCES, SurfaceKey
from plan2scene.textures.exemplar.house_tiles import usual_tile
from plan2scene.textures.seams import wrap_ratio

FLOOR = SurfaceKey("bath", "floor")


@pytest.mark.parametrize("substance", SUBSTANCES)
@pytest.mark.parametrize("size_px", [128, 512])
def test_it_repeats_in_about_the_colour_asked_for(substance, size_px):
    tone = np.array([0.62, 0.5, 0.4])
    made = usual_tile(FLOOR, substance, tone, house="h", seed=0, size_px=size_px)
    assert made.image.shape == (size_px, size_px, 3)
    assert made.image.dtype == np.uint8
    assert np.abs(median_colour(made.image) - tone).max() < 0.12
    assert wrap_ratio(made.image) < 1.5
    assert 0.2 < made.size_m < 3.0
    assert made.source == f"made up: no exemplar of a floor of {substance} in the house"


def test_a_house_has_one_of_each_and_houses_differ():
    def tile(house, room, tone=0.5):
        key = SurfaceKey(room, "floor")
        return usual_tile(key, "tile", np.full(3, tone), house=house, seed=0, size_px=128)

    first = tile("a", "bath")
    np.testing.assert_array_equal(first.image, tile("a", "shower").image)
    assert tile("a", "shower", 0.7).size_m == first.size_m
    assert len({tile(f"house {k}", "bath").size_m for k in range(12)}) > 1
