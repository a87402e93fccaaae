"""Substances of floors, walls and ceilings: from their look and from what is usual in a room."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas as pd

    from plan2scene.house import House

#: Prior of each substance by kind of surface, in the order of ``house.SUBSTANCES``: a ceiling is
#: almost never carpet, for example, even if a photo makes it look so.
SUBSTANCES_OF = {
    "floor": (0.45, 0.03, 0.26, 0.26),
    "wall": (0.02, 0.92, 0.002, 0.058),
    "ceiling": (0.025, 0.965, 0.001, 0.009),
}
#: Prior of floors in types of rooms that have a usual floor of their own, unlike the other rooms.
FLOORS_OF = {
    "Bathroom": (0.06, 0.02, 0.03, 0.89),
    "Outdoor": (0.2, 0.25, 0.01, 0.54),
    "Terrace": (0.2, 0.25, 0.01, 0.54),
    "Balcony": (0.2, 0.25, 0.01, 0.54),
}
#: The substance head is overconfident on real photos: its logits are divided by this.
TEMPERATURE = 3.0


def usual_shares(surface: str, types: Collection[str] = ()) -> np.ndarray:
    """Return the prior (4,) of the substances of a kind of surface in a room of these types."""
    rooms = [FLOORS_OF.get(name, SUBSTANCES_OF["floor"]) for name in types]
    if surface != "floor" or not rooms:
        return np.array(SUBSTANCES_OF[surface])
    return np.mean(rooms, axis=0)


def on_surfaces(probabilities: np.ndarray, surfaces: Sequence[str]) -> np.ndarray:
    """Return substance probabilities (..., n, 4), given the kind of each of the n surfaces."""
    if not probabilities.size:
        return probabilities
    return weighed(probabilities, np.array([usual_shares(surface) for surface in surfaces]))


def weighed(probabilities: np.ndarray, usual: np.ndarray) -> np.ndarray:
    """Return substance probabilities (..., 4), given the prior `usual` (..., 4).

    Bayes' rule: the texture model's probabilities, softened by `TEMPERATURE`, times the prior.
    """
    posterior = np.maximum(probabilities, 1e-12) ** (1.0 / TEMPERATURE) * usual
    return np.asarray(posterior / posterior.sum(axis=-1, keepdims=True), dtype=np.float32)


def jointed_floors(embeddings: pd.DataFrame, house: House) -> dict[str, tuple[float, float]]:
    """Return by room the probabilities that its floor is wood and tiles, from its crops' rows."""
    floor_probabilities = {}
    floors = embeddings[embeddings["crop_id"].str.startswith("floor/")]
    for room, rows in floors.groupby("room_id"):
        prior = usual_shares("floor", house.room(str(room)).types)
        shares = weighed(np.stack(rows["substance_probabilities"].to_list()), prior).mean(axis=0)
        floor_probabilities[str(room)] = float(shares[0]), float(shares[3])
    return floor_probabilities
