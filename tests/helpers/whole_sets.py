import numpy as np

from plan2scene.metrics.feature_sets import SurfaceDistances


def set_distances(a, b, units_a=None, units_b=None):
    """Return FID and KID of features (n, d) and (m, d) of units; None: each is one of its own."""
    groups = []
    for features, units in ((a, units_a), (b, units_b)):
        codes = np.arange(len(features)) if units is None else units
        groups.append([features[codes == code] for code in np.unique(codes)])
    distances = SurfaceDistances()
    distances.add(*groups)
    return distances.values()
