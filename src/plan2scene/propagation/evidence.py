"""What the house's own photos tell about a surface that none shows: the predictor `house`.

The same kind of surface elsewhere in the house is the best guess there is on real homes: paint and
floors go through rooms, and the photos' light is in it. With few of them, or none, the mean of
training surfaces of the room's type stands in, brought under the house's light. Colours follow the
light of the surface's room, too (:func:`plan2scene.paint.light.expected_colours`).
"""

from __future__ import annotations

import numpy as np

from plan2scene.house import SURFACES
from plan2scene.paint.light import expected_colours
from plan2scene.paint.observations import HouseColours
from plan2scene.propagation.graph import HouseGraph
from plan2scene.propagation.prior import TypeMeans, room_type_mean

#: Surfaces of the kind that the mean of the room's type counts for.
PRIOR_SURFACES = 0.5


def house_evidence(graph: HouseGraph, means: TypeMeans, photo_colours: HouseColours) -> np.ndarray:
    """Return embeddings of all surfaces, (n, 3, 11) float32, each as if it were not observed.

    Colours come from `photo_colours`, the rest from the graph's observed surfaces.
    """
    seen = graph.observed
    known = graph.embeddings.astype(np.float64)
    values = room_type_mean(graph, means).astype(np.float64)
    colours = expected_colours(photo_colours, values[..., -3:], as_if_unseen=True)
    for j in range(len(SURFACES)):
        others = (known[:, j] * seen[:, j, None]).sum(axis=0) - known[:, j] * seen[:, j, None]
        count = seen[:, j].sum() - seen[:, j]
        mixed = (others + PRIOR_SURFACES * values[:, j]) / (count + PRIOR_SURFACES)[:, None]
        values[:, j] = np.where(count[:, None] > 0, mixed, values[:, j])
    values[..., -3:] = colours
    return values.astype(np.float32)
