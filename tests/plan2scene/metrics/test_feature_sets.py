import numpy as np
import pytest
import torch
from whole_sets import set_distances

from plan2scene.metrics.feature_sets import kernel_distance


def frechet_distance(a, b, units_a=None, units_b=None):
    return set_distances(a, b, units_a, units_b)["FID"]


def _samples(n, d, seed, mean=0.0, scale=1.0):
    return np.random.default_rng(seed).normal(mean, scale, (n, d))


class Given(torch.nn.Module):
    def __init__(self, dimension):
        super().__init__()
        self.num_features = dimension

    def forward(self, features):
        return features


@pytest.mark.parametrize(("n", "m", "d"), [(300, 200, 8), (9, 30, 16)])
def test_fid_is_that_of_torchmetrics(n, m, d):
    fid = pytest.importorskip("torchmetrics.image.fid")
    a, b = _samples(n, d, 6, 0.4, 2.0), _samples(m, d, 7)
    metric = fid.FrechetInceptionDistance(feature=Given(d), normalize=True)
    metric.set_dtype(torch.float64)
    metric.update(torch.from_numpy(b), real=True)
    metric.update(torch.from_numpy(a), real=False)
    # It takes roots of eigenvalues of the product: rounding shows where that is singular.
    tolerance = 1e-9 if n > d else 1e-5
    assert frechet_distance(a, b) == pytest.approx(float(metric.compute()), rel=tolerance)


def test_each_unit_counts_once_in_fid():
    a, b = _samples(2000, 3, 8), _samples(2000, 3, 9, 0.5)
    units = np.random.default_rng(0).integers(0, 40, 2000) ** 2 // 40  # of 1 to 300 samples
    means = np.stack([b[units == unit].mean(axis=0) for unit in np.unique(units)])
    # Moving the first set to the units' mean leaves what does not depend on means.
    moved = frechet_distance(a - a.mean(axis=0) + means.mean(axis=0), b, None, units)
    centred = frechet_distance(a - a.mean(axis=0), b - means.mean(axis=0), None, units)
    assert moved == pytest.approx(centred, rel=1e-9)
    plain = frechet_distance(a, b)
    assert abs(frechet_distance(a, b, None, units) / plain - 1) > 1e-3
    assert frechet_distance(a, b, None, np.arange(2000)) == pytest.approx(plain)
    pairs = np.repeat(b, 2, axis=0)  # but for the unbiased covariance's n / (n - 1)
    assert frechet_distance(a, pairs, None, np.arange(4000) // 2) == pytest.approx(plain, rel=1e-3)


def test_kid_is_that_of_torchmetrics_over_the_whole_sets():
    kid = pytest.importorskip("torchmetrics.image.kid")
    a, b = _samples(40, 12, 1, 0.5), _samples(40, 12, 2)
    expected = float(kid.poly_mmd(torch.from_numpy(b), torch.from_numpy(a)))
    each = np.arange(40)
    assert kernel_distance(a, b, each, each) == pytest.approx(expected, rel=1e-9)
    assert set_distances(a, b)["KID"] == pytest.approx(expected, rel=1e-6)
