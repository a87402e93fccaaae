"""The paper's table 1 (CVPR 2021, test split of Rent3D++, 43 houses; lower is better)."""

from __future__ import annotations

from collections.abc import Mapping

#: Metrics in the paper's order.
METRICS = ("COLOR", "FREQ", "SUBS", "FID", "TILE")
#: Columns: surfaces observed at drop 0.0, and those unobserved and all at drop 0.6.
TABLE_COLUMNS = ("observed", "unobserved", "all")
#: ``PUBLISHED[method][column]`` in the order of :data:`METRICS`. SUBS is by VGG-16 and FID by
#: InceptionV3.
PUBLISHED: Mapping[str, Mapping[str, tuple[float, ...]]] = {
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
