"""Mean embeddings of training surfaces by room type, as predictions for unobserved surfaces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from plan2scene.house import ROOM_TYPES, SURFACES


@dataclass(frozen=True)
class TypeMeans:
    """Mean embeddings over training surfaces."""

    #: (12, 3, 11) float32, by room type and surface; over all types where a type has no sample
    embedding: np.ndarray
    naive: np.ndarray  #: (12, 3, 8) float32, the same for the NaiveSynth model's code

    def predict(self, types: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the (3, 11) and (3, 8) means for a room with these types (12,), multi-hot."""
        return self.embedding[types > 0].mean(axis=0), self.naive[types > 0].mean(axis=0)


def mean_by_type(types: np.ndarray, surface: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return means (12, 3, d) of `values` (n, d) float32 by room type and surface.

    `types` are (n, 12), multi-hot; `surface` (n,) int is an index into ``SURFACES``.
    """
    result = np.zeros((len(ROOM_TYPES), len(SURFACES), values.shape[1]), dtype=np.float32)
    for j in range(len(SURFACES)):
        rows = surface == j
        overall = values[rows].mean(axis=0) if rows.any() else np.zeros(values.shape[1])
        for i in range(len(ROOM_TYPES)):
            type_rows = rows & (types[:, i] > 0)
            result[i, j] = values[type_rows].mean(axis=0) if type_rows.any() else overall
    return result
