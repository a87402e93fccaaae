import colorsys

import numpy as np
import pytest
from formula import formula_crop

from plan2scene.metrics import color_freq_tile as metrics


@pytest.fixture(scope="module")
def crops():
    y, x = np.mgrid[:128, :128].astype(float)
    m = ((x % 32 < 2) | (y % 32 < 2)).astype(float)
    grid = [0.8 - 0.5 * m, 0.78 - 0.5 * m + 0.0005 * x, 0.7 - 0.4 * m - 0.0008 * y]
    return formula_crop(), np.rint(255 * np.stack(grid, axis=-1)).astype(np.uint8)


def test_figures_are_those_of_the_reference(crops):
    wavy, grid = crops
    assert metrics.color_distance(wavy, grid) == pytest.approx(0.9859619140625, abs=1e-9)
    assert metrics.color_distance(wavy, np.roll(wavy, 5, axis=1)) == 0.0
    for images in ((wavy, grid), (grid, wavy)):
        assert metrics.freq_distance(*images) == pytest.approx(0.2894730934344238, abs=1e-9)
    assert metrics.tile_score(wavy) == pytest.approx(214.78071716704454, abs=1e-9)
    assert metrics.tile_score(grid) == pytest.approx(167.26790316808066, abs=1e-9)


def test_colours_fall_into_the_bins_of_the_reference():
    """Steps of 15 hold every edge of hue, where a colour falls where ``colorsys`` rounds it."""
    levels = np.arange(0, 256, 15, dtype=np.uint8)
    pixels = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(-1, 3)
    thirds = [0.333, 0.666]
    for pixel in pixels:
        hue, lightness, saturation = colorsys.rgb_to_hls(*(pixel / 255))
        expected = 9 * np.searchsorted(np.arange(1, 10) / 10, hue, "right")
        expected += 3 * np.searchsorted(thirds, saturation) + np.searchsorted(thirds, lightness)
        assert metrics.color_histogram(pixel[None, None]).argmax() == expected, pixel


def test_wrong_inputs_are_refused(crops):
    with pytest.raises(ValueError, match="uint8"):
        metrics.tile_score(crops[0] / 255.0)
    with pytest.raises(ValueError, match="of one size"):
        metrics.color_distance(crops[0], crops[0][:64, :64])
    with pytest.raises(ValueError, match="128 px"):
        metrics.tile_score(crops[0][:64, :64])
