"""Light within crops: shading, highlights and casts."""

import numpy as np
import pytest

from plan2scene.paint.shading import flatten, log_luma


def test_shading_goes_and_relief_stays() -> None:
    rng = np.random.default_rng(0)
    relief = rng.normal(0, 0.04, (4, 128, 128))
    across = np.linspace(-0.25, 0.25, 128)
    shading = np.stack([across[:, None] * (k - 1.5) + 0 * across for k in range(4)])
    clean = np.exp(relief)[..., None] * np.array([0.5, 0.45, 0.4])
    lit = clean * np.exp(shading)[..., None]
    none = np.zeros((4, 128, 128), bool)
    flat = flatten(lit, none)
    left = log_luma(flat) - log_luma(clean)
    left -= left.mean(axis=(1, 2), keepdims=True)
    assert left.std() < 0.1 * shading.std()
    assert log_luma(flat).std(axis=(1, 2)) == pytest.approx(relief.std(axis=(1, 2)), rel=0.1)
