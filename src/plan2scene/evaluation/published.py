"""The paper's table 1 (CVPR 2021, test split of Rent3D++, 43 houses; lower is better)."""

from __future__ import annotations

from collections.abc import Mapping

_PAPER_METRICS = ("COLOR", "FREQ", "SUBS", "FID", "TILE")
#: The networks of the published figures; ours by another one are not of their scale.
PUBLISHED_NETWORKS: Mapping[str, str] = {"SUBS": "vgg16", "FID": "inception"}
#: Columns: surfaces observed at drop 0.0, and those unobserved and all at drop 0.6.
TABLE_COLUMNS = ("observed", "unobserved", "all")
#: ``_TABLE[method][column]`` in the paper's order. SUBS is by VGG-16 and FID by InceptionV3.
_TABLE: Mapping[str, Mapping[str, tuple[float, ...]]] = {
    "crop": {
        "observed": (0.0, 0.0, 0.0, 0.0, 38.1),
        "unobserved": (0.768, 0.026, 0.345, 57.2, 40.6),
        "all": (0.459, 0.016, 0.208, 35.6, 39.5),
    },
    "retrieve": {
        "observed": (0.561, 0.054, 0.473, 238.2, 17.3),
        "unobserved": (0.751, 0.040, 0.437, 261.5, 19.1),
        "all": (0.680, 0.046, 0.458, 243.2, 18.3),
    },
    "naivesynth": {
        "observed": (0.694, 0.046, 0.385, 239.3, 21.7),
        "unobserved": (0.714, 0.044, 0.427, 245.4, 19.8),
        "all": (0.709, 0.046, 0.404, 239.4, 20.6),
    },
    "synth": {
        "observed": (0.431, 0.035, 0.350, 196.1, 16.4),
        "unobserved": (0.653, 0.032, 0.393, 199.4, 18.6),
        "all": (0.591, 0.034, 0.392, 196.2, 17.6),
    },
}


def published_value(method: str, column: str, metric: str) -> float:
    """Return the paper's figure; NaN for a method or metric that it does not have."""
    if method not in _TABLE or metric not in _PAPER_METRICS:
        return float("nan")
    return _TABLE[method][column][_PAPER_METRICS.index(metric)]


def comparable(metric: str, network: str) -> bool:
    """Return whether a figure made with `network` is of the published figures' scale."""
    return PUBLISHED_NETWORKS.get(metric, network) == network
