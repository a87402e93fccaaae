"""The Frechet distance against closed forms and torchmetrics, singular covariances too."""

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
    expected = (a.mean() - b.mean()) ** 2 + (a.std(ddof=1) - b.std(ddof=1)) ** 2
    assert frechet_distance(a, b) == pytest.approx(expected, rel=1e-9)


def test_agrees_with_the_matrix_square_root():
    rng = np.random.default_rng(5)
    a = rng.normal(size=(500, 4)) @ rng.normal(size=(4, 4))
    b = rng.normal(size=(500, 4)) @ rng.normal(size=(4, 4)) + 1.0
    covariances = [np.cov(features.T) for features in (a, b)]
    root = sqrtm(covariances[0] @ covariances[1]).real
    expected = ((a.mean(0) - b.mean(0)) ** 2).sum()
    expected += np.trace(covariances[0] + covariances[1] - 2 * root)
    assert frechet_distance(a, b) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(("n", "m", "d"), [(300, 200, 8), (40, 90, 24), (9, 30, 16)])
def test_is_that_of_torchmetrics(n, m, d):
    torch = pytest.importorskip("torch")
    fid = pytest.importorskip("torchmetrics.image.fid")

    class Given(torch.nn.Module):
        """Takes (n, d) features as they are."""

        num_features = d

        def forward(self, features):
            return features

    a, b = _samples(n, d, 6, 0.4, 2.0), _samples(m, d, 7)
    metric = fid.FrechetInceptionDistance(feature=Given(), normalize=True).set_dtype(torch.float64)
    metric.update(torch.from_numpy(b), real=True)
    metric.update(torch.from_numpy(a), real=False)
    # It takes roots of eigenvalues of the product: rounding shows where that is singular.
    tolerance = 1e-9 if n > d else 1e-5
    assert frechet_distance(a, b) == pytest.approx(float(metric.compute()), rel=tolerance)


def test_symmetric_and_finite_with_fewer_samples_than_dimensions():
    a, b = _samples(7, 64, 6), _samples(90, 64, 7, 0.3)
    forth, back = frechet_distance(a, b), frechet_distance(b, a)
    assert np.isfinite(forth)
    assert forth == pytest.approx(back, rel=1e-6)
    assert forth > 0


def test_weights_count_like_repetitions():
    a, b = _samples(6000, 3, 8), _samples(2000, 3, 9, 0.5)
    rng = np.random.default_rng(0)
    counts_a, counts_b = rng.integers(1, 5, 6000), rng.integers(1, 5, 2000)
    weighted = frechet_distance(a, b, counts_b.astype(float), counts_a.astype(float))
    repeated = frechet_distance(np.repeat(a, counts_a, axis=0), np.repeat(b, counts_b, axis=0))
    # They differ by the unbiased covariance's n / (n - 1), which takes rows for n.
    assert weighted == pytest.approx(repeated, rel=1e-3)
    assert abs(weighted / frechet_distance(a, b) - 1) > 2e-3
    plain = frechet_distance(a, b)
    assert frechet_distance(a, b, np.full(2000, 3.0)) == pytest.approx(plain)


def test_bad_sets_are_refused():
    with pytest.raises(ValueError, match="features"):
        frechet_distance(np.zeros((0, 4)), np.zeros((3, 4)))
    with pytest.raises(ValueError, match="features"):
        frechet_distance(np.zeros((3, 5)), np.zeros((3, 4)))
    with pytest.raises(ValueError, match="weights"):
        frechet_distance(np.zeros((3, 4)), np.zeros((3, 4)), np.zeros(3))
