import numpy as np
import pytest

from plan2scene.materials import random_material
from plan2scene.metrics.pair import pair_metrics
from plan2scene.metrics.tile import tile_score


def test_an_image_against_itself():
    image = random_material("wood", 3, size_px=128).albedo
    figures = pair_metrics(image, image)
    assert (figures["color"], figures["freq"], figures["subs"]) == (0.0, 0.0, 0)
    assert figures["tile"] == pytest.approx(tile_score(image))


def test_tile_is_of_the_prediction_and_sizes_may_differ():
    image = random_material("tile", 5, size_px=256).albedo
    flat = np.full((64, 64, 3), 90, np.uint8)
    assert pair_metrics(flat, image)["tile"] == pytest.approx(0.0, abs=1e-9)
    assert pair_metrics(image, flat)["tile"] > 1.0
    assert pair_metrics(flat, image)["color"] == pytest.approx(pair_metrics(image, flat)["color"])
