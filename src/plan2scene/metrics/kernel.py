"""KID: squared maximum mean discrepancy of two feature sets (Binkowski et al. 2018).

Not torchmetrics' for what :mod:`.frechet` says: it knows no units that count once.
"""

from __future__ import annotations

import numpy as np

_ROWS = 1024  # of the kernel matrix at once: bounds the memory
_DEGREE = 3


def kernel_distance(
    features_a: np.ndarray,
    features_b: np.ndarray,
    units_a: np.ndarray | None = None,
    units_b: np.ndarray | None = None,
) -> float:
    """Return the unbiased squared MMD with the kernel ``(x.y / d + 1)^3``; 0 is best.

    Its expectation does not depend on the sizes of the sets, and it may come out below 0. Where
    every sample is a unit of its own it is torchmetrics' ``KernelInceptionDistance`` of one subset
    that holds the whole set.

    Parameters
    ----------
    features_a, features_b : (n, d), (m, d) float
        Predictions and references.
    units_a, units_b : (n,), (m,) array, optional
        What a sample belongs to (a surface): units count once however many samples they have, and
        samples of one unit, which are not independent, are never paired within a set. None: each
        sample is a unit.

    Returns
    -------
    float
        NaN where a set has fewer than two units.

    Raises
    ------
    ValueError
        For an empty set or different dimensions.
    """
    a = np.asarray(features_a, dtype=np.float64)
    b = np.asarray(features_b, dtype=np.float64)
    if a.ndim != 2 or b.ndim != 2 or a.shape[1] != b.shape[1] or not len(a) or not len(b):
        raise ValueError(f"expected (n, d) and (m, d) features, found {a.shape} and {b.shape}")
    codes_a, weights_a = _units(a, units_a)
    codes_b, weights_b = _units(b, units_b)
    count_a, count_b = codes_a.max() + 1, codes_b.max() + 1
    if min(count_a, count_b) < 2:
        return float("nan")
    within_a = _kernel_sum(a, a, weights_a, weights_a, codes_a) / (count_a * (count_a - 1))
    within_b = _kernel_sum(b, b, weights_b, weights_b, codes_b) / (count_b * (count_b - 1))
    across = _kernel_sum(a, b, weights_a, weights_b) / (count_a * count_b)
    return float(within_a + within_b - 2.0 * across)


def _units(features: np.ndarray, units: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
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
