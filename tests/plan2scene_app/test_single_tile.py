import numpy as np
import pytest

from plan2scene.materials import random_material
from plan2scene.textures.methods import texture_methods
from plan2scene.textures.seams import wrap_ratio
from plan2scene_app.single_tile import tile_from_crops

CROPS = [random_material("wood", 8, size_px=256).albedo[30:170, 20:200]] * 2


@pytest.mark.parametrize("method", sorted(texture_methods()))
def test_every_method_gives_a_tile_that_repeats(method):
    tile = tile_from_crops(CROPS, method, size_px=128, seed=0)
    assert tile.shape == (128, 128, 3) and tile.dtype == np.uint8
    assert wrap_ratio(tile) < 1.5


def test_crops_too_poor_for_an_exemplar_are_decoded():
    white = [np.full((128, 128, 3), 255, np.uint8)]
    methods = "exemplar", "synth"
    assert np.array_equal(*(tile_from_crops(white, m, size_px=128, seed=0) for m in methods))
