import cv2
import numpy as np

from plan2scene.house import SUBSTANCES
from plan2scene.materials import random_material
from plan2scene.textures.seams import make_seamless, with_calm_border, wrap_ratio


def _window(substance, seed, side=96):
    tile = random_material(substance, seed, size_px=160).albedo
    part = np.roll(tile, np.random.default_rng(seed).integers(0, 160, 2), (0, 1))[:side, :side]
    return cv2.resize(part, (128, 128), interpolation=cv2.INTER_CUBIC)


def _largest_step(image):
    """The strongest line of steps inside an image: what a pattern's own edges reach."""
    values = image.astype(float)
    return max(np.abs(np.diff(values, axis=axis)).mean(axis=(1 - axis, 2)).max() for axis in (0, 1))


def _wrap_step(image):
    values = image.astype(float)
    return max(np.abs(values.take(0, axis) - values.take(-1, axis)).mean() for axis in (0, 1))


WINDOWS = [(substance, seed) for substance in SUBSTANCES for seed in range(3)]


def test_wrap_ratio_falls_below_its_bound_and_no_seam_moves_inside():
    windows = [_window(*case) for case in WINDOWS]
    repaired = [(w, *make_seamless(w)) for w in windows if wrap_ratio(w) > 2.0]
    ratios = [wrap_ratio(tile) for _, tile, _ in repaired]
    assert np.median(ratios) <= 1.2
    for (before, after, _), ratio in zip(repaired, ratios, strict=True):
        # Where a pattern's own edge (grout) falls on the border the ratio says nothing.
        assert ratio <= 1.3 or _wrap_step(after) <= 1.1 * _largest_step(before)
    rng = np.random.default_rng(0)
    for before, after, _ in repaired:
        for _ in range(6):
            rolled = np.roll(after, rng.integers(0, 128, 2), (0, 1))
            step = _wrap_step(rolled)
            assert wrap_ratio(rolled) <= 1.3 or step <= 1.25 * _largest_step(before)


def test_only_what_needs_it_is_repaired():
    y, x = np.mgrid[:64, :64] * 2 * np.pi / 64
    grey = 128 + 60 * np.sin(3 * x + y) + 30 * np.cos(2 * y)
    tile = np.repeat(grey[..., None], 3, axis=2).astype(np.uint8)
    result, changed = make_seamless(tile)
    assert np.array_equal(result, tile) and not changed.any()
    x = y = np.arange(64) * 2 * np.pi / 64
    image = 128 + 50 * np.sin(3.5 * x + 1)[None, :] + 20 * np.cos(4 * y)[:, None]
    image = np.repeat(image[..., None], 3, axis=2).astype(np.uint8)
    result, changed = make_seamless(image)
    assert wrap_ratio(image) > 3.0 and wrap_ratio(result) < 1.3
    assert not changed[:, 24:40].any()  # the band lies at the left and right borders


def test_calm_border_is_a_roll_that_takes_joints_off_the_border():
    tile = np.full((64, 64, 3), 150, np.uint8)
    tile += np.random.default_rng(0).integers(0, 6, (64, 64, 1)).astype(np.uint8)
    tile[::16] = tile[:, ::16] = 90  # joints on the border
    calm = with_calm_border(tile)
    assert wrap_ratio(tile) > 3.0 and wrap_ratio(calm) < 1.0
    rolls = [np.roll(tile, (i, j), (0, 1)) for i in range(64) for j in range(64)]
    assert any(np.array_equal(calm, roll) for roll in rolls)
    assert np.array_equal(with_calm_border(calm), calm)
