"""The Frechet distance against closed forms, and where a covariance is singular."""

import numpy as np
import pytest
from scipy.linalg import sqrtm

from plan2scene.metrics.frechet import frechet_distance


def _samples(n, d, seed, mean=0.0, scale=1.0):
    return np.random.default_rng(seed).normal(mean, scale, (n, d))


def test_equal_sets_have_distance_zero():
    for n, d in ((200, 8), (5, 64), (1, 3)):
        features = _samples(n, d, 1)
        assert frechet_distance(features, features) == pytest.approx(0.0, abs=1e-6)


def test_a_shift_costs_its_squared_length():
    features = _samples(300, 6, 2)
    shift = np.arange(6.0)
    distance = frechet_distance(features, features + shift)
    assert distance == pytest.approx((shift**2).sum(), rel=1e-6)


def test_one_dimension_has_a_closed_form():
    a, b = _samples(400, 1, 3, 1.0, 2.0), _samples(500, 1, 4, -1.0, 0.5)
    expected = (a.mean() - b.mean()) ** 2 + (a.std() - b.std()) ** 2
    assert frechet_distance(a, b) == pytest.approx(expected, rel=1e-9)


def test_agrees_with_the_matrix_square_root():
    rng = np.random.default_rng(5)
    a = rng.normal(size=(500, 4)) @ rng.normal(size=(4, 4))
    b = rng.normal(size=(500, 4)) @ rng.normal(size=(4, 4)) + 1.0
    share = 4 / 504
    covariances = []
    for features in (a, b):
        c = np.cov(features.T, bias=True)
        covariances.append((1 - share) * c + share * np.diag(np.diag(c)))
    root = sqrtm(covariances[0] @ covariances[1]).real
    expected = ((a.mean(0) - b.mean(0)) ** 2).sum()
    expected += np.trace(covariances[0] + covariances[1] - 2 * root)
    assert frechet_distance(a, b) == pytest.approx(expected, rel=1e-6)


def test_symmetric_and_finite_with_fewer_samples_than_dimensions():
    a, b = _samples(7, 64, 6), _samples(90, 64, 7, 0.3)
    forth, back = frechet_distance(a, b), frechet_distance(b, a)
    assert np.isfinite(forth)
    assert forth == pytest.approx(back, rel=1e-6)
    assert forth > 0


def test_weights_count_like_repetitions():
    a, b = _samples(60, 3, 8), _samples(20, 3, 9, 0.5)
    counts = np.random.default_rng(0).integers(1, 5, 20)
    repeated = np.repeat(b, counts, axis=0)
    weighted = frechet_distance(a, b, counts.astype(float))
    # Only the effective size, which shrinkage depends on, may differ.
    assert weighted == pytest.approx(frechet_distance(a, repeated), rel=0.1)
    assert frechet_distance(a, b, np.full(20, 3.0)) == pytest.approx(frechet_distance(a, b))


def test_bad_sets_are_refused():
    with pytest.raises(ValueError, match="features"):
        frechet_distance(np.zeros((0, 4)), np.zeros((3, 4)))
    with pytest.raises(ValueError, match="features"):
        frechet_distance(np.zeros((3, 5)), np.zeros((3, 4)))
    with pytest.raises(ValueError, match="weights"):
        frechet_distance(np.zeros((3, 4)), np.zeros((3, 4)), np.zeros(3))
