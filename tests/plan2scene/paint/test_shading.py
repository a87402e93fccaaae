"""Light within crops: shading, highlights and casts."""

import numpy as np
import pytest

from plan2scene.paint.shading import consensus, flatten, log_luma


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


def test_consensus_evens_casts_and_trusts_evenly_lit_crops() -> None:
    level = np.array([0.5, 0.52, 0.48, 0.3])
    repair = np.array([0.02, 0.02, 0.02, 0.5])  # the dark one lay in a shadow
    cast = np.array([[1.05, 1.0, 0.96], [0.95, 1.0, 1.04], [1.04, 1.0, 1.05], [0.96, 1.0, 0.95]])
    found = consensus(level[:, None] * cast, repair)
    np.testing.assert_allclose(found, 0.5, atol=0.01)


def test_consensus_leaves_out_burned_out_crops_unless_the_surface_is_white() -> None:
    grey = np.array([[0.8, 0.8, 0.7]] * 4 + [[1.0, 1.0, 1.0]])
    np.testing.assert_allclose(consensus(grey, np.zeros(5)), [0.8, 0.8, 0.7])
    white = np.array([[0.95] * 3, [1.0] * 3, [1.0] * 3, [0.7] * 3, [0.97] * 3])
    np.testing.assert_allclose(consensus(white, np.zeros(5)), 0.97)
