"""FID and KID of sets that come in parts: nothing grows with their sizes."""

from __future__ import annotations

import numpy as np

#: Features of more dimensions have too many third moments (d^3 / 2 numbers).
MAX_MOMENTS_DIMENSION = 128
_ROWS = 1024  # of third moments at once: bounds the memory


class RunningGaussian:
    """Mean and covariance of weighted samples: some ``3 (d + 1)^2`` numbers are held.

    Rows ``sqrt(w) [1, x]`` are replaced by the R of their QR decomposition, which has the same
    products. Its first row then holds the weight and the mean, the rest a root of the centred
    scatter: no difference of large sums is ever taken, and a singular covariance is no special
    case.
    """

    def __init__(self) -> None:
        self.count = 0
        self._parts: list[np.ndarray] = []
        self._held = 0

    def add(self, features: np.ndarray, weights: np.ndarray) -> None:
        """Add (n, d) float64 features of weights (n,)."""
        rows = np.hstack([np.ones((len(features), 1)), features]) * np.sqrt(weights)[:, None]
        self._parts.append(rows)
        self.count += len(rows)
        self._held += len(rows)
        if self._held > 2 * rows.shape[1]:
            self._parts = [self._reduced()]
            self._held = len(self._parts[0])

    def _reduced(self) -> np.ndarray:
        return np.asarray(np.linalg.qr(np.concatenate(self._parts), mode="r"))

    def moments(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the mean (d,) and a root (k, d) P of the unbiased covariance P'P."""
        rows = self._reduced()
        unbiased = self.count / (self.count - 1) if self.count > 1 else 0.0
        root = rows[1:, 1:] * (np.sqrt(unbiased) / rows[0, 0])
        return rows[0, 1:] / rows[0, 0], root if len(root) else np.zeros((1, root.shape[1]))


def gaussian_distance(a: RunningGaussian, b: RunningGaussian) -> float:
    """Return FID, the squared Frechet distance of two Gaussians."""
    (mean_a, root_a), (mean_b, root_b) = a.moments(), b.moments()
    # With A = P'P and B = Q'Q the trace of the root of AB is the sum of the singular values of PQ'.
    overlap = np.linalg.svd(root_a @ root_b.T, compute_uv=False).sum()
    distance = ((mean_a - mean_b) ** 2).sum() + (root_a**2).sum() + (root_b**2).sum()
    return float(max(distance - 2.0 * overlap, 0.0))  # rounding may leave -1e-12


class KernelMoments:
    """Sums of KID's kernel ``(x.y / d + 1)^3`` over pairs of one set, or of two.

    The kernel is a polynomial, so the sum over all pairs is a product of the sets' moments up to
    the third order: exact, and of linear cost.
    """

    def __init__(self, dimension: int) -> None:
        self._first, self._second = np.triu_indices(dimension)
        # Pairs stand for both orders; the scale makes products those of x.y / d.
        self._scale = np.where(self._first == self._second, 1.0, np.sqrt(2.0))
        pairs = len(self._first)
        self.units = 0
        self._own = 0.0
        self._moments = [np.zeros(1), np.zeros(dimension), np.zeros(pairs)]
        self._moments.append(np.zeros((dimension, pairs)))

    def add(self, features: np.ndarray, units: np.ndarray, weights: np.ndarray) -> None:
        """Add (n, d) float64 features of units (n,); all samples of a unit come at once.

        Weights (n,) sum to 1 in each unit.
        """
        scaled = features / np.sqrt(features.shape[1])
        self.units += len(np.unique(units))
        for start in range(0, len(scaled), _ROWS):
            rows = slice(start, start + _ROWS)
            own, weighted = scaled[rows], weights[rows, None] * scaled[rows]
            pairs = own[:, self._first] * own[:, self._second] * self._scale
            parts = (weights[rows].sum(), weighted.sum(axis=0), weights[rows] @ pairs)
            for moment, part in zip(self._moments, (*parts, weighted.T @ pairs), strict=True):
                moment += part
            kernel = (own @ scaled.T + 1.0) ** 3 * (units[rows, None] == units[None, :])
            self._own += float(weights[rows] @ kernel @ weights)

    def across(self, other: KernelMoments) -> float:
        """Return the weighted sum of the kernel over all pairs of two sets."""
        products = [
            float((a * b).sum()) for a, b in zip(self._moments, other._moments, strict=True)
        ]
        return float(np.dot((1.0, 3.0, 3.0, 1.0), products))

    def within(self) -> float:
        """Return the mean of the kernel over the pairs of different units of the set."""
        return (self.across(self) - self._own) / (self.units * (self.units - 1))


def moments_distance(a: KernelMoments, b: KernelMoments) -> float:
    """Return KID of two sets; NaN with fewer than two units in one."""
    if min(a.units, b.units) < 2:
        return float("nan")
    return a.within() + b.within() - 2.0 * a.across(b) / (a.units * b.units)
