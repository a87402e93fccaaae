import numpy as np
import pytest

from plan2scene.paint.shading import flatten, highlights, log_luma


def test_shading_goes_and_relief_stays():
    relief = np.random.default_rng(0).normal(0, 0.04, (4, 128, 128))
    across = np.linspace(-0.25, 0.25, 128)
    shading = np.stack([across[:, None] * (k - 1.5) + 0 * across for k in range(4)])
    clean = np.exp(relief)[..., None] * np.array([0.5, 0.45, 0.4])
    flat = flatten((clean * np.exp(shading)[..., None]), np.zeros((4, 128, 128), bool))
    left = log_luma(flat) - log_luma(clean)
    left -= left.mean(axis=(1, 2), keepdims=True)
    assert left.std() < 0.1 * shading.std()
    assert log_luma(flat).std(axis=(1, 2)) == pytest.approx(relief.std(axis=(1, 2)), rel=0.1)


@pytest.mark.parametrize(("count", "side", "found"), [(4, 4, 4), (30, 4, 0), (2, 18, 0), (0, 4, 0)])
def test_lamps_mirrored_in_a_floor_are_highlights(count, side, found):
    images = 0.55 + np.random.default_rng(1).normal(0, 0.02, (3, 128, 128, 1)) * np.ones(3)
    for number in range(count):
        y, x = divmod(number, 6)
        images[:, 8 + 20 * y : 8 + 20 * y + side, 8 + 20 * x : 8 + 20 * x + side] = 0.97
    masks = highlights(images)
    assert masks[images.min(axis=3) > 0.9].all() == (found > 0 or count == 0)
    assert masks.mean() < 0.05 and masks.any() == (found > 0)
