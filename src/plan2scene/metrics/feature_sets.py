"""FID and KID: how far apart two sets of features are (Heusel et al. 2017, Binkowski et al. 2018).

A sample belongs to a unit, here a surface: each unit counts once, however many samples it has.
torchmetrics computes the same values without units. Its import takes 2.3 s, and for FID it takes
the root of a product of covariances: 40 times as long for InceptionV3's 2048 features.

:class:`SurfaceDistances` adds houses one by one; its memory does not grow with their number.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from plan2scene.errors import InputError

#: Most dimensions of features for :class:`ExactKernel`: third moments take d^3 / 2 numbers.
MAX_MOMENTS_DIMENSION = 128
BLOCK_SURFACES = 1000  #: Number of surfaces from which on a block of :class:`BlockKernel` ends
_ROWS = 1024  # rows of the kernel matrix (and samples of moments) at a time: bounds the memory
_DEGREE = 3  # of KID's kernel


def kernel_distance(
    a: np.ndarray, b: np.ndarray, units_a: np.ndarray, units_b: np.ndarray
) -> float:
    """Return KID, the unbiased squared MMD with the kernel ``(x.y / d + 1)^3``; 0 is best.

    `a` are predictions (n, d), `b` references (m, d); their units are (n,) and (m,). The
    expectation of KID does not depend on the sizes of the sets; KID may be negative. Samples of one
    unit are not independent, so they are never paired within a set. If each sample is a unit, KID
    equals torchmetrics' ``KernelInceptionDistance`` with one subset that holds the whole set. KID
    is NaN if a set has fewer than two units.
    """
    a, b = a.astype(np.float64), b.astype(np.float64)
    (codes_a, weights_a), (codes_b, weights_b) = unit_weights(units_a), unit_weights(units_b)
    count_a, count_b = codes_a.max() + 1, codes_b.max() + 1
    if min(count_a, count_b) < 2:
        return float("nan")
    within_a = _kernel_sum(a, a, weights_a, weights_a, codes_a) / (count_a * (count_a - 1))
    within_b = _kernel_sum(b, b, weights_b, weights_b, codes_b) / (count_b * (count_b - 1))
    across = _kernel_sum(a, b, weights_a, weights_b) / (count_a * count_b)
    return float(within_a + within_b - 2.0 * across)


def unit_weights(units: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the unit of each sample as 0, 1, ... and weights that sum to 1 in each unit."""
    _, codes, sizes = np.unique(units, return_inverse=True, return_counts=True)
    return codes, 1.0 / sizes[codes]


def _kernel_sum(
    a: np.ndarray,
    b: np.ndarray,
    weights_a: np.ndarray,
    weights_b: np.ndarray,
    units: np.ndarray | None = None,
) -> float:
    """Return the weighted sum of the kernel over all pairs of samples of different `units`."""
    total = 0.0
    for start in range(0, len(a), _ROWS):
        rows = slice(start, start + _ROWS)
        kernel = (a[rows] @ b.T / a.shape[1] + 1.0) ** _DEGREE
        if units is not None:
            kernel[units[rows, None] == units[None, :]] = 0.0
        total += float(weights_a[rows] @ kernel @ weights_b)
    return total


class RunningGaussian:
    """Mean and covariance of weighted samples, in a memory of about ``3 (d + 1)^2`` numbers.

    The rows X = ``sqrt(w) [1, x]`` are replaced by the factor R of their QR decomposition, because
    R'R = X'X. The first row of R holds the weight and the mean, the others are a root of the
    centred scatter matrix. So large sums are never subtracted, and a singular covariance is no
    special case.
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
    """Return FID, the squared Frechet distance of two Gaussians; 0 is best.

    ``|mean_a - mean_b|^2 + tr(A + B - 2 (A B)^(1/2))`` with the unbiased covariances A and B, as
    torchmetrics' ``FrechetInceptionDistance``. It falls as the sets grow: compare only values for
    sets of one size. The covariance of a single sample counts as 0.
    """
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
        # Each pair i < j stands for both orders, so its products need a factor of 2.
        self._scale = np.where(self._first == self._second, 1.0, np.sqrt(2.0))
        pairs = len(self._first)
        self.units = 0
        self._own = 0.0
        self._moments = [np.zeros(1), np.zeros(dimension), np.zeros(pairs)]
        self._moments.append(np.zeros((dimension, pairs)))

    def add(self, features: np.ndarray, units: np.ndarray, weights: np.ndarray) -> None:
        """Add (n, d) float64 features of units (n,); all samples of a unit come in one call.

        Weights (n,) sum to 1 in each unit.
        """
        scaled = features / np.sqrt(features.shape[1])
        self.units += len(np.unique(units))
        for start in range(0, len(scaled), _ROWS):
            rows = slice(start, start + _ROWS)
            block, weighted = scaled[rows], weights[rows, None] * scaled[rows]
            pairs = block[:, self._first] * block[:, self._second] * self._scale
            parts = (weights[rows].sum(), weighted.sum(axis=0), weights[rows] @ pairs)
            for moment, part in zip(self._moments, (*parts, weighted.T @ pairs), strict=True):
                moment += part
            kernel = (block @ scaled.T + 1.0) ** _DEGREE * (units[rows, None] == units[None, :])
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


class SurfaceDistances:
    """FID and KID of measured surfaces, to which houses are added one by one."""

    def __init__(self) -> None:
        self._gaussians = RunningGaussian(), RunningGaussian()
        self._kernel: ExactKernel | BlockKernel | None = None

    def add(self, images: Sequence[np.ndarray], crops: Sequence[np.ndarray]) -> None:
        """Add a house's surfaces: for each the features (k, d) of its images, and of its crops.

        A surface without crops is left out of `crops`.
        """
        for side, groups in enumerate((images, crops)):
            if not groups:
                continue
            features = np.concatenate(groups).astype(np.float64)
            units = np.repeat(np.arange(len(groups)), [len(group) for group in groups])
            self._gaussians[side].add(features, unit_weights(units)[1])
            if self._kernel is None:
                small = features.shape[1] <= MAX_MOMENTS_DIMENSION
                self._kernel = ExactKernel(features.shape[1]) if small else BlockKernel()
            self._kernel.add(side, features, units)

    def values(self) -> dict[str, float]:
        """Return ``FID`` and ``KID``; InputError without any crop."""
        if self._kernel is None or not self._gaussians[1].count:
            raise InputError("reference features of the measured surfaces", "none")
        return {"FID": gaussian_distance(*self._gaussians), "KID": self._kernel.value()}


class ExactKernel:
    """KID of two whole sets."""

    def __init__(self, dimension: int) -> None:
        self._sets = KernelMoments(dimension), KernelMoments(dimension)

    def add(self, side: int, features: np.ndarray, units: np.ndarray) -> None:
        """Add features of whole units to the images (side 0) or crops (1)."""
        self._sets[side].add(features, units, unit_weights(units)[1])

    def value(self) -> float:
        """Return KID; NaN with fewer than two surfaces."""
        a, b = self._sets
        if min(a.units, b.units) < 2:
            return float("nan")
        return a.within() + b.within() - 2.0 * a.across(b) / (a.units * b.units)


class BlockKernel:
    """KID as the mean over blocks of whole houses, each with 1,000 surfaces or somewhat more.

    It is for features with too many dimensions for :class:`ExactKernel`. With one block it is the
    KID of the whole sets; the mean over several blocks has the same expectation.
    """

    def __init__(self) -> None:
        self._held: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
        self._units: tuple[list[np.ndarray], list[np.ndarray]] = ([], [])
        self._counts = [0, 0]
        self._sum = self._weight = 0.0

    def add(self, side: int, features: np.ndarray, units: np.ndarray) -> None:
        """Add features of a house's surfaces to the images (side 0, first) or crops (1)."""
        if side == 0 and self._counts[0] >= BLOCK_SURFACES:
            self._close()
        self._held[side].append(features.astype(np.float32))
        self._units[side].append(units + self._counts[side])
        self._counts[side] += int(units[-1]) + 1

    def _close(self) -> None:
        """Add the block's KID to the mean, unless it has too few surfaces; start a new block."""
        if min(self._counts) >= 2:
            sets = [np.concatenate(parts) for parts in (*self._held, *self._units)]
            self._sum += self._counts[0] * kernel_distance(*sets)
            self._weight += self._counts[0]
        self._held, self._units, self._counts = ([], []), ([], []), [0, 0]

    def value(self) -> float:
        """Return KID; NaN if no block has two surfaces."""
        self._close()
        return self._sum / self._weight if self._weight else float("nan")
