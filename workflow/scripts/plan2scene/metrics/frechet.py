"""Frechet distance of feature sets: FID with InceptionV3 features (Heusel et al. 2017)."""

from __future__ import annotations

import numpy as np


def frechet_distance(
    features_a: np.ndarray, features_b: np.ndarray, weights_b: np.ndarray | None = None
) -> float:
    """Return the squared Frechet distance of two feature sets taken as Gaussians; 0 is best.

    ``|mean_a - mean_b|^2 + tr(A + B - 2 (A B)^(1/2))`` with the covariances A and B. Sets smaller
    than the features' dimension d leave a covariance singular and its estimate wild; both are
    therefore shrunk towards their own diagonal by the share ``d / (d + n)`` with n the smaller
    set's (effective) size, which keeps their traces and gives 0 for equal sets. The distance
    still falls with n: compare figures of one n only.

    Parameters
    ----------
    features_a : (n, d) float
        Predictions.
    features_b : (m, d) float
        References.
    weights_b : (m,) float, optional
        Non-negative weights of the references (equal when None); their scale is of no matter.

    Raises
    ------
    ValueError
        For an empty set or different dimensions.
    """
    a = np.asarray(features_a, dtype=np.float64)
    b = np.asarray(features_b, dtype=np.float64)
    if a.ndim != 2 or b.ndim != 2 or a.shape[1] != b.shape[1] or not len(a) or not len(b):
        raise ValueError(f"expected (n, d) and (m, d) features, found {a.shape} and {b.shape}")
    weights = np.ones(len(b)) if weights_b is None else np.asarray(weights_b, dtype=np.float64)
    mean_a, covariance_a, size_a = _moments(a, np.ones(len(a)))
    mean_b, covariance_b, size_b = _moments(b, weights)
    dimension = a.shape[1]
    share = dimension / (dimension + min(size_a, size_b))
    covariance_a, covariance_b = (
        (1.0 - share) * c + share * np.diag(np.diag(c)) for c in (covariance_a, covariance_b)
    )
    distance = ((mean_a - mean_b) ** 2).sum() + np.trace(covariance_a) + np.trace(covariance_b)
    distance -= 2.0 * _trace_root_of_product(covariance_a, covariance_b)
    return float(max(distance, 0.0))  # rounding of the eigenvalues may leave -1e-12


def _moments(features: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray, float]:
    """Return weighted mean (d,), covariance (d, d) and effective size of (n, d) features."""
    if weights.shape != (len(features),) or (weights < 0).any() or weights.sum() <= 0:
        raise ValueError(f"expected {len(features)} non-negative weights, some above 0")
    share = weights / weights.sum()
    mean = share @ features
    centred = features - mean
    covariance = (centred * share[:, None]).T @ centred
    return mean, covariance, float(1.0 / (share**2).sum())


def _trace_root_of_product(a: np.ndarray, b: np.ndarray) -> float:
    """Return the trace of the square root of a b for symmetric positive semi-definite a, b.

    Through the symmetric a^(1/2) b a^(1/2), which has the same eigenvalues and, unlike a b
    itself, stays real where a covariance is singular.
    """
    values, vectors = np.linalg.eigh(a)
    root = (vectors * np.sqrt(np.clip(values, 0.0, None))) @ vectors.T
    eigenvalues = np.linalg.eigvalsh(root @ b @ root)
    return float(np.sqrt(np.clip(eigenvalues, 0.0, None)).sum())
