"""COLOR, FREQ and TILE against the figures of the reference implementation."""

import numpy as np
import pytest

from plan2scene.metrics.color_freq_tile import (
    color_distance,
    color_histogram,
    freq_distance,
    tile_score,
)


def _quantise(*channels):
    image = np.stack(channels, axis=-1)
    return np.clip(np.rint(255 * image), 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def crops():
    y, x = np.mgrid[:128, :128].astype(float)
    base = 0.5 + 0.25 * np.sin(2 * np.pi * (3 * x + 5 * np.sin(2 * np.pi * y / 128)) / 128)
    base += 0.1 * np.sin(2 * np.pi * 17 * y / 128)
    wavy = _quantise(
        0.9 * base, 0.7 * base + 0.02 * np.sin(x / 7), 0.5 * base + 0.03 * np.cos(y / 9)
    )
    m = ((x % 32 < 2) | (y % 32 < 2)).astype(float)
    grid = _quantise(0.8 - 0.5 * m, 0.78 - 0.5 * m + 0.0005 * x, 0.7 - 0.4 * m - 0.0008 * y)
    return wavy, grid


def test_figures_are_those_of_the_reference(crops):
    wavy, grid = crops
    assert color_distance(wavy, grid) == pytest.approx(0.9859619140625, abs=1e-9)
    assert color_distance(wavy, np.roll(wavy, 5, axis=1)) == 0.0
    for images in ((wavy, grid), (grid, wavy)):
        assert freq_distance(*images) == pytest.approx(0.2894730934344238, abs=1e-9)
    assert tile_score(wavy) == pytest.approx(214.78071716704454, abs=1e-9)
    assert tile_score(grid) == pytest.approx(167.26790316808066, abs=1e-9)


def test_colours_on_an_edge_of_hue_fall_where_the_reference_rounds_them():
    import colorsys

    levels = np.arange(256)
    colours = []
    for span in range(5, 256, 5):  # the hue is k / 10 only where the span is a multiple of 5
        middle = np.array([0, 1, 2, 3, 4, 5]) * span // 5
        bottom = levels[: 256 - span : 7]
        top = np.broadcast_to(bottom + span, (6, len(bottom)))
        low = np.broadcast_to(bottom, top.shape)
        order = [top, low + middle[:, None], low]
        for axes in ((0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)):
            colours.append(np.stack([order[i] for i in axes], axis=-1).reshape(-1, 3))
    pixels = np.concatenate(colours).astype(np.uint8)
    expected = [
        int(np.searchsorted(np.arange(1, 10) / 10, colorsys.rgb_to_hls(*pixel)[0], "right"))
        for pixel in pixels / 255
    ]
    found = [color_histogram(pixel[None, None]).argmax() // 9 for pixel in pixels]
    assert found == expected
    assert len(set(expected)) == 10


def test_wrong_inputs_are_refused(crops):
    with pytest.raises(ValueError, match="uint8"):
        tile_score(crops[0] / 255.0)
    with pytest.raises(ValueError, match="of one size"):
        color_distance(crops[0], crops[0][:64, :64])
    with pytest.raises(ValueError, match="128 px"):
        tile_score(crops[0][:64, :64])
