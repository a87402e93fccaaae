"""FID and KID: how far apart two sets of features are (Heusel et al. 2017, Binkowski et al. 2018).

A sample may belong to a unit, here a surface: each unit counts once, however many samples it has.
torchmetrics has the same figures without units, costs 2.3 s to import, and takes FID's roots of a
product of covariances: 40 times as long for InceptionV3's 2048 features.
"""

from __future__ import annotations

import numpy as np

from plan2scene.metrics.running import RunningGaussian, gaussian_distance

_ROWS = 1024  # of the kernel matrix at once: bounds the memory
_DEGREE = 3


def frechet_distance(
    features_a: np.ndarray,
    features_b: np.ndarray,
    units_a: np.ndarray | None = None,
    units_b: np.ndarray | None = None,
) -> float:
    """Return FID, the squared Frechet distance of two sets taken as Gaussians; 0 is best.

    ``|mean_a - mean_b|^2 + tr(A + B - 2 (A B)^(1/2))`` with the unbiased covariances A and B:
    without units the figure of torchmetrics' ``FrechetInceptionDistance``. It falls with the
    sizes of the sets (:func:`kernel_distance` does not): compare figures of one size only. A
    single sample has no spread: its covariance counts as 0.

    Raises ValueError for an empty set, different dimensions or another number of units.

    Parameters
    ----------
    features_a, features_b : (n, d), (m, d) float
        Predictions and references.
    units_a, units_b : (n,), (m,) array, optional
        What a sample belongs to. None: each sample is a unit.
    """
    a, b = _features(features_a, features_b)
    gaussians = RunningGaussian(), RunningGaussian()
    for gaussian, features, units in zip(gaussians, (a, b), (units_a, units_b), strict=True):
        gaussian.add(features, unit_weights(features, units)[1])
    return gaussian_distance(*gaussians)


def kernel_distance(
    features_a: np.ndarray,
    features_b: np.ndarray,
    units_a: np.ndarray | None = None,
    units_b: np.ndarray | None = None,
) -> float:
    """Return KID, the unbiased squared MMD with the kernel ``(x.y / d + 1)^3``; 0 is best.

    Its expectation does not depend on the sizes of the sets, and it may come out below 0. Samples
    of one unit, which are not independent, are never paired within a set. Without units it is
    torchmetrics' ``KernelInceptionDistance`` of one subset that holds the whole set; with fewer
    than two units in a set it is NaN. Parameters and errors as for :func:`frechet_distance`.
    """
    a, b = _features(features_a, features_b)
    (codes_a, weights_a), (codes_b, weights_b) = unit_weights(a, units_a), unit_weights(b, units_b)
    count_a, count_b = codes_a.max() + 1, codes_b.max() + 1
    if min(count_a, count_b) < 2:
        return float("nan")
    within_a = _kernel_sum(a, a, weights_a, weights_a, codes_a) / (count_a * (count_a - 1))
    within_b = _kernel_sum(b, b, weights_b, weights_b, codes_b) / (count_b * (count_b - 1))
    across = _kernel_sum(a, b, weights_a, weights_b) / (count_a * count_b)
    return float(within_a + within_b - 2.0 * across)


def _features(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (n, d) and (m, d) features as float64."""
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    if a.ndim != 2 or b.ndim != 2 or a.shape[1] != b.shape[1] or not len(a) or not len(b):
        raise ValueError(f"expected (n, d) and (m, d) features, found {a.shape} and {b.shape}")
    return a, b


def unit_weights(features: np.ndarray, units: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the unit of each sample as 0, 1, ... and weights that sum to 1 in each unit."""
    if units is None:
        return np.arange(len(features)), np.ones(len(features))
    if len(units) != len(features):
        raise ValueError(f"expected {len(features)} units, found {len(units)}")
    _, codes, sizes = np.unique(np.asarray(units), return_inverse=True, return_counts=True)
    return codes, 1.0 / sizes[codes]


def _kernel_sum(
    a: np.ndarray,
    b: np.ndarray,
    weights_a: np.ndarray,
    weights_b: np.ndarray,
    units: np.ndarray | None = None,
) -> float:
    """Return the weighted sum of the kernel over all pairs; those of one unit left out if given."""
    total = 0.0
    for start in range(0, len(a), _ROWS):
        rows = slice(start, start + _ROWS)
        kernel = (a[rows] @ b.T / a.shape[1] + 1.0) ** _DEGREE
        if units is not None:
            kernel[units[rows, None] == units[None, :]] = 0.0
        total += float(weights_a[rows] @ kernel @ weights_b)
    return total
