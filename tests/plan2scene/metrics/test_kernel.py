"""KID against torchmetrics, its definition, and what it promises about size and units."""

import numpy as np
import pytest

from plan2scene.metrics import kernel as module
from plan2scene.metrics.kernel import kernel_distance


def _samples(n, d, seed, mean=0.0):
    return np.random.default_rng(seed).normal(mean, 1.0, (n, d))


def test_is_that_of_torchmetrics_over_the_whole_sets():
    torch = pytest.importorskip("torch")
    kid = pytest.importorskip("torchmetrics.image.kid")
    a, b = _samples(40, 12, 1, 0.5), _samples(40, 12, 2)
    torch_a, torch_b = torch.from_numpy(a), torch.from_numpy(b)
    assert kernel_distance(a, b) == pytest.approx(float(kid.poly_mmd(torch_b, torch_a)), rel=1e-9)

    class Given(torch.nn.Module):
        """Takes (n, d) features as they are."""

        num_features = 12

        def forward(self, features):
            return features

    metric = kid.KernelInceptionDistance(feature=Given(), subsets=1, subset_size=40)
    metric.update(torch_b.float(), real=True)
    metric.update(torch_a.float(), real=False)
    assert kernel_distance(a, b) == pytest.approx(float(metric.compute()[0]), rel=1e-4)


def test_does_not_depend_on_size():
    # Half of one population against the other half: around 0 at any size, above and below.
    for size in (10, 40):
        values = [
            kernel_distance(_samples(size, 4, 100 + i), _samples(size, 4, 500 + i))
            for i in range(200)
        ]
        error = np.std(values) / np.sqrt(len(values))
        assert abs(np.mean(values)) < 3 * error
        assert min(values) < 0 < max(values)


def test_units_count_once_and_are_not_paired_with_themselves():
    a, b = _samples(3, 5, 3), _samples(6, 5, 4)
    units = np.array(["w", "w", "w", "x", "y", "y"])

    def k(x, y):
        return (x @ y / 5 + 1) ** 3

    groups = [b[units == name] for name in "wxy"]
    within_b = np.mean(
        [
            np.mean([k(x, y) for x in groups[i] for y in groups[j]])
            for i in range(3)
            for j in range(3)
            if i != j
        ]
    )
    within_a = np.mean([k(a[i], a[j]) for i in range(3) for j in range(3) if i != j])
    across = np.mean([np.mean([k(x, y) for x in a for y in group]) for group in groups])
    expected = within_a + within_b - 2 * across
    assert kernel_distance(a, b, None, units) == pytest.approx(expected, rel=1e-12)
    assert kernel_distance(b, a, units, None) == pytest.approx(expected, rel=1e-12)


def test_rows_of_the_kernel_in_parts_are_the_whole(monkeypatch):
    a, b = _samples(20, 5, 5), _samples(23, 5, 6)
    units = np.arange(23) // 2
    whole = kernel_distance(a, b, None, units)
    monkeypatch.setattr(module, "_ROWS", 7)
    assert kernel_distance(a, b, None, units) == pytest.approx(whole, rel=1e-12)


def test_fewer_than_two_units_have_no_value():
    a, b = _samples(4, 3, 7), _samples(5, 3, 8)
    assert np.isnan(kernel_distance(a[:1], b))
    assert np.isnan(kernel_distance(a, b, None, np.zeros(5)))


def test_bad_sets_are_refused():
    with pytest.raises(ValueError, match="features"):
        kernel_distance(np.zeros((0, 4)), np.zeros((3, 4)))
    with pytest.raises(ValueError, match="units"):
        kernel_distance(np.zeros((3, 4)), np.zeros((3, 4)), np.zeros(2))
