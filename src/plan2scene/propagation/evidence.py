"""What the house's own photos tell about a surface that none shows: the predictor `house`.

The same kind of surface elsewhere in the house is the best guess there is on real homes: paint and
floors go through rooms, and the photos' light is in it. With few of them, or none, the mean of
training surfaces of the room's type stands in, brought under the house's light.
"""

from __future__ import annotations

import numpy as np

from plan2scene.colour import linear_to_srgb, srgb_to_linear
from plan2scene.house import SURFACES
from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.prior import TypeMeans, room_type_mean

#: Surfaces of the kind that the mean of the room's type counts for.
PRIOR_SURFACES = 0.5


def house_evidence(graph: HouseGraph, means: TypeMeans) -> np.ndarray:
    """Return embeddings of all surfaces, (n, 3, 11) float32, each as if it were not observed."""
    seen = graph.observed
    known = graph.embeddings.astype(np.float64)
    values = room_type_mean(graph, means).astype(np.float64)
    if not seen.any():
        return values.astype(np.float32)
    light = np.median((_log_colour(known) - _log_colour(values))[seen], axis=0)
    values[..., -3:] = _colour(_log_colour(values) + light)
    for j in range(len(SURFACES)):
        shown = known[:, j] * seen[:, j, None]
        count = seen[:, j].sum() - seen[:, j]
        others = shown.sum(axis=0) - shown
        mixed = (others + PRIOR_SURFACES * values[:, j]) / (count + PRIOR_SURFACES)[:, None]
        values[:, j] = np.where(count[:, None] > 0, mixed, values[:, j])
    return values.astype(np.float32)


def _log_colour(embeddings: np.ndarray) -> np.ndarray:
    """Return the log linear RGB (..., 3) of embeddings (..., 11)."""
    return np.log(np.maximum(srgb_to_linear(np.clip(embeddings[..., -3:], 0.0, 1.0)), 1e-3))


def _colour(log: np.ndarray) -> np.ndarray:
    """Return sRGB (..., 3) in [0, 1] of log linear RGB."""
    return linear_to_srgb(np.minimum(np.exp(log), 1.0))
